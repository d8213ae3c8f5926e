"""A study's page: what varies on the axes, the front that no design betters, plans of the best."""

import numpy as np
import pandas as pd
import pytest

from codend.plan.plan import load_plan
from codend.report.study_page import write_study
from codend.report.study_plots import front_of, fronts_of, map_figure, pareto_figure, response_figure, swept
from tests.cli.test_cli import TINY_PLAN, codend_cli


def table_of(**keys):
    """A table of a study with one case a run, of which some columns vary."""
    grid = pd.MultiIndex.from_product(keys.values(), names=list(keys)).to_frame(index=False)
    grid.insert(0, "run", np.arange(1, len(grid) + 1))
    size = grid["a"].to_numpy(dtype=float)
    told = {"case": 1, "speed_m_s": 1.5, "catch_mass_kg": 100.0, "drag_n": 100.0 * size, "converged": True}
    return grid.assign(**told, opening_ahead_deg=60.0 - size, l50_cm=20.0 + size, reason=None)


def test_columns_that_change_together_are_one():
    table = table_of(a=[1.0, 2.0, 3.0], kind=["t0", "t90"])
    table.insert(2, "round", table["kind"].map({"t0": 100, "t90": 50}))
    found = swept(table)
    assert found is not None
    assert (found.numbers, found.kinds) == (("a", "round"), ())
    assert found.case == "case 1: 1.5 m/s, 100 kg"


def test_colours_and_dashes_tell_two_numbers_apart():
    figure = response_figure(swept(table_of(a=[1.0, 2.0, 3.0], b=[5, 6], kind=["t0", "t90"])))
    lines = figure.axes[0].get_lines()
    looks = {(str(line.get_color()), str(line.get_linestyle()), line.get_marker()) for line in lines}
    assert len(lines) == len(looks) == 4
    assert figure.axes[0].get_xlabel() == "a"
    (legend,) = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == ["b = 5", "b = 6", "kind = t0", "kind = t90"]


def test_a_grid_of_two_numbers_has_maps_and_a_sample_has_none():
    table = table_of(a=[1.0, 2.0, 3.0], b=[5.0, 6.0, 7.0])
    figure = map_figure(swept(table))
    assert figure is not None
    assert figure.axes[0].get_xlabel() == "a"
    rng = np.random.default_rng(0)
    assert map_figure(swept(table.assign(a=rng.random(9), b=rng.random(9)))) is None


def test_no_design_betters_those_on_the_front():
    rng = np.random.default_rng(1)
    table = table_of(a=np.arange(50.0)).assign(drag_n=rng.random(50), l50_cm=rng.random(50))
    front = front_of(table, "l50_cm")
    for row in table.itertuples():
        better = (front["drag_n"] <= row.drag_n) & (front["l50_cm"] >= row.l50_cm)
        assert better.any()
    assert front["drag_n"].is_monotonic_increasing
    assert front["l50_cm"].is_monotonic_increasing
    assert "run" in pareto_figure(swept(table), "l50_cm").axes[0].texts[0].get_text()


def test_designs_are_compared_at_like_catch():
    table = table_of(a=[1.0, 2.0, 3.0], **{"catch.mass_kg": [100.0, 500.0]})
    # of the larger catch all have more drag and a larger L50
    larger = table["catch.mass_kg"] == 500.0
    table = table.assign(drag_n=table["drag_n"] + 1000.0 * larger, l50_cm=30.0 - table["a"] + 5.0 * larger)
    fronts = fronts_of(swept(table), "l50_cm")
    assert [front["run"].tolist() for front in fronts] == [[1], [2]]
    (mixed,) = fronts_of(swept(table.drop_duplicates("a")), "l50_cm")
    assert mixed["run"].tolist() == [1]


def test_errors_are_drawn_behind_lines():
    table = table_of(a=[1.0, 2.0, 3.0]).assign(opening_ahead_error_deg=2.0)
    axes = response_figure(swept(table)).axes
    shades = [axis for axis in axes if axis.collections]
    assert [axis.get_ylabel() for axis in shades] == ["opening ahead (°)"]
    low, high = shades[0].collections[0].get_datalim(shades[0].transData).intervaly
    assert (low, high) == pytest.approx((55.0, 61.0))


def test_the_page_tells_what_is_not_drawn_and_how_well_the_rest_is_known(tmp_path):
    (tmp_path / "plan.toml").write_text(TINY_PLAN, encoding="utf-8")
    table = table_of(a=[1.0, 2.0, 3.0]).assign(stable=["yes", "no", "yes"], drag_error_n=7.0)
    table.loc[2, ["converged", "reason"]] = [False, "No equilibrium."]
    interval = {"case": 1, "quantity": "drag_n", "value": 100.0, "lower_95": 83.0, "upper_95": 117.0}
    intervals = pd.DataFrame([{"run": run, **interval, "measure_better": "a", "share": 1.0} for run in (1, 3)])
    write_study("study", table, lambda _: load_plan(tmp_path / "plan.toml"), tmp_path, intervals)
    page = (tmp_path / "study.html").read_text(encoding="utf-8")
    assert "in no figure: run 3: No equilibrium." in page
    assert "1 of 2 shapes are not stable" in page
    assert "drag error" in page
    assert page.count(">83<") == 1


def test_a_sweep_writes_the_page_and_plans_of_the_best(tmp_path):
    (tmp_path / "plan.toml").write_text(TINY_PLAN, encoding="utf-8")
    study = 'plan = "plan.toml"\n[vary]\n"netting.0.bar_mm" = [40.0, 50.0]\n"netting.0.twine_mm" = [1.0, 2.0]\n'
    (tmp_path / "study.toml").write_text(study, encoding="utf-8")
    out = tmp_path / "out"
    result = codend_cli("sweep", tmp_path / "study.toml", "--workers", "1", "--out", out)
    assert result.exit_code == 0, result.output
    assert {"response.png", "map.png", "pareto.png", "study.html", "best"} <= {path.name for path in out.iterdir()}
    table = pd.read_csv(out / "sweep.csv")
    last = table[table["case"] == table["case"].max()]
    for path in (out / "best").iterdir():
        (row,) = last[last["run"] == int(path.stem.removeprefix("run_"))].to_dict("records")
        assert load_plan(path).netting[0].bar_mm == row["netting.0.bar_mm"]
    least = last.loc[last["drag_n"].idxmin(), "run"]
    assert (out / "best" / f"run_{least}.toml").exists()


def test_a_study_of_which_nothing_is_solved_has_no_page():
    assert swept(table_of(a=[1.0, 2.0]).assign(converged=False)) is None


@pytest.mark.parametrize("keys", [{"a": [1.0]}, {"a": [1.0, 1.5]}])
def test_few_designs_are_drawn_too(keys):
    found = swept(table_of(**keys))
    assert found is not None
    assert pareto_figure(found, "l50_cm").axes


def test_designs_of_one_case_are_printed_with_their_errors(tmp_path):
    (tmp_path / "plan.toml").write_text(TINY_PLAN, encoding="utf-8")
    (tmp_path / "study.toml").write_text(
        'plan = "plan.toml"\n[vary]\n"catch.filled_meshes" = [2.0]\n', encoding="utf-8"
    )
    result = codend_cli("sweep", tmp_path / "study.toml", "--workers", "1", "--out", tmp_path / "out")
    (row,) = pd.read_csv(tmp_path / "out" / "sweep.csv").to_dict("records")
    told = result.stdout.splitlines()[2].split()
    assert [float(cell) for cell in told[2:4]] == pytest.approx([row["drag_n"], row["drag_error_n"]], rel=1e-2)
