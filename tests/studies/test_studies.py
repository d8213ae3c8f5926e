"""Studies: designs as asked, the numbers of runs by themselves, the same whoever solves, mistakes in one line each."""

import gc
import math
import re
from threading import Thread

import numpy as np
import pandas as pd
import pytest

import codend
import codend.studies.workers
from codend.errors import InputError
from codend.plan.plan import load_plan
from codend.selectivity.escape.catches import run_of
from codend.selectivity.escape.predict import predict
from codend.selectivity.escape.species import example_species_path, load_species
from codend.selectivity.escape.tables import selectivity_table
from codend.studies import chunks, many
from codend.studies.parts import part_path, read_parts
from codend.studies.study import solve
from codend.studies.study_file import load_study, study_from_dict
from tests.cli.test_cli import TINY_PLAN, assert_refused, codend_cli

STUDY = """
plan = "plan.toml"
[vary]
"netting.0.bar_mm" = { from = 40, to = 50, steps = 3 }
[[linked]]
"netting.0.mesh" = ["diamond", "t90"]
"netting.0.meshes_round" = [24, 18]
"""


@pytest.fixture
def home(tmp_path):
    (tmp_path / "plan.toml").write_text(TINY_PLAN, encoding="utf-8")
    (tmp_path / "study.toml").write_text(STUDY, encoding="utf-8")
    return tmp_path


def same(one: pd.DataFrame, two: pd.DataFrame) -> None:
    pd.testing.assert_frame_equal(one.drop(columns="solve_ms"), two.drop(columns="solve_ms"))


def study_with(home, **tables):
    return study_from_dict({"plan": str(home / "plan.toml"), **tables})


def test_designs_are_every_combination_the_last_one_running_fastest(home):
    designs = load_study(home / "study.toml").designs
    found = [tuple(designs.run(number).values.values()) for number in range(1, len(designs) + 1)]
    assert found == [(bar, *mesh) for bar in (40.0, 45.0, 50.0) for mesh in (("diamond", 24), ("t90", 18))]


def test_keys_may_be_quoted_whole_or_dotted(home):
    table = {"netting": {"0": {"bar_mm": [40.0, 50.0]}}}
    assert study_with(home, vary=table).designs == study_with(home, vary={"netting.0.bar_mm": [40.0, 50.0]}).designs


@pytest.mark.parametrize("kind", ["sobol", "latin-hypercube"])
def test_a_sample_fills_its_ranges_evenly_with_counts_whole(kind, home):
    ranges = {"netting.0.bar_mm": {"from": 40, "to": 50}, "netting.0.meshes_round": {"from": 24, "to": 31}}
    vary = {"sample": kind, "size": 64, **ranges, "netting.0.mesh": ["diamond", "t90"]}
    designs = study_with(home, vary=vary).designs
    values = [designs.run(number).values for number in range(1, 65)]
    eighths = [sorted(int(8 * (one["netting.0.bar_mm"] - 40) / 10) for one in values)]
    assert eighths == [sorted(list(range(8)) * 8)]
    assert sorted(one["netting.0.meshes_round"] for one in values) == sorted(list(range(24, 32)) * 8)
    assert [one["netting.0.mesh"] for one in values].count("t90") == 32
    again = study_with(home, vary=vary).designs
    assert [again.run(number).values for number in range(1, 65)] == values
    apart = np.linalg.norm(np.diff(designs.shares, axis=0), axis=1)
    assert apart.mean() < 0.5, "neighbours follow each other: those of a cube are 0.66 apart at random"


def test_counts_follow_from_the_circumference_and_length_that_are_kept(home):
    keep = {"netting.0.meshes_round": "stretched_circumference", "netting.0.meshes_long": "stretched_length"}
    designs = study_with(home, vary={"netting.0.bar_mm": [20.0, 40.0, 55.0]}, keep=keep).designs
    for number in (1, 2, 3):
        section = designs.run(number).plan().netting[0]
        assert section.meshes_round == round(24 * 40 / section.bar_mm)
        assert section.meshes_long == round(20 * 40 / section.bar_mm)
        assert 2 * math.pi * section.stretched_radius_m == pytest.approx(2 * 24 * 0.04, abs=section.bar_m)


def test_a_study_has_the_numbers_of_its_runs_by_themselves(home):
    table = codend.sweep(home / "study.toml")
    assert table["run"].tolist() == [number for number in range(1, 7) for _ in range(2)]
    assert table["reason"].isna().all()
    for run, rows in table.groupby("run"):
        alone = solve(load_study(home / "study.toml").designs.run(run).plan()).table
        for quantity in ("drag_n", "catch_volume_m3", "opening_ahead_deg"):
            assert rows[quantity].to_numpy() == pytest.approx(alone[quantity].to_numpy(), rel=1e-6)


def test_neighbours_lead_to_the_same_equilibria_in_fewer_steps(home, monkeypatch):
    vary = {"netting.0.twine_mm": {"from": 1.0, "to": 3.0, "steps": 12}}
    study = {"plan": str(home / "plan.toml"), "vary": vary}
    apart = codend.sweep(study)
    monkeypatch.setattr(many, "LEAST_CHUNKS", 1)
    together = codend.sweep(study)
    for quantity in ("drag_n", "catch_volume_m3", "opening_ahead_deg"):
        assert together[quantity].to_numpy() == pytest.approx(apart[quantity].to_numpy(), rel=1e-5)
    assert together["iterations"].sum() < 0.8 * apart["iterations"].sum()


def test_plans_as_tables_go_in_and_a_table_comes_out(home):
    plans = [load_plan(home / "plan.toml", [f"netting.0.bar_mm={bar}"]).to_dict() for bar in (40, 44)]
    table = codend.sweep(plans)
    assert table["design"].tolist() == ["1", "1", "2", "2"]
    assert table["converged"].all()


def test_designs_have_names_and_what_they_set(home):
    designs = [
        {"name": "T0"},
        {"name": "T90, 18 round", "set": {"netting.0.mesh": "t90", "netting.0.meshes_round": 18}},
    ]
    study = study_with(home, design=designs, vary={"catch.filled_meshes": [[4], [8]]})
    table = many.sweep(
        {"plan": str(home / "plan.toml"), "design": designs, "vary": {"catch.filled_meshes": [[4], [8]]}}
    )
    assert table["design"].tolist() == ["T0", "T0", "T90, 18 round", "T90, 18 round"]
    assert table["catch.filled_meshes"].tolist() == ["[4]", "[8]", "[4]", "[8]"]
    assert study.designs.run(4).plan().netting[0].mesh == "t90"


@pytest.mark.parametrize(
    ("key", "values"), [("model.wrinkles", ["auto", False]), ("catch.filled_meshes", [[4.0, 8.0], 6.0])]
)
def test_values_of_several_kinds_are_text_in_every_part(home, key, values):
    table = codend.sweep({"plan": str(home / "plan.toml"), "vary": {key: values}})
    assert table["converged"].all()
    assert table[key].nunique() == 2


def test_parts_are_stale_when_a_curve_that_varies_is_changed(home, tmp_path):
    plan = (home / "plan.toml").read_text(encoding="utf-8")
    (tmp_path / "plan.toml").write_text(plan, encoding="utf-8")
    for name, suction in (("a.csv", -0.4), ("b.csv", -0.5)):
        (tmp_path / name).write_text(f"theta_deg,cp\n0,1\n90,{suction}\n180,{suction}\n", encoding="utf-8")
    study = {"plan": str(tmp_path / "plan.toml"), "vary": {"catch.sphere_cp_csv": ["a.csv", "b.csv"]}}
    before = codend.sweep(study, tmp_path / "out")
    (tmp_path / "b.csv").write_text("theta_deg,cp\n0,1\n90,-1\n180,-1\n", encoding="utf-8")
    after = codend.sweep(study, tmp_path / "out")
    changed = after["catch.sphere_cp_csv"] == "b.csv"
    assert (after["drag_n"][changed] > 1.01 * before["drag_n"][changed]).all()
    assert (after["drag_n"][~changed] == before["drag_n"][~changed]).all()


@pytest.mark.parametrize("where", ["", "[along]\nrows_ahead = [0.0, 9.0]\nweight = [1.0, 0.5]\nsource = 'assumed'\n"])
def test_species_give_l50_and_sr_of_every_case(home, where):
    path = home / "fish.toml"
    path.write_text(example_species_path().read_text(encoding="utf-8") + where, encoding="utf-8")
    table = codend.sweep({"plan": str(home / "plan.toml"), "species": [str(path)]})
    study = solve(load_plan(home / "plan.toml"))
    found = selectivity_table(predict(run_of(study), [load_species(path)], n_bootstrap=0, samples=0))
    assert table["l50_cm"].to_numpy() == pytest.approx(found["l50_cm"][:-1].to_numpy(float))
    for name in ("l50_opening_error_cm", "sr_opening_error_cm"):
        assert table[name].to_numpy() == pytest.approx(found[name][:-1].to_numpy(float), rel=1e-6, abs=1e-9)
    assert table["sr_cm"].to_numpy() == pytest.approx(found["sr_cm"][:-1].to_numpy(float))


def test_two_processes_and_a_cluster_find_what_one_does(home, monkeypatch):
    monkeypatch.setattr(codend.studies.workers, "WAITED_FOR_S", 600)
    one = codend.sweep(home / "study.toml", home / "one")
    same(one, codend.sweep(home / "study.toml", home / "two", workers=2))
    distributed = pytest.importorskip("distributed")
    options = {"n_workers": 2, "threads_per_worker": 1, "dashboard_address": None, "scheduler_port": 0}
    with distributed.LocalCluster(**options) as cluster:
        same(one, codend.sweep(home / "study.toml", scheduler=cluster.scheduler_address))


def test_threads_that_solve_at_the_same_time_find_what_one_does(home):
    one, found = codend.sweep(home / "study.toml"), {}
    threads = [Thread(target=lambda i=i: found.update({i: codend.sweep(home / "study.toml")})) for i in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for table in found.values():
        same(one, table)
    assert len(found) == 3


def cut(path):
    path.write_bytes(path.read_bytes()[:-20])


def turn_a_bit(path):
    content = bytearray(path.read_bytes())
    content[len(content) // 3] ^= 1
    path.write_bytes(content)


@pytest.mark.parametrize("damage", [cut, turn_a_bit, lambda path: path.unlink(), lambda path: path.write_bytes(b"")])
def test_a_part_that_is_not_whole_is_solved_again_and_no_other(damage, home):
    before = codend.sweep(home / "study.toml", home / "out")
    paths = [part_path(home / "out", number) for number in range(6)]
    times = [path.stat().st_mtime_ns for path in paths]
    damage(paths[2])
    solved = []
    after = codend.sweep(home / "study.toml", home / "out", progress=lambda done, of, what: solved.append((done, of)))
    assert solved == [(6, 6)]
    same(before, after)
    assert [path.stat().st_mtime_ns == time for path, time in zip(paths, times, strict=True)] == [
        number != 2 for number in range(6)
    ]


def test_parts_of_another_study_are_not_taken(home):
    codend.sweep(home / "study.toml", home / "out")
    (home / "plan.toml").write_text(TINY_PLAN.replace("speed_m_s = 1.0", "speed_m_s = 1.2"), encoding="utf-8")
    (home / "study.toml").write_text(STUDY.replace("steps = 3", "steps = 2"), encoding="utf-8")
    table = codend.sweep(home / "study.toml", home / "out")
    assert set(table["speed_m_s"]) == {1.2}
    assert len(list((home / "out" / "parts").iterdir())) == 4


def test_a_poisoned_case_is_a_row_with_its_reason(home, monkeypatch):
    def poisoned(plan, **options):
        if plan.netting[0].bar_mm == 45.0 and 8.0 in plan.catch.sizes:
            raise ZeroDivisionError("by zero")
        return solve(plan, **options)

    monkeypatch.setattr(chunks, "solve", poisoned)
    table = codend.sweep(home / "study.toml")
    bad = table[~table["converged"].astype(bool)]
    assert bad["run"].tolist() == [3, 4]
    assert bad["case"].tolist() == [2, 2]
    assert bad["reason"].tolist() == ["an error of the program: ZeroDivisionError: by zero"] * 2
    assert len(table) == 12
    assert table.loc[table["run"] == 3, "case"].tolist() == [1, 2]


def test_values_that_make_no_plan_are_a_row_with_the_reason_and_status_3(home):
    (home / "study.toml").write_text('plan = "plan.toml"\n[vary]\n"entry.radius_m" = [0.1, 5.0]\n', encoding="utf-8")
    result = codend_cli("sweep", home / "study.toml", "--out", home / "out", "--workers", 1)
    assert result.exit_code == 3, result.output
    assert "run 2 was not solved" in result.stderr
    assert "entry.radius_m = 5.0 is not allowed" in result.stderr
    table = pd.read_csv(home / "out" / "sweep.csv")
    assert table["reason"].isna().tolist() == [True, True, False]
    assert table["case"].isna().tolist() == [False, False, True]


def test_the_command_writes_table_parts_and_picture(home):
    result = codend_cli("sweep", home / "study.toml", "--out", home / "out", "--workers", 1)
    assert result.exit_code == 0, result.stderr
    assert "6 runs, 12 cases" in result.stdout
    table = pd.read_csv(home / "out" / "sweep.csv")
    parts = read_parts(sorted((home / "out" / "parts").iterdir()))
    assert list(table.columns) == list(parts.columns)
    assert table["drag_n"].to_numpy() == pytest.approx(parts["drag_n"].to_numpy())
    assert (home / "out" / "sweep.png").stat().st_size > 10_000


PLAN = 'plan = "plan.toml"\n'
RADII = '"entry.radius_m" = { from = 0.1, to = 0.2 }\n'


def vary(line: str) -> str:
    return f"{PLAN}[vary]\n{line}"


def twine(value: str) -> str:
    return vary(f'"netting.0.twine_mm" = {value}')


BAD = {
    "an unknown key": (f"{PLAN}planet = 1", "planet = 1 is not a known key (did you mean plan?)"),
    "no plan": ("[vary]\n'entry.radius_m' = [0.1]", "plan is missing"),
    "no such plan": ('plan = "plam.toml"', "plam.toml"),
    "a key no plan has": (vary('"netting.0.twin_mm" = [1.0]'), "did you mean twine_mm?"),
    "no such section": (vary('"netting.3.twine_mm" = [1.0]'), "vary.netting.3.twine_mm does not exist"),
    "a value out of range": (twine("[1.0, -1.0]"), "vary.netting.0.twine_mm = -1.0 is not allowed"),
    "a word not known": (vary('"netting.0.mesh" = ["t09"]'), 'did you mean "t90"?'),
    "one value": (twine("1.0"), "a list of values, or { from"),
    "a value twice": (twine("[1.0, 1.0]"), "has a value twice"),
    "no steps": (twine("{ from = 1, to = 2 }"), "twine_mm.steps is missing"),
    "no end": (twine("{ from = 1, steps = 2 }"), "twine_mm.to is missing"),
    "backwards": (twine("{ from = 2, to = 1, steps = 2 }"), "above 2, from"),
    "a slip in a range": (twine("{ from = 1, to = 2, step = 2 }"), "did you mean steps?"),
    "too many counts": (vary('"netting.0.meshes_round" = { from = 20, to = 22, steps = 9 }'), "at most 3"),
    "lists of two lengths": (f'{PLAN}[[linked]]\n"entry.radius_m" = [0.1]\n"tow.speed_m_s" = [1.0, 2.0]', "1 values"),
    "varied twice": (twine('[1.0]\n[[linked]]\n"netting.0.twine_mm" = [2.0]'), "varies twice"),
    "no such sample": (vary(f'{RADII}sample = "sobel"\nsize = 8'), 'did you mean "sobol"?'),
    "a sample of no size": (vary(f'{RADII}sample = "sobol"'), "vary.size is missing"),
    "kept by another key": (f'{PLAN}[keep]\n"netting.0.bar_mm" = "stretched_circumference"', "meshes_round"),
    "kept, but not known": (f'{PLAN}[keep]\n"netting.0.meshes_round" = "circumference"', 'mean "stretched_circum'),
    "two of a name": (f'{PLAN}[[design]]\nname = "a"\n[[design]]\nname = "a"', 'design.1.name = "a"'),
    "set to what it cannot be": (f'{PLAN}[[design]]\nset = {{ "netting.0.mesh" = "t9" }}', "0.set.netting.0.mesh"),
    "no such species": (f'{PLAN}species = ["cod.toml"]', "cod.toml"),
    "no design that is a plan": (vary('"entry.radius_m" = [0.31, 0.32]'), "entry.radius_m = 0.31"),
    "too many": (
        vary(RADII.replace("}", ", steps = 10000 }") + '"tow.speed_m_s" = { from = 1, to = 2, steps = 10000 }'),
        "makes 100000000 designs",
    ),
    "a plan": (TINY_PLAN, "is a plan"),
}


@pytest.mark.parametrize(("text", "named"), BAD.values(), ids=BAD.keys())
def test_a_bad_study_file_is_refused_in_one_line(text, named, home):
    (home / "bad.toml").write_text(text, encoding="utf-8")
    result = codend_cli("sweep", home / "bad.toml", "--out", home / "out")
    assert_refused(result, named)
    assert not (home / "out").exists()


def test_all_mistakes_of_a_study_are_told_at_once(home):
    (home / "bad.toml").write_text(
        'plan = "plan.toml"\nspices = []\n[vary]\n"entry.radius_m" = []\n"netting.0.bar" = [1]\n', encoding="utf-8"
    )
    with pytest.raises(InputError, match=re.escape("spices")) as caught:
        load_study(home / "bad.toml")
    assert len(caught.value.lines) == 3


@pytest.mark.parametrize(
    "changes",
    [["entry.radius_m=0.2"], ["netting.0.meshes_round=30", "netting.0.mesh=t90"], ["netting.0.bar_mm=55"]],
)
def test_a_neighbour_leads_to_the_same_equilibrium_in_fewer_steps(home, changes):
    netting = [one for one in changes if "mesh=" in one]
    own, other = load_plan(home / "plan.toml", netting), load_plan(home / "plan.toml", changes)
    alone, led = solve(other).table, solve(other, near=solve(own).cases).table
    for name in ("drag_n", "opening_ahead_deg", "max_radius_m", "entry_reaction_n"):
        assert led[name].to_numpy() == pytest.approx(alone[name].to_numpy(), rel=1e-6)
    assert 0 < led["iterations"].iloc[0] < alone["iterations"].iloc[0]


def test_a_study_leaves_python_to_look_for_unused_objects_as_often_as_before(monkeypatch):
    before, during = (700, 10, 10), []
    own = gc.get_threshold()  # of a command, where one has run here
    gc.set_threshold(*before)

    def fails(chunk):
        during.append(gc.get_threshold()[0])
        with chunks._seldom_looked_for():  # as another thread would
            pass
        during.append(gc.get_threshold()[0])
        raise OSError

    monkeypatch.setattr(chunks, "_rows_of_chunk", fails)
    try:
        for _ in range(2):
            with pytest.raises(OSError):
                chunks.solve_chunk(chunks.Chunk(0, (), (), False))
            assert gc.get_threshold() == before
    finally:
        gc.set_threshold(*own)
    assert min(during) > before[0]
