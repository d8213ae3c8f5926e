import numpy as np
import pytest

from codend.bag.bag import all_round
from codend.bag.build import build_bag
from codend.mechanics.weight import wet_weight
from codend.net.net import bar_vectors, facet_corners, split_bars
from tests.plans import make_plan

KINDS = [
    ("diamond", {}),
    ("diamond", {"knot_mm": 8.0}),
    ("t90", {"knot_mm": 8.0}),
    ("t90", {}),
    ("square", {}),
]


@pytest.mark.parametrize(("mesh", "netting"), KINDS)
def test_a_sector_repeated_all_round_is_the_full_net(mesh, netting):
    plan = make_plan(12, 8, mesh=mesh, netting=netting)
    full = build_bag(plan)
    sector = build_bag(plan, sectors=1)
    assert sector.net.order == 12
    whole = all_round(sector, sector.net.positions)

    def segments(positions, bars):
        ends = positions[bars].round(9) + 0.0
        return {tuple(sorted(map(tuple, pair))) for pair in ends}

    assert segments(whole.positions, whole.bars) == segments(full.net.positions, full.net.bars)
    assert len(full.net.bars) == 12 * len(sector.net.bars)
    assert len(full.net.facets) == 12 * len(sector.net.facets)
    assert len(full.mesh_sides) == 12 * len(sector.mesh_sides)


@pytest.mark.parametrize(("mesh", "netting"), KINDS)
def test_facets_close_the_bag_and_face_outward(mesh, netting):
    net = build_bag(make_plan(12, 8, mesh=mesh, netting=netting)).net
    corner = facet_corners(net, net.positions)
    area = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]) / 2
    middle = corner.mean(axis=1)
    outward = np.einsum("ij,ij->i", area[:, 1:], middle[:, 1:])
    assert np.all(outward > -1e-12)
    # the facets with a lid on the entry are a closed surface: no facet is missing or laid twice
    total = (area * net.facet_weight[:, None]).sum(axis=0)
    entry = net.positions[net.fixed.all(axis=1)]
    azimuth = np.sort(np.arctan2(entry[:, 2], entry[:, 1]))
    radius = np.hypot(entry[0, 1], entry[0, 2])
    lid = 0.5 * radius**2 * np.sin(np.diff(np.append(azimuth, azimuth[0] + 2 * np.pi))).sum()
    assert total == pytest.approx([lid, 0.0, 0.0], abs=1e-12)


def test_counts_of_knots_bars_and_meshes_are_those_of_the_netting():
    bag = build_bag(make_plan(12, 8))
    assert len(bag.net.positions) == 12 * 16 + 1
    assert len(bag.net.bars) == 2 * 12 * 16
    assert len(bag.mesh_sides) == 12 * 15
    knotted = build_bag(make_plan(12, 8, netting={"knot_mm": 8.0})).net
    assert len(knotted.bars) == 3 * 12 * 16
    assert np.count_nonzero(knotted.bar_drag_diameter == 0) == 12 * 16


def test_every_diamond_knot_inside_the_net_holds_four_twines():
    bag = build_bag(make_plan(12, 8))
    twines = np.bincount(bag.net.bars.ravel(), minlength=len(bag.net.positions))
    inner = np.isin(bag.node_row, range(1, 16))
    assert np.all(twines[inner] == 4)
    assert twines[-1] == 24


@pytest.mark.parametrize("sectors", [1, 2, None])
@pytest.mark.parametrize(("mesh", "netting"), KINDS)
def test_mesh_sides_name_their_bars(mesh, netting, sectors):
    bag = build_bag(make_plan(12, 8, mesh=mesh, netting=netting), sectors=sectors)
    there = bag.mesh_bars >= 0
    # the entry's ring is held and the codline a point: square meshes there have three sides of twine
    whole = ~np.isin(bag.mesh_row, [0, bag.bands - 1]) if mesh == "square" else np.ones(len(there), dtype=bool)
    assert np.all(there[whole])
    assert np.all(there.sum(axis=1)[~whole] == 3)
    sides = np.sort(bag.mesh_sides, axis=2)
    assert np.all(np.sort(bag.net.bars[bag.mesh_bars[there]], axis=1) == sides[there])


@pytest.mark.parametrize("g", [1, 2, 3, 4, 6, 12])
def test_globalisation_keeps_mass_weight_and_drag_area(g):
    plan = make_plan(36, 24, netting={"twines": 2, "twine_density_kg_m3": 1140.0})
    real, model = build_bag(plan).net, build_bag(plan, globalisation=g).net

    def mass(net):
        return (net.bar_density * np.pi / 4 * net.bar_solid_diameter**2 * net.bar_length).sum()

    def drag_area(net):
        return (net.bar_drag_diameter * net.bar_length).sum()

    assert mass(model) == pytest.approx(mass(real), rel=1e-13)
    assert drag_area(model) == pytest.approx(drag_area(real), rel=1e-13)
    assert wet_weight(model, 1026.0).sum() == pytest.approx(wet_weight(real, 1026.0).sum(), rel=1e-13)
    assert len(model.bars) == len(real.bars) / g**2


def test_globalised_elastic_bars_are_as_much_stiffer_as_they_carry_more():
    plan = make_plan(36, 24, netting={"axial_stiffness_n": 1000.0})
    assert np.unique(build_bag(plan, globalisation=3).net.bar_flexibility) == pytest.approx([1 / 3000])


def test_a_hinge_in_mid_bar_leaves_length_and_drag_area():
    net = build_bag(make_plan(12, 8, netting={"knot_mm": 8.0}), sectors=1).net
    twine = net.bar_drag_diameter > 0
    halved = split_bars(net, twine)
    assert halved.bar_length.sum() == pytest.approx(net.bar_length.sum())
    assert (halved.bar_length * halved.bar_drag_diameter).sum() == pytest.approx(
        (net.bar_length * net.bar_drag_diameter).sum()
    )
    whole = bar_vectors(halved, halved.positions)
    assert whole[np.flatnonzero(twine)] == pytest.approx(0.5 * bar_vectors(net, net.positions)[twine])


def test_sections_follow_one_another():
    plan = make_plan(12, 8)
    second = plan.netting[0].model_copy(update={"bar_mm": 20.0, "meshes_long": 3})
    joined = plan.model_copy(update={"netting": (plan.netting[0], second)})
    bag = build_bag(joined, sectors=1)
    assert len(joined.sections_of_bands()) == bag.bands == 22
    assert np.unique(bag.net.bar_length[bag.bar_band >= 16]) == pytest.approx([0.020])
    assert np.unique(bag.net.bar_length[bag.bar_band < 16]) == pytest.approx([0.040])


def test_knots_keep_their_length_on_rows_that_close_up():
    plan = make_plan(12, 8, netting={"knot_mm": 8.0})
    x, radius = np.linspace(0.0, 0.4, 17), np.full(17, 0.05)
    net = build_bag(plan, sectors=1, rows=(x, radius)).net
    knot = bar_vectors(net, net.positions)[net.bar_drag_diameter == 0.0]
    assert np.linalg.norm(knot[1:-1], axis=1) == pytest.approx(0.008, rel=1e-12)
