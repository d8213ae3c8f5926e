"""Whether errors of random cages cover shapes found on ways that the errors know nothing of.

``python -m validation.cage --covered 20 [--seed 0]``. The ways: the whole cage without regard to its mirror, barriers
that begin elsewhere, shaken by a fifth of a bar with other numbers, and a current that rises by steps from rest.
"""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from codend.mechanics.problem import Problem
from codend.net.net import Floats
from codend.scenes.build import BuiltScene, build
from codend.scenes.equilibrium import NEARBY, contact_law
from codend.scenes.measures import SceneResult, solve_scene
from codend.scenes.netting_measures import drag_of, volume_m3
from codend.scenes.other_shapes import frame_errors, other_shapes, shape_errors
from codend.scenes.scene import scene_from_dict
from codend.solvers import interior_point
from codend.solvers.interior_point import InteriorPointSettings
from codend.solvers.outcome import Solution
from codend.solvers.refusal import passage
from validation.cage.random_cages import random_cages

BARRIERS = (0.1, 0.5)
SHAKEN, STEPS = 0.2, 7
SAME = 1e-6
"""Relative difference that is no other shape."""


def on_ways_of_their_own(result: SceneResult) -> Iterator[tuple[str, Solution]]:
    """Where ways lead that ``other_shapes`` does not go."""
    problem, tolerance = result.built.problem, result.built.scene.model.tolerance
    known = result.solution
    touching = problem if problem.surface is not None else problem.touching_by(contact_law(problem, known.mean_tension))
    yield "whole", interior_point.solve(touching, tolerance)
    for barrier in BARRIERS:
        found = interior_point.solve(touching, tolerance, None, InteriorPointSettings(first_barrier=barrier))
        yield f"barrier {barrier:g}", found
    moves = np.random.default_rng(5).standard_normal(known.positions.shape) * ~problem.net.fixed
    moves *= SHAKEN * float(np.median(problem.net.bar_length))
    assert touching.surface is not None
    there = known.positions + touching.surface.free_share(known.positions, moves) * moves
    yield "shaken", interior_point.solve(touching.touching_at(there), tolerance, replace(known, positions=there))
    yield "by steps", _by_steps(touching, tolerance)


def _by_steps(touching: Problem, tolerance: float) -> Solution:
    water = touching.loading.water

    def at(share: float) -> Problem:
        return replace(touching, loading=touching.loading._replace(water=water._replace(flow=share * water.flow)))

    found = interior_point.solve(replace(at(0.0), surface=None), tolerance)
    for step in range(1, STEPS + 1):
        if not found.report.outcome.converged or passage(touching, found.positions) is not None:
            break
        found = interior_point.solve(at(step / STEPS).touching_at(found.positions), tolerance, found, NEARBY)
    return found


def drag_and_volume(built: BuiltScene, positions: Floats) -> Floats:
    """N and m3."""
    return np.array([drag_of(built, positions, built.bar_sheet >= 0)[0], volume_m3(built, positions)])


def row_of(data: dict[str, Any]) -> dict[str, Any] | None:
    """The largest changes of drag and volume, relative, and over the errors stated; None if it is not found."""
    result = solve_scene(build(scene_from_dict(data)))
    if not result.converged:
        return None
    here, built = drag_and_volume(result.built, result.solution.positions), result.built
    others = other_shapes(result)
    (pull,) = frame_errors(result, others)
    stated = np.array([pull["pull_error_n"], shape_errors(result, others)["volume_error_m3"]])
    row: dict[str, Any] = {"bars": len(built.problem.net.bars), "speed_m_s": data["water"]["flow_m_s"][0]}
    row |= {"ways": len(others), "drag_error": stated[0] / here[0], "volume_error": stated[1] / here[1]}
    worst, of = 0.0, ""
    for name, found in on_ways_of_their_own(result):
        if not found.report.outcome.converged or passage(built.problem.touching_by(contact_law(built.problem)),
                                                         found.positions) is not None:  # fmt: skip
            continue
        change = np.abs(drag_and_volume(built, found.positions) - here)
        real = change > SAME * here
        over = float(np.max(np.where(real, change / np.maximum(stated, SAME * here), 0.0)))
        if over >= worst:
            worst, of = over, name
            row |= {"drag": change[0] / here[0], "volume": change[1] / here[1]}
    return row | {"over_stated": worst, "by": of}


def rows_of(count: int, seed: int) -> list[dict[str, Any]]:
    """A row a cage that is found."""
    return [row for data in random_cages(count, seed) if (row := row_of(data)) is not None]
