import copy
import math
import os
import pickle
import string
import subprocess
import sys
import tomllib
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from codend.errors import InputError
from codend.plan.plan import Case, Plan, load_plan, plan_from_dict
from codend.plan.tables import Drag, Netting
from tests import ROOT
from tests.bad_plans import BAD_PLANS, VALID_PLAN, BadPlan, assert_is_one_clear_line

CASES = ROOT / "validation" / "cases"

DOCUMENTED_PLAN = """
title = "Flume model, 150 x 140 meshes"
[tow]
speed_m_s = 1.0
water_density_kg_m3 = 1000.0
[entry]
radius_m = 0.30
[[netting]]
mesh = "diamond"
meshes_round = 150
meshes_long = 140
bar_mm = 20.0
knot_mm = 0.0
twine_mm = 0.52
twines = 1
twine_density_kg_m3 = 1140.0
axial_stiffness_n = 1000.0
bending_stiffness_n_m2 = 0.0
rest_opening_deg = 20.0
[catch]
filled_meshes = [20, 40, 60]
density_kg_m3 = 1000.0
pressure = "sphere"
coefficient = 1.4
[drag]
law = "le-bris-1999"
normal = 1.36
tangential = 0.07
[model]
fidelity = "auto"
globalisation = 1
bars_per_side = 1
method = "auto"
tolerance = 1e-6
"""


@pytest.fixture
def plan_file(tmp_path: Path) -> Path:
    path = tmp_path / "plan.toml"
    path.write_text(VALID_PLAN, encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def valid() -> dict:
    return tomllib.loads(VALID_PLAN)


def netting(**changes) -> Netting:
    numbers = {"mesh": "diamond", "meshes_round": 100, "meshes_long": 50, "bar_mm": 40.0, "twine_mm": 3.0}
    return Netting(**(numbers | changes))


@pytest.mark.parametrize("bad", BAD_PLANS, ids=lambda bad: bad.id)
def test_a_broken_plan_ends_in_one_line_naming_file_and_key(bad: BadPlan, plan_file: Path):
    plan_file.write_text(bad.text, encoding="utf-8")
    with pytest.raises(InputError) as caught:
        load_plan(plan_file)
    assert_is_one_clear_line(caught.value, plan_file)
    assert " ".join(caught.value.key.split()) == bad.key
    assert caught.value.__cause__ is None


def test_an_error_shows_the_value_and_what_is_allowed(plan_file: Path):
    with pytest.raises(InputError) as caught:
        load_plan(plan_file, ["tow.speed_m_s=-1"])
    assert (caught.value.key, caught.value.value) == ("tow.speed_m_s", -1)
    assert str(caught.value) == (
        f"{plan_file}: tow.speed_m_s = -1 is not allowed; "
        "allowed: a number at least 0.0001, at most 10, or a list of them that is not empty"
    )


@pytest.mark.parametrize(
    ("key", "written"),
    [
        ("title", '["a", [true, 1.5]]'),
        ("title", '{a = 1, b = ["x"]}'),
        ("tow.speed_m_s", '{a = "x"}'),
        ("entry.radius_m", "1979-05-27"),
        ("entry.radius_m", "inf"),
    ],
)
def test_an_error_shows_the_value_as_toml_has_it(key: str, written: str, plan_file: Path):
    with pytest.raises(InputError) as error:
        load_plan(plan_file, [f"{key}={written}"])
    assert f"{plan_file}: {key} = {written} is not allowed; allowed: " in str(error.value)


def test_a_misspelt_key_is_told_the_closest_one(plan_file: Path):
    with pytest.raises(InputError, match=r"did you mean meshes_round\?"):
        load_plan(plan_file, ["netting.0.meshes_rond=100"])


def test_toml_that_does_not_parse_names_the_line(plan_file: Path):
    plan_file.write_text(VALID_PLAN.replace("radius_m = 0.30", "radius_m = "), encoding="utf-8")
    with pytest.raises(InputError, match="line 8"):
        load_plan(plan_file)
    plan_file.write_text("title = '''", encoding="utf-8")
    with pytest.raises(InputError, match="line 1"):
        load_plan(plan_file)


def test_a_globalisation_that_does_not_fit_lists_those_that_do(plan_file: Path):
    with pytest.raises(InputError) as caught:
        load_plan(plan_file, ["model.globalisation=4"])
    assert caught.value.allowed.startswith("1, 2, 5, 10 (")


@pytest.mark.parametrize("name", ["missing.toml", "", "null\0.toml", "two\nlines.toml"])
def test_a_file_that_cannot_be_read_is_an_input_error(name: str, tmp_path: Path):
    with pytest.raises(InputError) as caught:
        load_plan(f"{tmp_path}/{name}")
    assert len(str(caught.value).splitlines()) == 1


def test_a_file_that_is_not_utf8_is_an_input_error(plan_file: Path):
    plan_file.write_bytes(VALID_PLAN.replace("Two", "Deux \xe9").encode("latin-1"))
    with pytest.raises(InputError, match="UTF-8"):
        load_plan(plan_file)


def test_a_byte_order_mark_and_windows_line_ends_do_no_harm(plan_file: Path):
    plain = load_plan(plan_file)
    plan_file.write_bytes(b"\xef\xbb\xbf" + VALID_PLAN.replace("\n", "\r\n").encode())
    assert load_plan(plan_file) == plain


def test_an_input_error_survives_the_way_back_from_a_worker():
    error = InputError("plan.toml", "tow.speed_m_s", -1, "a number above 0")
    assert str(pickle.loads(pickle.dumps(error))) == str(error)


def test_a_key_and_value_that_are_no_unicode_end_in_one_line(valid: dict):
    for override in ("title=\udcff", "tow.\udcff=1", "\udcff=1", "catch.pressure=\udcff"):
        with pytest.raises(InputError) as caught:
            plan_from_dict(valid, overrides=[override])
        str(caught.value).encode("utf-8")


# --- what a plan holds


def test_the_plan_the_documentation_shows_is_a_valid_one():
    plan = plan_from_dict(tomllib.loads(DOCUMENTED_PLAN))
    assert (plan.catch.pressure, plan.catch.kind, plan.catch.sizes) == ("sphere", "filled_meshes", (20.0, 40.0, 60.0))
    assert plan_from_dict(tomllib.loads(DOCUMENTED_PLAN), overrides=["catch.pressure=uniform"]).catch.coefficient == 1.4


def test_lengths_in_mm_become_metres():
    section = netting(bar_mm=None, mesh_mm=100.0, knot_mm=12.0)
    assert section.bar_m == pytest.approx(0.038, rel=1e-15)
    assert section.knot_m == 0.012
    assert section.twine_m == 0.003
    assert section.full_mesh_m == pytest.approx(0.1, rel=1e-15)


def test_bar_and_full_mesh_describe_the_same_netting():
    by_bar, by_mesh = netting(bar_mm=40.0, knot_mm=5.0), netting(bar_mm=None, mesh_mm=90.0, knot_mm=5.0)
    assert by_bar.bar_m == by_mesh.bar_m
    assert by_bar.full_mesh_m == by_mesh.full_mesh_m


def test_a_section_is_called_by_its_name_or_else_by_its_number(valid: dict):
    part = valid["netting"][0] | {"meshes_long": 20}
    plan = plan_from_dict({**valid, "netting": [part, part | {"name": "1, aft"}, part]})
    assert plan.section_names == ("1", "1, aft", "3")
    with pytest.raises(InputError, match=r'netting.0.name = "aft" is not allowed; allowed: a name that no other'):
        plan_from_dict({**valid, "netting": [part | {"name": "aft"}] * 2})


def test_what_is_unusual_but_can_be_is_accepted(valid: dict):
    plan = plan_from_dict(valid, overrides=["netting.0.knot_mm=40.0", "tow.speed_m_s=1e-4", "entry.radius_m=0.001"])
    assert plan.netting[0].knot_m == plan.netting[0].bar_m


def test_double_twine_has_twice_the_width_and_twice_the_volume_of_one():
    one, two = netting(axial_stiffness_n=500.0), netting(axial_stiffness_n=500.0, twines=2)
    assert two.drag_width_m == 2 * one.drag_width_m == 2 * one.twine_m
    assert two.solid_diameter_m**2 == pytest.approx(2 * one.solid_diameter_m**2, rel=1e-15)
    assert two.axial_stiffness_n == one.axial_stiffness_n  # EA of one bar, both twines together


def test_stretched_radius_and_length_of_each_mesh_kind():
    knotted = {"knot_mm": 10.0}
    assert netting(**knotted).stretched_radius_m == pytest.approx(100 * 0.04 / math.pi)
    assert netting(**knotted).stretched_length_m == pytest.approx(50 * 0.1)
    assert netting(mesh="t90", **knotted).stretched_radius_m == pytest.approx(100 * 0.05 / math.pi)
    assert netting(mesh="t90", **knotted).stretched_length_m == pytest.approx(50 * 0.08)
    assert netting(mesh="square").stretched_radius_m == pytest.approx(100 * 0.04 / (2 * math.pi))
    assert netting(mesh="square").stretched_length_m == pytest.approx(50 * 0.04)


def test_the_hoop_may_be_as_wide_as_netting_fully_open_and_no_wider(valid: dict):
    for mesh, knot_mm, limit_m in [
        ("diamond", 5.0, 4 / math.pi),
        ("t90", 5.0, 4.5 / math.pi),
        ("square", 0.0, 2 / math.pi),
    ]:
        section = [f"netting.0.mesh={mesh}", f"netting.0.knot_mm={knot_mm}"]
        plan_from_dict(valid, overrides=[*section, f"entry.radius_m={0.999 * limit_m}"])
        with pytest.raises(InputError) as caught:
            plan_from_dict(valid, overrides=[*section, f"entry.radius_m={1.001 * limit_m}"])
        assert caught.value.key == "entry.radius_m"


def test_rest_opening_is_the_whole_angle_of_the_mesh():
    assert netting(rest_opening_deg=60.0).rest_half_angle_rad == pytest.approx(math.pi / 6)


def test_left_out_drag_coefficients_are_those_of_the_laws_paper():
    assert Drag.model_validate({}).coefficients == (1.36, 0.07)
    assert Drag.model_validate({"law": "bessonneau-1997"}).coefficients == (1.2, 0.1)
    assert Drag.model_validate({"law": "bessonneau-1997", "normal": 1.8}).coefficients == (1.8, 0.1)


def test_normal_0_switches_twine_drag_off_under_either_law():
    for law in ("le-bris-1999", "bessonneau-1997"):
        assert Drag.model_validate({"law": law, "normal": 0, "tangential": 0.1}).coefficients == (0.0, 0.0)


def test_what_may_be_left_out_takes_its_documented_default(valid: dict):
    short = copy.deepcopy(valid)
    del short["drag"], short["model"], short["catch"]["density_kg_m3"]
    short["netting"] = [{"mesh": "t90", "meshes_round": 50, "meshes_long": 80, "bar_mm": 40, "twine_mm": 4}]
    plan = plan_from_dict(short)
    section, model = plan.netting[0], plan.model
    assert plan.drag == Drag(law="le-bris-1999", normal=1.36, tangential=0.07)
    assert (model.fidelity, model.globalisation, model.bars_per_side) == ("auto", 1, 1)
    assert (model.method, model.damping, model.tolerance) == ("auto", "kinetic", 1e-6)
    assert (section.knot_mm, section.twines, section.bending_stiffness_n_m2) == (0.0, 1, 0.0)
    assert section.twine_density_kg_m3 is None
    assert section.axial_stiffness_n is None
    assert plan.catch_density_kg_m3 == plan.tow.water_density_kg_m3


def test_cases_run_over_catches_within_each_speed(plan_file: Path):
    cases = load_plan(plan_file).cases()
    assert [case.number for case in cases] == [1, 2, 3, 4, 5, 6]
    assert [(case.speed_m_s, case.catch_value) for case in cases] == [
        (speed, catch) for speed in (1.0, 1.5) for catch in (20.0, 40.5, 60.0)
    ]
    assert cases[4] == Case(5, 1.5, "filled_meshes", 40.5)


def test_one_number_and_a_list_of_one_are_the_same_plan(valid: dict):
    assert plan_from_dict(valid, overrides=["tow.speed_m_s=1"]) == plan_from_dict(
        valid, overrides=["tow.speed_m_s=[1]"]
    )


def test_whole_numbers_are_taken_for_numbers_and_kept_as_such(valid: dict):
    radius_m = plan_from_dict(valid, overrides=["entry.radius_m=1"]).entry.radius_m
    assert (radius_m, type(radius_m)) == (1.0, float)


def test_a_plan_cannot_be_changed_and_knows_its_file(plan_file: Path):
    plan = load_plan(plan_file)
    assert plan.source == plan_file
    with pytest.raises(ValidationError):
        plan.title = "another"  # type: ignore[misc]
    with pytest.raises(ValidationError):
        plan.tow.speed_m_s = (2.0,)  # type: ignore[misc]
    assert "source" not in plan.to_dict()


def test_a_plan_survives_the_round_trip_through_plain_tables_and_through_pickle(plan_file: Path):
    plan = load_plan(plan_file)
    assert plan_from_dict(plan.to_dict(), plan_file) == plan
    assert pickle.loads(pickle.dumps(plan)) == plan
    assert plan_from_dict(plan.to_dict(), plan_file, ["netting.0.twine_mm=2.0"]).netting[0].twine_mm == 2.0


def test_the_users_pressure_curve_is_found_beside_the_plan(plan_file: Path):
    overrides = ["catch.pressure=sphere", "catch.coefficient=1.4", "catch.sphere_cp_csv=cp.csv"]
    with pytest.raises(InputError, match="sphere_cp_csv"):
        load_plan(plan_file, overrides)
    (plan_file.parent / "cp.csv").write_text("theta_deg,cp\n0,1\n180,0\n", encoding="utf-8")
    assert load_plan(plan_file, overrides).sphere_cp_path == plan_file.parent / "cp.csv"
    assert load_plan(plan_file).sphere_cp_path is None


# --- nothing but InputError

SCALARS = (
    st.none()
    | st.booleans()
    | st.integers()
    | st.integers(min_value=10**400, max_value=10**401)
    | st.floats()
    | st.text(max_size=8)
    | st.sampled_from(["diamond", "square", "sphere", "sector", "bessonneau-1997"])
)
VALUES = st.recursive(
    SCALARS, lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=4), inner, max_size=3)
)


def paths_into(data: object, here: tuple = ()) -> list[tuple]:
    items = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ()
    return [path for key, value in items for path in [(*here, key), *paths_into(value, (*here, key))]]


def assert_is_plan_or_one_line(read: Callable[[], Plan]) -> None:
    try:
        outcome: Plan | InputError = read()
    except InputError as error:
        outcome = error
    assert isinstance(outcome, Plan) or len(str(outcome).splitlines()) == 1


@settings(max_examples=300, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(data=st.data())
def test_whatever_is_changed_in_a_plan_nothing_but_input_error_escapes(data: st.DataObject, valid: dict):
    broken = copy.deepcopy(valid)
    for _ in range(data.draw(st.integers(1, 3))):
        paths = paths_into(broken)
        if not paths:
            break
        *parents, last = data.draw(st.sampled_from(paths))
        table = broken
        for part in parents:
            table = table[part]
        match data.draw(st.sampled_from(["replace", "delete", "add"])):
            case "delete":
                del table[last]
            case "add" if isinstance(table, dict):
                table[data.draw(st.text(max_size=8))] = data.draw(VALUES)
            case _:
                table[last] = data.draw(VALUES)
    assert_is_plan_or_one_line(lambda: plan_from_dict(broken, "plan.toml"))


@settings(max_examples=150, deadline=None)
@given(data=st.data())
def test_whatever_is_typed_into_a_plan_file_nothing_but_input_error_escapes(data: st.DataObject, tmp_path_factory):
    start = data.draw(st.integers(0, len(VALID_PLAN)))
    stop = data.draw(st.integers(start, min(start + 20, len(VALID_PLAN))))
    typed = data.draw(st.text(string.printable, max_size=12) | st.text(max_size=6))
    path = tmp_path_factory.getbasetemp() / "typed.toml"
    path.write_bytes((VALID_PLAN[:start] + typed + VALID_PLAN[stop:]).encode("utf-8", "surrogatepass"))
    assert_is_plan_or_one_line(lambda: load_plan(path))


@settings(max_examples=150, deadline=None)
@given(
    key=st.sampled_from(["tow.speed_m_s", "netting.0.bar_mm", "netting", "catch", "title"]) | st.text(max_size=12),
    value=st.text(max_size=12) | SCALARS.map(repr),
)
def test_whatever_is_set_from_outside_nothing_but_input_error_escapes(key: str, value: str, valid: dict):
    assert_is_plan_or_one_line(lambda: plan_from_dict(valid, "plan.toml", [f"{key}={value}"]))


# --- the shipped plans


@pytest.mark.parametrize("name", ["flume_150x140", "commercial_100mm_double", "knotted_elastic", "joined_with_strap"])
def test_the_shipped_plans_load_and_say_what_is_assumed(name: str):
    plan = load_plan(CASES / f"{name}.toml")
    assert plan.cases()
    assert "ASSUMED" in (CASES / f"{name}.toml").read_text(encoding="utf-8")


def test_the_flume_plan_is_that_of_le_bris_1999():
    plan = load_plan(CASES / "flume_150x140.toml")
    section = plan.netting[0]
    assert (section.meshes_round, section.meshes_long, section.twine_mm) == (150, 140, 0.52)
    assert plan.tow.speed_m_s == (1.0,)
    assert plan.drag.coefficients == (1.36, 0.07)
    assert len(plan.cases()) == 10
    assert 10 in plan.globalisations


def test_reading_a_plan_needs_no_heavy_library():
    code = "import sys, codend.plan.plan; print({'numpy', 'scipy', 'numba', 'pandas', 'matplotlib'} & set(sys.modules))"
    root = str(ROOT)
    out = subprocess.run(
        [sys.executable, "-c", code], check=True, capture_output=True, text=True, env=os.environ | {"PYTHONPATH": root}
    )
    assert out.stdout.strip() == "set()"
