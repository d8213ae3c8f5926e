"""From plan to selectivity: solved codends, tables, plots, the command, and the directions trials have found."""

import itertools

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner
from matplotlib.text import Text

import codend
from codend.cli.main import main
from codend.errors import InputError
from codend.plan.copy import plan_toml
from codend.plan.plan import Plan, load_plan, plan_from_dict
from codend.report.page_parts import with_part
from codend.report.selectivity_page import write_selectivity
from codend.report.selectivity_plots import sensitivity_plot
from codend.selectivity.escape.catches import Run, catches_of, read_run, run_of
from codend.selectivity.escape.predict import Prediction, predict
from codend.selectivity.escape.species import example_species_path, load_species
from codend.selectivity.escape.tables import HAUL, retention_table, selectivity_table, sensitivity_table
from tests.plans import make_plan

SPECIES = load_species(example_species_path())


# --- tables, plots, command ------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def run() -> Run:
    return run_of(codend.solve(make_plan(40, 30, filled=[4.0, 8.0, 14.0, 20.0])))


@pytest.fixture(scope="module")
def found(run: Run) -> list[Prediction]:
    return predict(run, [SPECIES], n_bootstrap=200, samples=16)


@pytest.fixture
def folder(run: Run, tmp_path):
    """What ``codend run`` leaves that matters here."""
    run.results.to_csv(tmp_path / "results.csv", index=False)
    run.profile.to_csv(tmp_path / "profile.csv", index=False)
    (tmp_path / "plan.toml").write_text(plan_toml(run.plan), encoding="utf-8")
    return tmp_path


def test_tables_have_the_promised_columns_and_a_row_for_the_haul(found):
    table = selectivity_table(found)
    assert list(table.columns[:5]) == ["case", "species", "catch_volume_m3", "l50_cm", "sr_cm"]
    assert table["case"].tolist() == ["1", "2", "3", "4", HAUL]
    assert list(retention_table(found).columns[:4]) == ["case", "species", "length_cm", "retention"]
    assert set(sensitivity_table(found)["parameter"]) == set(SPECIES.ranges)


def test_every_assumed_number_is_named_wherever_results_are(found):
    assert (selectivity_table(found)["assumed"] == " ".join(SPECIES.assumed)).all()
    assert sensitivity_table(found)["source"].str.startswith("assumed").all()


def test_l50_of_the_table_is_where_the_retention_table_crosses_one_half(found):
    l50 = selectivity_table(found).set_index("case")["l50_cm"]
    for case, rows in retention_table(found).groupby("case"):
        crossing = np.interp(0.5, rows["retention"], rows["length_cm"])
        assert abs(crossing - l50[case]) < 0.25  # length classes of 1 cm


def test_l50_rises_with_the_catch_as_meshes_open_and_the_haul_lies_between(found):
    table = selectivity_table(found)
    catches, haul = table.iloc[:-1], table.iloc[-1]
    assert (np.diff(catches["opening_ahead_deg"]) > 0.0).all()
    assert (np.diff(catches["l50_cm"]) > 0.0).all()
    assert catches["l50_cm"].min() < haul["l50_cm"] < catches["l50_cm"].max()
    assert haul["sr_cm"] > catches["sr_cm"].max()


def test_interval_of_the_haul_holds_the_logit_curve_it_was_drawn_from(found):
    haul = selectivity_table(found).iloc[-1]
    assert haul["l50_lower_95_cm"] < haul["l50_logit_cm"] < haul["l50_upper_95_cm"]
    assert haul["sr_lower_95_cm"] < haul["sr_logit_cm"] < haul["sr_upper_95_cm"]


def test_a_folder_gives_the_same_as_the_study_in_memory(folder, found):
    again = selectivity_table(predict(read_run(folder), [SPECIES], n_bootstrap=200, samples=16))
    pd.testing.assert_frame_equal(again, selectivity_table(found), rtol=1e-9)


def test_a_full_globalised_net_has_nearly_the_selectivity_of_its_sector(run):
    asked = {"fidelity": "globalised", "globalisation": 2}
    plan = make_plan(40, 30, filled=[4.0, 8.0, 14.0, 20.0], model=asked)
    full = predict(run_of(codend.solve(plan)), [SPECIES], n_bootstrap=0, samples=0)[0]
    sector = predict(run, [SPECIES], n_bootstrap=0, samples=0)[0]
    np.testing.assert_allclose(full.l50_sr[:, 0], sector.l50_sr[:, 0], rtol=0.03)


def test_the_command_writes_tables_plots_and_a_section_and_replaces_its_own(folder):
    (folder / "report.html").write_text("<html><body><h2>Inputs</h2></body></html>", encoding="utf-8")
    asked = [
        "selectivity",
        str(folder),
        "--species",
        str(example_species_path()),
        "--bootstrap",
        "50",
        "--samples",
        "8",
    ]
    for _ in range(2):
        result = CliRunner().invoke(main, asked)
        assert result.exit_code == 0, result.output
    assert "assumed, not measured" in result.output
    for name in ("selectivity.csv", "retention.csv", "sensitivity.csv"):
        assert len(pd.read_csv(folder / name))
    plots = sorted((folder / "plots").glob("selectivity_*.png"))
    assert len(plots) == 5
    assert all(path.stat().st_size > 10_000 for path in plots)
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert page.count("<!-- selectivity -->") == page.count("<!-- end of selectivity -->") == 1
    assert page.index("Selectivity</h2>") < page.index("Inputs</h2>")
    assert "assumed, not measured" in page


def test_texts_of_the_sensitivity_plot_stand_apart_and_under_their_own_panel(found):
    figure = sensitivity_plot(found)
    figure.canvas.draw()
    for axes in figure.axes:
        panel, label = axes.get_window_extent(), axes.xaxis.label.get_window_extent()
        assert panel.x0 < label.x0 < label.x1 < panel.x1
        legend = axes.get_legend().get_window_extent()
        assert not any(bar.get_window_extent().overlaps(legend) for bar in axes.patches)
    boxes = [text.get_window_extent() for text in figure.findobj(Text) if text.get_visible() and text.get_text()]
    for one, other in itertools.combinations(boxes, 2):
        assert not one.padded(0.02 * figure.dpi).overlaps(other)


def test_names_in_species_files_cannot_write_into_the_page(found, tmp_path):
    (tmp_path / "report.html").write_text("<body></body>", encoding="utf-8")
    bad = SPECIES.model_copy(update={"name": "<script>alert(1)</script>"})
    haul = found[0]
    write_selectivity([Prediction(**{**haul.__dict__, "species": bad})], tmp_path)
    assert "<script>" not in (tmp_path / "report.html").read_text(encoding="utf-8")


def test_a_page_without_a_known_place_still_gets_its_section():
    once = with_part("text", "one", "x")
    assert once == "text<!-- one -->\nx\n<!-- end of one -->\n"
    assert with_part(once, "one", "y").count("<!-- one -->") == 1
    assert with_part(once, "one", "") == "text"


def test_a_folder_that_no_run_wrote_is_refused(tmp_path, folder):
    with pytest.raises(InputError, match="a folder that codend run wrote"):
        read_run(tmp_path / "nothing")
    (folder / "profile.csv").unlink()
    with pytest.raises(InputError, match=r"profile\.csv"):
        read_run(folder)


def test_a_run_without_a_solved_case_is_refused(run):
    failed = Run(run.source, run.plan, run.results.assign(converged=False), run.profile, run.meshes)
    with pytest.raises(InputError, match="at least one solved case"):
        catches_of(failed, 5.0)


def test_merged_square_meshes_stand_for_the_real_rows_they_cover():
    """None of them behind the front, where a fish has no mesh to try."""
    merged = {"fidelity": "globalised", "globalisation": 4}
    (catch,) = catches_of(run_of(codend.solve(make_plan(24, 24, filled=8.0, mesh="square", model=merged))), 4.0)
    rows = np.bincount(catch.rows_ahead.round().astype(int), weights=catch.share)
    assert catch.rows_ahead == pytest.approx(catch.rows_ahead.round())
    assert rows == pytest.approx([0.0, 1.0, 1.0, 1.0, 1.0])


def test_a_plan_written_back_is_the_same_plan(tmp_path):
    plan = make_plan(netting={"knot_mm": 3.0, "twines": 2}, catch={"mass_kg": [1.0, 2.5], "pressure": "uniform"})
    (tmp_path / "plan.toml").write_text(plan_toml(plan), encoding="utf-8")
    assert load_plan(tmp_path / "plan.toml").to_dict() == plan.to_dict()


# --- directions known from trials, none of them tuned ----------------------------------------------------------------

MASSES_KG = (50.0, 150.0, 400.0, 800.0)


def commercial(
    mesh: str = "diamond", mesh_mm: float = 110.0, meshes_round: int = 100, masses_kg: tuple[float, ...] = MASSES_KG
) -> Plan:
    """Codends of single 4 mm twine and 4.4 m of stretched netting; sizes assumed, none measured."""
    netting = {"mesh": mesh, "meshes_round": meshes_round, "meshes_long": round(4400 / mesh_mm)}
    return plan_from_dict(
        {
            "title": "directions",
            "tow": {"speed_m_s": 1.6, "water_density_kg_m3": 1026.0},
            "entry": {"radius_m": 0.35},
            "netting": [netting | {"mesh_mm": mesh_mm, "knot_mm": 12.0, "twine_mm": 4.0}],
            "catch": {"mass_kg": list(masses_kg)},
            # directions of the mean row: folds under contact take a minute a catch of stiff T90
            "model": {"contact": False},
        }
    )


def l50_cm(plan: Plan) -> tuple[float, np.ndarray]:
    """L50 over the haul and for each catch."""
    study = codend.solve(plan)
    assert study.converged
    found = predict(run_of(study), [SPECIES], n_bootstrap=0, samples=0)[0]
    return float(found.l50_sr[-1, 0]), found.l50_sr[:-1, 0]


def test_l50_rises_nearly_in_proportion_to_the_mesh_size_at_the_same_stretched_circumference(capsys):
    sizes = (90.0, 110.0, 130.0)
    plans = [commercial(mesh_mm=mm, meshes_round=round(6600 / mm)) for mm in sizes]
    inside_cm = np.array([100.0 * plan.netting[0].inside_mesh_m for plan in plans])
    l50 = np.array([l50_cm(plan)[0] for plan in plans])
    with capsys.disabled():
        text = ", ".join(f"{f:.2f} at {mm:g} mm" for f, mm in zip(l50 / inside_cm, sizes, strict=True))
        print(f"\nL50 / inside mesh size, assumed round fish: {text}; published for haddock: 2.6 to 2.9")
    exponent = np.polyfit(np.log(inside_cm), np.log(l50), 1)[0]
    assert 0.7 < exponent < 1.1
    assert (np.diff(l50) > 0.0).all()


def test_l50_rises_with_fewer_meshes_round_and_that_is_most_of_turning_and_halving(capsys):
    l50 = [l50_cm(commercial(meshes_round=n))[0] for n in (100, 75, 50)]
    both = l50_cm(commercial("t90", meshes_round=50))[0]
    with capsys.disabled():
        print(
            f"\n110 mm, assumed round fish: halving the meshes round {l50[-1] - l50[0]:+.1f} cm, with T90 "
            f"{both - l50[0]:+.1f} cm; published: about +12 cm for both, the larger part from halving"
        )
    assert (np.diff(l50) > 0.0).all()
    assert both > l50[0]
    assert l50[-1] - l50[0] > 0.5 * (both - l50[0])


def test_l50_rises_with_the_catch_in_every_codend():
    for plan in (commercial(), commercial(meshes_round=60), commercial("t90"), commercial("t90", meshes_round=50)):
        assert (np.diff(l50_cm(plan)[1]) > 0.0).all()


def test_t90_lets_longer_fish_go_than_t0_once_the_catch_has_opened_the_meshes(capsys):
    gains = []
    for meshes_round in (60, 50, 40):
        t0, t90 = (l50_cm(commercial(mesh, 110.0, meshes_round, (400.0, 1000.0, 1600.0)))[1] for mesh in KINDS)
        gains.append(t90[1:] - t0[1:])
    with capsys.disabled():
        print(f"\nT90 less T0 at 1000 and 1600 kg, 60, 50 and 40 meshes round: {np.round(gains, 1).tolist()} cm")
    assert (np.array(gains) > 0.0).all()


KINDS = ("diamond", "t90")


LIMP_N_M2 = 1e-4
"""Assumed bending stiffness of a single 3.5 mm twine; that of others grows with the fourth power of the diameter."""


def stiff(plan: Plan, bending_n_m2: float, **changes: object) -> Plan:
    """The plan with stiff twine, at rest nearly closed in the direction in which the netting was made."""
    data = plan.to_dict()
    turned = data["netting"][0]["mesh"] == "t90"
    rest = {"bending_stiffness_n_m2": bending_n_m2, "rest_opening_deg": 160.0 if turned else 20.0}
    data["netting"][0] |= rest | changes
    return plan_from_dict(data)


def test_stiff_twine_holds_t90_open_so_that_it_lets_longer_fish_go_than_t0_over_the_whole_haul(capsys):
    bending = 10.0 * LIMP_N_M2
    l50 = {
        mesh: np.array([l50_cm(stiff(commercial(mesh, meshes_round=n), bending))[0] for n in (100, 75, 50)])
        for mesh in KINDS
    }
    with capsys.disabled():
        gain = l50["t90"] - l50["diamond"]
        both = l50["t90"][-1] - l50["diamond"][0]
        halved = l50["diamond"][-1] - l50["diamond"][0]
        print(
            f"\nT90 less T0 with EI = {bending:g} N m2 (assumed), 100, 75, 50 meshes round: {np.round(gain, 1)} cm; "
            f"halving the meshes round {halved:+.1f} cm, with T90 {both:+.1f} cm; published: about +12 cm for both"
        )
    assert (l50["t90"] > l50["diamond"]).all()


def test_l50_falls_with_stiffer_and_doubled_twine(capsys):
    ratios = []
    for meshes_round in (100, 75, 50):
        thin, thick = (
            l50_cm(stiff(commercial(meshes_round=meshes_round), bending, twine_mm=diameter, twines=twines))[0]
            for diameter, twines, bending in (
                (3.5, 1, LIMP_N_M2),
                (6.0, 2, 2.0 * (6.0 / 3.5) ** 4 * LIMP_N_M2),
            )
        )
        ratios.append(thick / thin)
    with capsys.disabled():
        print(
            f"\nL50 with double 6 mm over single 3.5 mm twine, 100, 75, 50 meshes round: {np.round(ratios, 3)}; "
            f"published for 3.5 to 6 mm double twine: {2.38 / 2.64:.3f}"
        )
    assert (np.array(ratios) < 1.0).all()
