import copy
import tomllib
from pathlib import Path

import pytest

from codend.errors import InputError
from codend.plan.plan import load_plan, plan_from_dict
from tests.bad_plans import VALID_PLAN, assert_is_one_clear_line


@pytest.fixture
def plan_file(tmp_path: Path) -> Path:
    path = tmp_path / "plan.toml"
    path.write_text(VALID_PLAN, encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def valid() -> dict:
    return tomllib.loads(VALID_PLAN)


def test_an_override_reaches_any_key_and_leaves_the_others(plan_file: Path):
    plan = load_plan(plan_file)
    changed = load_plan(plan_file, ["netting.1.twine_mm=5", "tow.speed_m_s=[1.0, 2]", 'title="a = b"'])
    assert changed.netting[1].twine_mm == 5.0
    assert changed.tow.speed_m_s == (1.0, 2.0)
    assert changed.title == "a = b"
    assert changed.netting[0] == plan.netting[0]
    assert load_plan(plan_file, ["catch.filled_meshes.1=30"]).catch.sizes == (20.0, 30.0, 60.0)


def test_an_override_may_write_text_with_or_without_quotes(plan_file: Path):
    assert load_plan(plan_file, ["netting.0.mesh=t90"]) == load_plan(plan_file, ['netting.0.mesh="t90"'])


def test_an_override_makes_the_table_it_needs(valid: dict):
    short = {key: table for key, table in valid.items() if key not in ("drag", "model")}
    assert plan_from_dict(short, overrides=["drag.law=bessonneau-1997"]).drag.coefficients == (1.2, 0.1)


def test_an_override_takes_the_place_of_the_key_it_excludes(plan_file: Path):
    catch = load_plan(plan_file, ["catch.volume_m3=0.1"]).catch
    assert (catch.kind, catch.sizes, catch.filled_meshes) == ("volume_m3", (0.1,), None)
    assert load_plan(plan_file, ["netting.0.mesh_mm=80"]).netting[0].bar_m == 0.035
    assert load_plan(plan_file, ["netting.1.bar_mm=35"]).netting[1].bar_m == 0.035


def test_two_overrides_that_exclude_each_other_are_refused(plan_file: Path):
    for pair in (["catch.volume_m3=0.1", "catch.mass_kg=100"], ["netting.0.bar_mm=40", "netting.0.mesh_mm=80"]):
        for overrides in (pair, pair[::-1]):
            with pytest.raises(InputError, match="contradicts"):
                load_plan(plan_file, overrides)


def test_overrides_leave_the_tables_they_are_laid_over_alone(valid: dict):
    before = copy.deepcopy(valid)
    plan_from_dict(valid, overrides=["catch.volume_m3=0.1", "netting.0.bar_mm=41", "tow.speed_m_s.0=2.0"])
    assert valid == before


@pytest.mark.parametrize(
    ("override", "key"),
    [
        ("netting.0.bar_mm=-25", "netting.0.bar_mm"),
        ("netting.0.bar_mm=abc", "netting.0.bar_mm"),
        ("netting.0.bar_mm=", "netting.0.bar_mm"),
        ("netting.0.bar_m=25", "netting.0.bar_m"),
        ("netting.2.bar_mm=25", "netting.2"),
        ("netting.-1.bar_mm=25", "netting.-1"),
        ("netting.first.bar_mm=25", "netting.first"),
        ("netting.0.bar_mm.x=25", "netting.0.bar_mm.x"),
        ("netting=[]", "netting"),
        ("tow.speed_m_s=nan", "tow.speed_m_s"),
        ("tow.speed_m_s=1.0\ntitle='x'", "tow.speed_m_s"),
        ("catch.pressure=sphere", "catch.coefficient"),
        ("catch.filled_meshes=[]", "catch.filled_meshes"),
        ("model.globalisation=7", "model.globalisation"),
        ("title", "title"),
        ("=3", "=3"),
        ("tow..speed_m_s=3", "tow..speed_m_s=3"),
    ],
)
def test_a_bad_override_ends_in_one_line_as_a_bad_file_does(override: str, key: str, plan_file: Path):
    with pytest.raises(InputError) as caught:
        load_plan(plan_file, [override])
    assert_is_one_clear_line(caught.value, plan_file)
    assert caught.value.key == key
