"""Second layers of netting: what they carry, what they leave alone, and what fish make of them."""

from dataclasses import replace

import numpy as np
import pytest

from codend.bag.build import build_bag
from codend.bag.layer_measures import hoop_share_of_catch, measure_layers
from codend.equilibrium.fidelity import Reason, choose
from codend.errors import InputError
from codend.mechanics import wrap
from codend.mechanics.structure import structure_of
from codend.mechanics.tangent import pattern_of
from codend.plan.plan import Plan, plan_from_dict
from codend.report.choice_words import reason_text
from codend.report.layer_lines import layer_lines
from codend.report.page import files_of
from codend.report.plots import layers_plot
from codend.report.vtk import net_mesh
from codend.studies.study import solve
from tests.mechanics.test_tangent import dense

LOOSE = {"meshes_round": 100, "meshes_long": 20}
SNUG = {"meshes_round": 36, "meshes_long": 15}
TIGHT = {"meshes_round": 40, "meshes_long": 40, "bar_mm": 36.0, "axial_stiffness_n": 5e4}


def plan_with(layer: dict | None, mesh: str = "diamond", **tables: object) -> Plan:
    netting = {
        "mesh": mesh, "meshes_round": 100, "meshes_long": 50, "bar_mm": 45.0, "knot_mm": 15.0, "twine_mm": 4.0,
        "twines": 2, "axial_stiffness_n": 2000.0,
    }  # fmt: skip
    data: dict = {
        "title": "a bag in a bag",
        "tow": {"speed_m_s": 1.5, "water_density_kg_m3": 1025.0},
        "entry": {"radius_m": 0.4},
        "netting": [netting],
        "catch": {"mass_kg": 300.0},
        "model": {"wrinkles": False},
    }
    if layer is not None:
        own = {"mesh": "diamond", "bar_mm": 105.0, "knot_mm": 15.0, "twine_mm": 5.0, "axial_stiffness_n": 5000.0}
        data["layer"] = [own | {"meshes_from_codline": [0, 30]} | layer]
    return plan_from_dict(data | tables)


@pytest.mark.parametrize("mesh", ["diamond", "t90"])
@pytest.mark.parametrize("layer", [SNUG, TIGHT, {"mesh": "t90", "meshes_round": 20, "meshes_long": 20}])
def test_a_layers_tangent_is_the_slope_of_its_force(mesh, layer):
    bag = build_bag(plan_with(layer, mesh), sectors=1)
    structure = structure_of(bag.net)
    position = bag.net.positions * [1.0, 1.3, 1.3]
    pattern = pattern_of(structure)
    blocks = np.zeros((len(pattern.row), 3, 3))
    wrap.add_tangent(position, structure, pattern, blocks)
    move = np.random.default_rng(0).normal(size=position.shape)
    move[np.hypot(position[:, 1], position[:, 2]) == 0.0, 1:] = 0.0
    there, back = np.zeros((2, *position.shape))
    wrap.add_force(position + 1e-7 * move, structure, there)
    wrap.add_force(position - 1e-7 * move, structure, back)
    found = dense(pattern, blocks, len(position)) @ move.ravel()
    assert np.abs(found).max() > 0.0
    assert np.abs(found + (there - back).ravel() / 2e-7).max() <= 1e-6 * np.abs(found).max()


def test_a_layer_far_larger_than_the_bag_changes_nothing_in_it():
    without, beside = (solve(plan_with(layer)).cases[0] for layer in (None, LOOSE))
    assert beside.measures.drag_n == pytest.approx(without.measures.drag_n, rel=1e-9)
    assert np.abs(beside.positions - without.positions).max() < 1e-9
    assert measure_layers(beside.bag, beside.problem, beside.solution)[0].bar_tension_n.max() == 0.0


def test_a_tight_layer_carries_the_whole_hoop_load_and_bounds_the_bag():
    study = solve(plan_with(TIGHT))
    result, row = study.cases[0], study.table.iloc[0]
    assert row["layer_hoop_share"] > 0.95
    bound = 40 * 0.036 / np.pi
    inside = study.layers[study.layers["x_m"] > result.measures.length_m - result.measures.front_from_codline_m]
    assert inside["radius_m"].max() < 1.01 * bound
    assert result.measures.max_radius_m < 0.9 * solve(plan_with(None)).cases[0].measures.max_radius_m


def test_both_layers_together_carry_the_drag_across_every_cut_ahead_of_the_catch():
    result = solve(plan_with(TIGHT, catch={"mass_kg": 300.0, "pressure": "uniform"}, drag={"normal": 0.0})).cases[0]
    (rows,) = measure_layers(result.bag, result.problem, result.solution)
    assert result.measures.entry_reaction_n == pytest.approx(result.measures.drag_n, rel=1e-6)
    cuts = np.flatnonzero((result.solution.share[rows.band.astype(int)] == 0.0) & (rows.axial_share > 0.01))
    assert len(cuts) > 3
    for cut in cuts[1:-1]:
        law = result.problem.structure.wrap_law[cut]
        t, q, along, _, _ = wrap.diagonals(result.positions, result.problem.structure, cut)
        own = wrap.stretch_of(law, t, q).by_q / law[wrap.ROWS]
        both = result.net.order * along * own / rows.axial_share[cut]
        assert both == pytest.approx(result.measures.drag_n, rel=2e-3)


def test_a_layer_opens_meshes_less_and_fish_have_to_pass_both():
    from codend.selectivity.escape.catches import catches_of, run_of

    bare, snug = (solve(plan_with(layer)) for layer in (None, SNUG))
    assert snug.table["opening_ahead_deg"][0] < bare.table["opening_ahead_deg"][0]
    holes, both = (catches_of(run_of(study), 8.0)[0].holes for study in (bare, snug))
    assert (both.bar_m <= holes.bar_m.max()).all()
    closed = plan_with({"meshes_round": 400, "meshes_long": 20})
    # meshes of a layer with so many round hang all but closed: fish meet them first
    tighter = catches_of(run_of(solve(closed)), 8.0)[0].holes
    assert tighter.bar_m.max() > holes.bar_m.max()
    assert tighter.half_angle_rad.max() < holes.half_angle_rad.min()


def test_a_strengthening_bag_is_solved_in_milliseconds_a_catch_in_a_series():
    study = solve(plan_with(SNUG, catch={"mass_kg": [100.0, 300.0, 500.0, 1000.0]}))
    assert study.converged
    assert study.table["layer_hoop_share"].is_monotonic_increasing
    assert list(study.tables) == ["results.csv", "profile.csv", "layers.csv"]


@pytest.mark.parametrize(
    ("layer", "tables", "said"),
    [
        ({"meshes_from_codline": [5, 30]}, {}, "layer.0.meshes_from_codline"),
        ({"meshes_from_codline": [0, 60]}, {}, "at most 50"),
        ({"meshes_from_codline": [0, 30.3]}, {}, "a row of knots"),
        ({"bending_stiffness_n_m2": 1e-3}, {}, "bending_stiffness_n_m2"),
        ({}, {"model": {"fidelity": "full"}}, "model.fidelity"),
        ({}, {"model": {"method": "rigid-bars"}}, "model.method"),
    ],
)
def test_layers_that_cannot_be_are_refused_in_one_line(layer, tables, said):
    with pytest.raises(InputError, match=said):
        plan_with(SNUG | layer, **tables)


def test_weight_that_a_layer_leaves_out_is_told_where_it_matters():
    heavy = plan_from_dict(plan_with(SNUG).said(), overrides={"netting.0.twine_density_kg_m3": 5000.0})
    choice = choose(heavy)
    assert choice.weight_matters
    assert choice.reason is Reason.LAYER
    assert "leaves out the wet weight, which here matters" in reason_text(choice)


@pytest.mark.parametrize("layer", [SNUG, TIGHT, {"mesh": "t90", "meshes_round": 20, "meshes_long": 20}])
def test_bars_of_a_layer_are_drawn_on_the_netting_below_about_as_long_as_they_are(layer):
    plan = plan_with(layer)
    result = solve(plan).cases[0]
    lines = layer_lines(result.bag, result.positions)
    own = plan.layer[0]
    assert len(lines) == 2 * own.meshes_round * own.rows_per_mesh * own.meshes_long
    length = np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1)
    assert length.max() < 1.05 * (own.bar_m + own.knot_m)
    assert np.hypot(*lines[..., 1:].T).max() <= result.measures.max_radius_m + 1e-9


def test_a_study_with_layers_has_a_plot_of_them_and_one_without_promises_none():
    plan = plan_with(SNUG)
    assert "plots/layers.png" in files_of(plan)
    assert "plots/layers.png" not in files_of(plan_with(None))
    opening, share = layers_plot(solve(plan)).axes
    assert [len(axes.lines) for axes in (opening, share)] == [1, 1]
    assert np.max(share.lines[0].get_ydata()) <= 1.0


def test_files_for_paraview_tell_what_a_layer_does_over_each_mesh():
    result = solve(plan_with(TIGHT)).cases[0]
    (rows,) = measure_layers(result.bag, result.problem, result.solution)
    told = net_mesh(result).cell_data
    for name, values in (("opening_deg", rows.opening_deg), ("hoop_share", rows.hoop_share)):
        over = told[f"layer_{name}"][1]
        assert np.isnan(over).any()
        assert (np.nanmin(over), np.nanmax(over)) == pytest.approx((values.min(), values.max()))


def test_a_layer_that_carries_all_over_netting_that_hangs_slack_round_carries_all_of_the_hoop_load():
    result = solve(plan_with(TIGHT)).cases[0]
    (rows,) = measure_layers(result.bag, result.problem, result.solution)
    whole = replace(rows, hoop_share=np.ones_like(rows.hoop_share))
    assert hoop_share_of_catch(whole, result.solution.share) == pytest.approx(1.0)
    assert 0.0 < hoop_share_of_catch(rows, result.solution.share) < 1.0


def test_a_layer_over_ropes_has_them_smeared_and_says_so():
    rope = {"kind": "lastridge", "number": 2, "shortening": 0.1, "diameter_mm": 20.0, "axial_stiffness_n": 1e5}
    plan = plan_with(LOOSE, rope=[rope])
    choice = choose(plan)
    assert (choice.fidelity, choice.reason) == ("smeared", Reason.LAYER_OVER_ROPES)
    assert "so are the ropes" in reason_text(choice)
    study = solve(plan)
    assert study.converged
    bare = solve(plan_from_dict(plan_with(None, rope=[rope]).to_dict(), overrides={"model.fidelity": "smeared"}))
    assert study.table["drag_n"][0] == pytest.approx(bare.table["drag_n"][0], rel=1e-9)


def test_panels_under_a_layer_are_refused_in_one_line():
    section = plan_with(SNUG).to_dict()["netting"][0] | {"panels": 2, "selvedge_meshes": 3}
    with pytest.raises(InputError, match=r"netting\.0\.panels"):
        choose(plan_with(SNUG, netting=[section]))
