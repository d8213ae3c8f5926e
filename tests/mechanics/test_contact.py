"""Contact: distances against ipctk's, forces against differences of their energy, images, and moves cut in time."""

from dataclasses import replace

import ipctk
import numpy as np
import pytest
from scipy.spatial import cKDTree

from codend.bag.build import build_bag
from codend.mechanics import contact
from codend.mechanics.contact import Contact, room, write_corners
from codend.mechanics.nearest import NODE_TRIANGLE, nearest
from codend.mechanics.structure import structure_of
from codend.mechanics.surface import ContactLaw, Surface
from codend.mechanics.tangent import pattern_of, with_contact
from codend.net.net import Floats, Net, rotate
from tests.mechanics.test_tangent import dense
from tests.plans import make_plan

LAW = ContactLaw(0.03, 100.0)
MESHES = ["diamond", "knotted", "t90", "square"]


def crumpled(mesh: str, sectors: int | None, seed: int = 3) -> tuple[Net, Floats]:
    """A net so shaken that many of its parts are near each other, knots on the axis left there."""
    netting = {"twine_mm": 4.0, "knot_mm": 20.0 if mesh in {"knotted", "t90"} else 0.0}
    kind = "diamond" if mesh == "knotted" else mesh
    net = build_bag(make_plan(12, 6, 0.2, mesh=kind, bar_mm=100.0, netting=netting), sectors=sectors).net
    shaken = net.positions + 0.02 * np.random.default_rng(seed).normal(size=net.positions.shape)
    return net, np.where(net.fixed, net.positions, shaken)


def push(position: Floats, near: Contact) -> Floats:
    force = np.zeros_like(position)
    contact.add_force(position, near, force)
    return force


def far_enough(position: Floats, near: Contact) -> Contact:
    """The pairs that are no nearer than a hundredth of the reach: differences of nearer ones lose their digits."""
    found, keep = room(), []
    for pair in range(len(near.kind)):
        write_corners(position, near.node, near.image, near.rotations, pair, found.corner)
        keep.append(nearest(near.kind[pair], found)[1] > (0.05 * LAW.distance_m) ** 2)
    return near._replace(**{name: getattr(near, name)[keep] for name in ("node", "image", "kind", "weight", "even")})


@pytest.mark.parametrize("kind", [NODE_TRIANGLE, 1])
def test_distances_are_those_of_ipctk(kind):
    found, rng = room(), np.random.default_rng(kind)
    theirs = ipctk.point_triangle_distance if kind == NODE_TRIANGLE else ipctk.edge_edge_distance
    for _ in range(500):
        found.corner[:] = rng.normal(size=(4, 3)) * rng.choice([0.01, 1.0], size=(4, 1))
        _, square = nearest(kind, found)
        assert square == pytest.approx(theirs(*found.corner), rel=1e-9, abs=1e-15)


@pytest.mark.parametrize("mesh", MESHES)
@pytest.mark.parametrize("sectors", [2, None])
def test_the_push_is_the_slope_of_an_energy_and_its_tangent_that_of_the_push(mesh, sectors):
    net, position = crumpled(mesh, sectors)
    near = far_enough(position, Surface.of(net, LAW).near(position))
    force = push(position, near)
    pattern = pattern_of(structure_of(net), near=(near.node, near.image))
    blocks = np.zeros((len(pattern.row), 3, 3))
    contact.add_tangent(position, near, pattern, blocks)
    tangent = dense(pattern, blocks, len(position))
    assert np.abs(tangent - tangent.T).max() <= 1e-12 * np.abs(tangent).max()
    move = np.random.default_rng(1).normal(size=position.shape) * ~net.fixed
    h = 1e-6 * LAW.distance_m
    there, back = (push(position + sign * h * move, near) for sign in (1.0, -1.0))
    expected = -(there - back).ravel() / (2.0 * h)
    assert np.abs(tangent @ move.ravel() - expected).max() <= 1e-5 * np.abs(expected).max()
    energies = [energy_of(position + sign * h * move, near) for sign in (1.0, -1.0)]
    assert (energies[1] - energies[0]) / (2.0 * h) == pytest.approx((force * move).sum(), rel=1e-6)


@pytest.mark.parametrize("sectors", [2, None])
def test_blocks_of_what_is_near_are_added_to_a_pattern_as_if_all_were_sorted_again(sectors):
    net, position = crumpled("diamond", sectors)
    near = Surface.of(net, LAW).near(position)
    assert len(near.kind) > 100
    bare, whole = pattern_of(structure_of(net)), pattern_of(structure_of(net), near=(near.node, near.image))
    for found, expected in zip(with_contact(bare, near.node), whole, strict=True):
        assert found.dtype == expected.dtype
        np.testing.assert_array_equal(found, expected)


def energy_of(position: Floats, near: Contact) -> float:
    """The energy of all pairs, by ipctk's distances."""
    total, found = 0.0, room()
    for pair in range(len(near.kind)):
        write_corners(position, near.node, near.image, near.rotations, pair, found.corner)
        p = found.corner
        of_nodes = near.kind[pair] == NODE_TRIANGLE
        square = ipctk.point_triangle_distance(*p) if of_nodes else ipctk.edge_edge_distance(*p)
        d, counts = np.sqrt(square), 1.0
        if d >= near.distance:
            continue
        if not of_nodes:
            share = (np.linalg.norm(np.cross(p[1] - p[0], p[3] - p[2])) ** 2) / near.even[pair]
            counts = (2.0 - share) * share if share < 1.0 else 1.0
        total -= near.weight[pair] * counts * near.stiffness * (d - near.distance) ** 2 * np.log(d / near.distance)
    return total


@pytest.mark.parametrize("mesh", MESHES)
def test_what_one_part_does_to_others_they_do_to_it(mesh):
    net, position = crumpled(mesh, None)
    force = push(position, Surface.of(net, LAW).near(position))
    assert np.abs(force).max() > 10.0
    assert np.abs(force.sum(axis=0)).max() <= 1e-9 * np.abs(force).max()
    assert np.abs(np.cross(position, force).sum(axis=0)).max() <= 1e-9 * np.abs(force).max()


@pytest.mark.parametrize("mesh", MESHES)
@pytest.mark.parametrize("sectors", [1, 2, 3])
def test_a_sector_feels_its_images_as_a_part_of_the_whole_net_does(mesh, sectors):
    net, position = crumpled(mesh, sectors)
    whole = build_bag(make_plan(12, 6, 0.2, mesh="diamond" if mesh == "knotted" else mesh, bar_mm=100.0, netting={
        "twine_mm": 4.0, "knot_mm": 20.0 if mesh in {"knotted", "t90"} else 0.0})).net  # fmt: skip
    order = net.sectors

    def all_round(nodes: Floats) -> Floats:
        turned = np.broadcast_to(nodes, (order, *nodes.shape))
        return rotate(turned, np.arange(order)[:, None], order).reshape(-1, 3)

    place = cKDTree(all_round(net.positions)).query(whole.positions)[1]
    nodes = all_round(position)[place]
    mine = push(position, Surface.of(net, LAW).near(position))
    theirs = push(nodes, Surface.of(whole, LAW).near(nodes))
    expected = all_round(mine)[place]
    off_axis = np.hypot(*whole.positions[:, 1:].T) > 1e-9
    assert np.abs((theirs - expected)[off_axis]).max() <= 1e-8 * np.abs(mine).max()
    assert theirs[~off_axis, 0] == pytest.approx(order * expected[~off_axis, 0], abs=1e-8 * np.abs(mine).max())


def test_nothing_passes_through_anything_on_100_random_nets():
    rng = np.random.default_rng(0)
    cut = 0
    for seed in range(100):
        count = int(rng.integers(4, 9))
        nodes = np.stack(np.meshgrid(np.arange(count), np.arange(count), [0.0, 0.3]), axis=-1).reshape(-1, 3)
        number = np.arange(len(nodes)).reshape(count, count, 2).transpose(2, 0, 1)
        a, b, c, d = number[:, :-1, :-1], number[:, 1:, :-1], number[:, 1:, 1:], number[:, :-1, 1:]
        facets = np.concatenate([np.stack(t, axis=-1).reshape(-1, 3) for t in ((a, b, c), (a, c, d))])
        bars = np.concatenate([np.stack(t, axis=-1).reshape(-1, 2) for t in ((a, b), (b, c))])
        net = Net.from_bars(nodes, bars, np.zeros(len(nodes), dtype=bool), facets=facets)
        surface = Surface.of(net, ContactLaw(0.05, 1.0))
        mesh = ipctk.CollisionMesh(nodes, surface.sheet.edge, np.array(net.facets))
        position = np.array(nodes)
        for _ in range(3):
            move = rng.normal(size=nodes.shape) * rng.uniform(0.1, 1.0)
            share = surface.free_share(position, move)
            cut += share < 1.0
            position = position + share * move
            assert not ipctk.has_intersections(mesh, position), seed
    assert cut > 200


def test_a_move_is_not_cut_far_short_of_where_ipctk_lets_it_go():
    net, position = crumpled("diamond", None, 5)
    surface = Surface.of(net, LAW)
    mesh = ipctk.CollisionMesh(np.array(net.positions), surface.sheet.edge, surface.sheet.face)
    for seed in range(5):
        move = 0.05 * np.random.default_rng(seed).normal(size=position.shape) * ~net.fixed
        share = surface.free_share(position, move)
        theirs = ipctk.compute_collision_free_stepsize(mesh, position, position + move)
        # parts that would pass each other nearer than a tenth of their distance end a move, not only those that meet
        assert 0.2 * theirs <= share <= 1.3 * theirs


@pytest.mark.parametrize("sectors", [2, None])
def test_pairs_that_an_earlier_search_left_are_those_of_a_search_anew(sectors):
    net, position = crumpled("t90", sectors)
    rng, kept = np.random.default_rng(5), Surface.of(net, LAW)
    for step in [0.0, *rng.choice([0.001, 0.02], size=12)]:
        move = np.where(net.fixed, 0.0, step * rng.normal(size=position.shape))
        seen, anew = (s.nearest_of(s.on_the_way(position, move), position + move) for s in (kept, Surface.of(net, LAW)))
        assert len(seen.kind)
        for one, other in zip(seen, anew, strict=True):
            assert np.array_equal(one, other)
        assert kept.free_share(position, move) == Surface.of(net, LAW).free_share(position, move)
        position = position + kept.free_share(position, move) * move


def test_surfaces_of_few_sectors_that_do_not_close_round_are_refused():
    net, _ = crumpled("diamond", 1)
    with pytest.raises(ValueError, match="whole number"):
        Surface.of(replace(net, order=3.5), LAW)
    with pytest.raises(ValueError, match="above 0"):
        Surface.of(net, ContactLaw(0.0, 1.0))


@pytest.mark.parametrize("far", [1e3, 1e9, 1e15])
def test_a_node_flung_far_from_a_net_changes_nothing_of_what_else_is_near(far):
    """The grid of cells was as large as the net: of more cells than a whole number holds memory was overwritten."""
    net, position = crumpled("diamond", None)
    knot, flung = 20, position.copy()
    flung[knot] = far
    near = [Surface.of(net, LAW).near(where).node for where in (position, flung)]
    others = [{tuple(pair) for pair in pairs if knot not in pair} for pairs in near]
    assert others[0] == others[1] != set()
