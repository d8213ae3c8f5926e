"""Second layers of netting: what they carry, what they leave alone, and what fish make of them."""

from dataclasses import replace

import numpy as np
import pytest

from codend.bag.build import build_bag
from codend.bag.layer_measures import hoop_share_of_catch, measure_layers
from codend.equilibrium.fidelity import choose
from codend.errors import InputError
from codend.mechanics import wrap
from codend.mechanics.structure import structure_of
from codend.mechanics.tangent import pattern_of
from codend.plan.plan import Plan, plan_from_dict
from codend.report.html import cautions
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


ROPE = {"kind": "lastridge", "number": 2, "shortening": 0.05, "diameter_mm": 12.0, "axial_stiffness_n": 1e5}
SEAMS = {"panels": 2, "selvedge_meshes": 2, "meshes_round": 28}
SMALL_LAYERS = {
    "snug": {"meshes_round": 10, "meshes_long": 6},
    "tight": {"meshes_round": 12, "meshes_long": 15, "bar_mm": 36.0, "axial_stiffness_n": 5e4},
    "loose": {"meshes_round": 60, "meshes_long": 15},
    "t90": {"mesh": "t90", "meshes_round": 10, "meshes_long": 10},
    "square": {"mesh": "square", "meshes_round": 9, "meshes_long": 9, "knot_mm": 0.0},
}


def small_plan(layer: str | None, netting: dict | None = None, **tables: object) -> Plan:
    """A codend of 24 meshes round, of which a layer lies over the last 12 of 20."""
    own = plan_with(None).to_dict()["netting"][0] | {"meshes_round": 24, "meshes_long": 20, "twine_mm": 3.0}
    rest = {"entry": {"radius_m": 0.15}, "catch": {"filled_meshes": 8.0}, "netting": [own | (netting or {})]}
    over = None if layer is None else SMALL_LAYERS[layer] | {"meshes_from_codline": [0, 12]}
    return plan_with(over, **(rest | tables))


@pytest.mark.parametrize("mesh", ["diamond", "t90", "square"])
@pytest.mark.parametrize("layer", ["snug", "tight", "t90", "square"])
@pytest.mark.parametrize("sectors", [1, 3, None])
def test_a_layers_tangent_is_the_slope_of_its_force(mesh, layer, sectors):
    knots = {"mesh": mesh, "knot_mm": 0.0 if mesh == "square" else 15.0}
    bag = build_bag(small_plan(layer, knots), sectors=sectors)
    structure = structure_of(bag.net)
    random = np.random.default_rng(0)
    position = bag.net.positions * [1.5, 4.0, 4.0]
    position += 0.005 * random.normal(size=position.shape) * structure.free
    pattern = pattern_of(structure)
    blocks = np.zeros((len(pattern.row), 3, 3))
    wrap.add_tangent(position, structure, pattern, blocks)
    move = random.normal(size=position.shape)
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
        structure = result.problem.structure
        _, _, pull, _ = wrap.of_cells(np.ascontiguousarray(result.positions), structure)
        (band,) = result.bag.layer_bands
        own = np.abs(pull[band == rows.band[cut], 1, 0]).sum()
        both = result.net.order * own / rows.axial_share[cut]
        assert both == pytest.approx(result.measures.drag_n, rel=1e-8)


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
        ({}, {"model": {"fidelity": "meridian"}}, "model.fidelity"),
        ({}, {"model": {"method": "rigid-bars"}}, "model.method"),
    ],
)
def test_layers_that_cannot_be_are_refused_in_one_line(layer, tables, said):
    with pytest.raises(InputError, match=said):
        plan_with(SNUG | layer, **tables)


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


def test_a_layer_pulls_on_a_net_and_on_nothing_else():
    random = np.random.default_rng(1)
    for layer in ("tight", "t90", "square"):
        net = build_bag(small_plan(layer, {"mesh": "t90"})).net
        structure = structure_of(net)
        position = 1.2 * net.positions + 0.02 * random.normal(size=net.positions.shape)
        force = np.zeros_like(position)
        wrap.add_force(position, structure, force)
        size = np.abs(force).sum()
        assert size > 0.0
        assert np.abs(force.sum(axis=0)).max() < 1e-13 * size
        assert np.abs(np.cross(position, force).sum(axis=0)).max() < 1e-13 * size


GEAR = {"ropes": {"rope": [ROPE]}, "panels": {"netting": SEAMS}, "nothing": {}}


@pytest.mark.parametrize("layer", ["snug", "tight"])
@pytest.mark.parametrize("gear", GEAR)
def test_sectors_under_layers_are_the_whole_net(gear, layer):
    sector, full = (
        solve(small_plan(layer, **GEAR[gear], model={"wrinkles": False, "fidelity": fidelity}))
        for fidelity in ("sector", "full")
    )
    assert sector.converged
    assert full.converged
    for column in ("drag_n", "length_m", "opening_ahead_deg", "max_layer_tension_n", "layer_opening_deg"):
        assert full.table[column][0] == pytest.approx(sector.table[column][0], rel=1e-5), column
    assert full.table["layer_hoop_share"][0] == pytest.approx(sector.table["layer_hoop_share"][0], abs=1e-5)
    (of_sector,), (of_full,) = (
        measure_layers(study.cases[0].bag, study.cases[0].problem, study.cases[0].solution) for study in (sector, full)
    )
    order = sector.cases[0].net.order
    assert of_full.hoop_load == pytest.approx(order * of_sector.hoop_load, rel=1e-4)


@pytest.mark.parametrize("gear", GEAR)
def test_beside_ropes_and_seams_a_large_layer_changes_nothing_and_a_tight_one_carries_the_hoop_load(gear):
    bare, loose, tight = (solve(small_plan(layer, **GEAR[gear])) for layer in (None, "loose", "tight"))
    assert loose.table["drag_n"][0] == pytest.approx(bare.table["drag_n"][0], rel=1e-9)
    assert loose.table["max_layer_tension_n"][0] == 0.0
    assert tight.table["layer_hoop_share"][0] > 0.95
    # of the layer's 12 meshes round, pulled open
    assert tight.cases[0].measures.max_radius_m < 1.02 * 12 * (0.036 + 0.015) / np.pi


def test_the_report_says_what_a_layer_that_carries_takes_for_granted():
    tight, loose = (cautions(solve(small_plan(layer))) for layer in ("tight", "loose"))
    assert any("move with the netting below" in said for said in tight)
    assert not any("Second layers" in said for said in loose)


def test_under_weight_layers_lie_over_the_whole_net():
    heavy = small_plan("snug", {"twine_density_kg_m3": 5000.0}, model={"wrinkles": False})
    study = solve(heavy)
    assert study.table["fidelity"][0] in ("full", "globalised")
    assert study.converged
    # it hangs down, and its layer with it
    lines = layer_lines(study.cases[0].bag, study.cases[0].positions)
    assert lines[..., 2].mean() < -0.01


def test_what_grows_of_a_bag_grows_under_a_layer_that_does_not_reach_it():
    netting = {"mesh": "square", "knot_mm": 0.0, "meshes_round": 48}
    bare, loose = (
        solve(small_plan(layer, netting, entry={"radius_m": 0.03}, model={"wrinkles": False})).table.iloc[0]
        for layer in (None, "loose")
    )
    assert bare["stable"] == loose["stable"] == "no"
    assert bare["growing_harmonics"] == loose["growing_harmonics"]


def test_of_two_layers_each_carries_its_share_of_one_load():
    plan = small_plan("tight")
    both = plan.to_dict()
    both["layer"] = [both["layer"][0], both["layer"][0] | {"name": "outer", "meshes_from_codline": [0, 8]}]
    study = solve(plan_from_dict(both))
    assert study.converged
    assert 0.95 < study.table["layer_hoop_share"][0] <= 1.0
    shares = study.layers.pivot_table(index="row", columns="layer", values="hoop_share").sum(axis=1)
    assert shares.max() <= 1.0 + 1e-12


@pytest.mark.parametrize(
    ("tables", "said"),
    [
        ({"netting": [{"meshes_round": 24}, {"meshes_round": 24, "meshes_round_aft": 16}]}, "does not taper"),
        ({"window": True}, "no layer beside"),
    ],
)
def test_what_layers_have_no_place_over_is_refused_in_one_line(tables, said):
    data = small_plan("snug").to_dict()
    own = data["netting"][0]
    if "window" in tables:
        data["window"] = [
            {"mesh": "diamond", "meshes_round": 6, "meshes_long": 5, "bar_mm": 45.0, "knot_mm": 15.0, "twine_mm": 3.0}
            | {"netting": "1", "panel": "upper", "meshes_from_codline": [9, 14], "meshes_across": 6}
        ]
    else:
        data["netting"] = [own | part | {"meshes_long": 20} for part in tables["netting"]]
    with pytest.raises(InputError, match=said):
        choose(plan_from_dict(data))
