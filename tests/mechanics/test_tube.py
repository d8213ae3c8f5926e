"""A bag that maps one to one to a cone passes through itself nowhere, as a search and an independent judge find it."""

from collections import Counter
from dataclasses import replace

import ipctk
import numpy as np
import pytest

from codend.bag.build import build_bag
from codend.bag.loads import problem_of
from codend.mechanics.piercing import first_pierced
from codend.mechanics.tube import NO_TUBE, maps_to_a_cone, tube_of
from codend.solvers import newton
from tests.plans import make_plan
from validation.passing_through import set_all_round

KINDS = [("diamond", {}), ("diamond", {"knot_mm": 8.0}), ("t90", {"knot_mm": 8.0}), ("square", {})]


def bag_at_rest(mesh, netting, meshes_round=12, sectors=1, meshes_long=10):
    plan = make_plan(meshes_round, meshes_long, mesh=mesh, netting=netting, filled=3.0)
    bag = build_bag(plan, sectors=sectors)
    problem = problem_of(bag, plan, plan.cases()[0])
    return problem, newton.solve(problem, 1e-8).positions


def is_one_to_one(problem, positions):
    s = problem.structure
    return maps_to_a_cone(positions, s.facets, s.facet_image, s.rotations, s.order, *problem.tube)


def pierced(problem, positions):
    """Whether a bar pierces any triangle of either division, by next to nothing."""
    s = problem.structure
    every = np.ones_like(s.facet_weight)
    sheet = (s.first, s.second, s.image, s.facets, s.facet_image, every, s.order)
    return first_pierced(positions, *sheet, 1e-7 * s.length.min())[0] >= 0


def changed(problem, positions, rng):
    """The bag shaken, wrung, folded along itself, in waves, or all at random; held where it was in most."""
    place, bar = positions.copy(), problem.structure.length.max()
    x, radius = place[:, 0], np.hypot(place[:, 1], place[:, 2])
    azimuth, along = np.arctan2(place[:, 2], place[:, 1]), (x - x.min()) / np.ptp(x)
    kind = rng.integers(6)
    if kind == 0:
        place += 10 ** rng.uniform(-3.0, 0.5) * bar * rng.normal(size=place.shape)
    elif kind == 1:
        azimuth += rng.normal() * 10 ** rng.uniform(-1.0, 1.0) * np.sin(0.5 * np.pi * rng.integers(1, 6) * along)
        place[:, 1:] = np.stack([radius * np.cos(azimuth), radius * np.sin(azimuth)], axis=1)
    elif kind == 2:
        fold = rng.uniform(0.3, 1.0)
        place[:, 0] -= np.maximum(along - fold, 0.0) * rng.uniform(1.0, 3.0) * np.ptp(x)
        place[:, 1:] *= np.interp(along, np.linspace(0.0, 1.0, 4), rng.uniform(0.2, 2.0, 4))[:, None]
    elif kind == 3:
        waves = np.sin(rng.uniform(2.0, 40.0) * along + rng.uniform(0.0, 6.0))
        place[:, 1:] *= 1.0 + 10 ** rng.uniform(-2.0, 0.5) * waves[:, None]
    elif kind == 4:
        place[:, 0] += 10 ** rng.uniform(-2.0, 0.5) * bar * np.sin(rng.uniform(2.0, 60.0) * along)
    else:
        place = rng.normal(size=place.shape) * bar * [5.0, 1.0, 1.0]
    held = problem.net.fixed if rng.random() < 0.7 else np.zeros_like(problem.net.fixed)
    place = np.where(held, problem.net.positions, place)
    place[problem.tube.apex, 1:] = 0.0
    return np.ascontiguousarray(place)


@pytest.mark.parametrize(("mesh", "netting"), KINDS)
@pytest.mark.parametrize(("meshes_round", "sectors"), [(12, 1), (12, 3), (5, 1)])
def test_what_is_one_to_one_is_pierced_nowhere(mesh, netting, meshes_round, sectors):
    problem, positions = bag_at_rest(mesh, netting, meshes_round, sectors)
    assert is_one_to_one(problem, positions)
    rng, seen = np.random.default_rng(11), Counter()
    for _ in range(300):
        place = changed(problem, positions, rng)
        seen[is_one_to_one(problem, place), pierced(problem, place)] += 1
    assert seen[True, True] == 0
    # neither is the proof idle, nor the nets tame
    assert seen[True, False] > 60
    assert seen[False, True] > 60


@pytest.mark.parametrize(("mesh", "netting"), KINDS)
def test_an_independent_judge_finds_no_crossing_in_what_is_one_to_one(mesh, netting):
    problem, positions = bag_at_rest(mesh, netting)
    rng, seen = np.random.default_rng(12), Counter()
    for _ in range(40):
        place = changed(problem, positions, rng)
        nodes, bars, facets = set_all_round(problem.net, place)
        # of quadrangles covered twice the first two triangles share a diagonal
        single = facets[np.tile(problem.net.facet_weight, problem.net.sectors) == 1.0]
        mesh_of_all = ipctk.CollisionMesh(nodes, np.concatenate([bars, ipctk.edges(single)]), single)
        seen[is_one_to_one(problem, place), bool(ipctk.has_intersections(mesh_of_all, nodes))] += 1
    assert seen[True, True] == 0
    assert seen[True, False] > 5


@pytest.mark.parametrize("mesh", ["diamond", "square"])
def test_cones_are_one_to_one_as_far_as_their_netting_faces_out_of_the_cone(mesh):
    """The bounds of the slope: a narrowing or widening bag is one up to acos(1/10) from the cone's normal."""
    # a sector so narrow that its facets are all but flat across
    problem, positions = bag_at_rest(mesh, {}, 60)
    row, limit = problem.loading.catch.node_row, np.degrees(np.arccos(0.1))
    tilt = np.degrees(np.arctan(1.0 / 3.0))
    for slope, one in (
        (tilt - limit + 3.0, True),
        (tilt - limit - 3.0, False),
        (0.0, True),
        (89.0, True),
        (tilt + limit - 3.0, True),
        (tilt + limit + 3.0, False),
    ):
        # rows from 1 on lie on a cone that narrows by the slope, and end on the axis where that narrows
        place, angle = positions.copy(), np.radians(slope)
        radius = np.hypot(*positions[:, 1:].T)
        aft = row.max() - row if slope > 0.0 else row + 1
        on_cone = 0.02 * aft * np.abs(np.sin(angle)) if slope != 0.0 else np.full(len(row), 0.1)
        place[:, 1:] *= (on_cone / np.where(radius > 0.0, radius, 1.0))[:, None]
        place[:, 0] = 0.02 * np.cos(angle) * row
        place[problem.tube.apex] = [place[:, 0].max() + (0.02 if slope <= 0.0 else 0.0), 0.0, 0.0]
        # what closes a widening cone is no part of it
        facets = problem.structure.facets
        own = ~(facets == problem.tube.apex).any(axis=1) if slope <= 0.0 else np.ones(len(facets), dtype=bool)
        s = problem.structure
        of_facets = np.ascontiguousarray(facets[own]), np.ascontiguousarray(s.facet_image[own])
        assert maps_to_a_cone(place, *of_facets, s.rotations, s.order, *problem.tube) == one, slope


def test_only_facets_that_make_one_tube_with_bars_along_their_sides_are_one():
    problem, positions = bag_at_rest("diamond", {})
    net, tube = problem.net, problem.tube
    middle = len(net.facets) // 2
    missing = np.delete(np.arange(len(net.facets)), middle)

    def without(rows):
        return replace(
            net, facets=net.facets[rows], facet_image=net.facet_image[rows], facet_weight=net.facet_weight[rows]
        )

    assert tube_of(without(np.arange(len(net.facets)))) is not NO_TUBE
    # a hole is a rim of its own
    holed, s = tube_of(without(missing)), problem.structure
    assert len(holed.rim) > len(tube.rim)
    of_facets = s.facets[missing], s.facet_image[missing]
    assert not maps_to_a_cone(positions, *of_facets, s.rotations, s.order, *holed)
    assert tube_of(without(np.append(missing, [middle, middle]))) is NO_TUBE
    turned, image = net.facets.copy(), net.facet_image.copy()
    turned[middle], image[middle] = turned[middle, ::-1], image[middle, ::-1]
    assert tube_of(replace(net, facets=turned, facet_image=image)) is NO_TUBE
    assert tube_of(replace(net, facet_weight=np.full(len(net.facets), 0.5))) is NO_TUBE
    across = net.bars.copy()
    across[middle // 4] = [0, len(net.positions) - 2]
    assert tube_of(replace(net, bars=across)) is NO_TUBE
    assert tube_of(replace(net, bar_image=net.bar_image + 1)) is NO_TUBE
    assert tube_of(replace(net, order=2)) is NO_TUBE
    assert tube_of(replace(net, order=11.5)) is NO_TUBE
    # two nodes held on the axis: no telling which closes it
    assert tube_of(replace(net, fixed=np.ones_like(net.fixed), positions=net.positions * [1.0, 0.0, 0.0])) is NO_TUBE


def test_a_codline_off_the_axis_or_a_rim_that_turns_back_proves_nothing():
    problem, positions = bag_at_rest("t90", {"knot_mm": 8.0}, 12, 3)
    aside = positions.copy()
    aside[problem.tube.apex, 1] = 1e-12
    assert not is_one_to_one(problem, aside)
    a, b = problem.tube.rim[0]
    swapped = positions.copy()
    swapped[[a, b]] = positions[[b, a]]
    assert not is_one_to_one(problem, swapped)
    unknown = positions.copy()
    unknown[len(unknown) // 2] = np.nan
    assert not is_one_to_one(problem, unknown)
