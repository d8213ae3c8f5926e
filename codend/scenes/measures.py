"""What is told of a scene: where its points are and what holds them, and the pull of every named rope."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from codend.mechanics.body import load, pose_of
from codend.net.net import Floats
from codend.scenes.build import BuiltScene
from codend.scenes.equilibrium import find, from_there, stays
from codend.scenes.frame_measures import frame_cautions
from codend.scenes.netting_measures import contact_share, netting_caution, volume_m3
from codend.solvers import floating, interior_point
from codend.solvers.half import half_of
from codend.solvers.outcome import START, Outcome, Solution
from codend.solvers.reactions import loads_and_supports

TO_AND_FRO_DEG, SEVERAL = 2.0, 2
"""Of a warp followed to 1 % no bar does so, of one that is off by 10 % or more 3 to 20 (motion as in
``validation.motion_map``, 10 bars or more)."""

STRETCHES = 0.3
"""Strain of a rope in equilibrium that is told: more than its axial stiffness, constant, is likely to be meant for."""
NOTHING_PULLS = (
    "Nothing pulls at anything here: any shape in which all is long enough is in balance, not this one alone."
)
LIES_ON_NETTING = (
    "Netting lies on netting here and presses on it without friction: several shapes may be in balance, of which this "
    "is the one found first."
)
WOULD_LEAVE = "This shape is in balance and would not stay so: moved a little, the netting would go on to another one."
UNLIKE = 0.01
"""Of the shortest bar of netting: by how much two sides of a mirrored scene may be unlike untold."""


@dataclass(frozen=True)
class SceneResult:
    """The equilibrium of a scene."""

    built: BuiltScene
    """The scene, its problem with the contact that acts."""
    solution: Solution
    load: Floats
    """On each node, N, (n, 3)."""
    support: Floats
    """What it takes to hold each node, N, (n, 3); of free nodes what is left out of balance."""

    @property
    def converged(self) -> bool:
        """Whether it may be used."""
        return self.solution.report.outcome.converged

    @cached_property
    def stable(self) -> str:
        """Whether netting held in balance would stay so if it were moved a little: yes or no; empty of other scenes."""
        if not (self.converged and self.built.sheet_nodes) or self.built.problem.body is not None:
            return ""
        return "yes" if stays(self.built.problem, self.solution) else "no"

    @cached_property
    def unlike_sides_m(self) -> float:
        """How far the two sides of a scene that is its own mirror image are from being so, m; nan of other scenes."""
        half = half_of(self.built.problem)
        return np.nan if half is None else half.unlike_m(self.solution.positions)


def solve_scene(built: BuiltScene) -> SceneResult:
    """Equilibrium of a scene by whichever solver finds it.

    Bars between supports that hold them lengthwise carry nothing that could be told; theirs is told as 0.
    """
    problem, solution = find(built.problem, built.scene.model.tolerance, built.scene.model.contact is not False)
    tension = np.where(problem.cannot_strain(solution.positions), 0.0, solution.bar_tension)
    solution = replace(solution, bar_tension=tension)
    return SceneResult(replace(built, problem=problem), solution, *loads_and_supports(problem, solution))


def end_tensions(tension: Floats) -> tuple[float, float]:
    """Tension at both ends of a rope from those of its bars, which are those of their middles, (bars,).

    Led straight on to the ends, which is of the second order in the length of the bars.
    """
    if len(tension) == 1:
        return float(tension[0]), float(tension[0])
    first, last = 1.5 * tension[0] - 0.5 * tension[1], 1.5 * tension[-1] - 0.5 * tension[-2]
    return float(max(first, 0.0)), float(max(last, 0.0))


def most_tension(tension: Floats) -> float:
    """Largest tension along a rope in motion, its ends included, from those of its bars, which are of their middles.

    Led on to the ends as far as two neighbouring bars agree on how it grows: waves do not grow thereby.
    """
    found = float(tension.max())
    if len(tension) > 2:
        for first, second, third in (tension[:3], tension[-1:-4:-1]):
            if first > second > third:
                found = max(found, float(first + 0.5 * min(first - second, second - third)))
    return found


def lies_in_zigzag(positions: Floats, tension: Floats) -> bool:
    """Whether a rope under tension turns to and fro from bar to bar, by ``TO_AND_FRO_DEG`` or more, at ``SEVERAL``.

    Such waves, two bars long, are of the reckoning and not of the rope: of time steps too long for its bars.

    Args:
        positions: of its nodes, (bars + 1, 3).
        tension: of its bars, (bars,); those without any may lie anyhow.
    """
    along = np.diff(positions, axis=0)
    length = np.linalg.norm(along, axis=1)
    turn = np.diff(along / np.where(length > 0.0, length, 1.0)[:, None], axis=0)
    back = -np.sum(turn[1:] * turn[:-1], axis=1) > np.radians(TO_AND_FRO_DEG) ** 2
    pulled = tension > 0.0
    return int(np.sum(back & pulled[2:] & pulled[1:-1] & pulled[:-2])) >= SEVERAL


def rope_rows(result: SceneResult) -> list[dict[str, Any]]:
    """A row for every rope, for ``ropes.csv``."""
    built, found = result.built, result.solution
    rows = []
    for rope, name, nodes, bars in zip(
        built.scene.rope, built.scene.rope_names, built.rope_nodes, built.rope_bars, strict=True
    ):
        tension, places = found.bar_tension[bars], found.positions[nodes]
        first, last = end_tensions(tension)
        rows.append(
            {
                "name": name,
                "from": rope.ends[0],
                "to": rope.ends[1],
                "length_m": rope.length_m,
                "length_under_load_m": float(np.linalg.norm(np.diff(places, axis=0), axis=1).sum()),
                "tension_from_n": first,
                "tension_to_n": last,
                "max_tension_n": float(max(first, last, tension.max())),
                "min_tension_n": float(min(first, last, tension.min())),
                "slack_share": float(np.mean(tension <= 0.0)),
                "deepest_m": float(0.0 - places[:, 2].min()),
                "law": rope.drag[0],
            }
        )
    return rows


def point_rows(result: SceneResult) -> list[dict[str, Any]]:
    """A row for every point, for ``points.csv``; forces are those of what holds it."""
    built, held = result.built, result.built.held
    rows = []
    for name, node in built.node_of.items():
        x, y, z = result.solution.positions[node]
        force = result.support[node] if name in held else np.full(3, np.nan)
        rows.append(
            {
                "name": name,
                "x_m": x,
                "y_m": y,
                "z_m": z,
                "held": name in held,
                "force_x_n": force[0],
                "force_y_n": force[1],
                "force_z_n": force[2],
                "force_n": float(np.linalg.norm(force)),
            }
        )
    return rows


def result_row(result: SceneResult) -> dict[str, Any]:
    """The row of ``results.csv``."""
    built, report = result.built, result.solution.report
    towed = result.support[built.towed].sum(axis=0) if built.towed.any() else np.full(3, np.nan)
    ropes = rope_rows(result)
    top = max(ropes, key=lambda row: row["max_tension_n"] if result.converged else 0.0, default={})
    return {
        "case": 1,
        "speed_m_s": built.scene.speed_m_s,
        "pull_n": float(np.linalg.norm(towed)),
        "pull_ahead_n": float(-towed[0]),
        "max_rope_tension_n": top["max_tension_n"] if ropes else np.nan,
        "max_tension_rope": top["name"] if ropes and result.converged else "",
        "deepest_m": float(0.0 - result.solution.positions[:, 2].min()),
        "highest_m": float(result.solution.positions[:, 2].max()),
        "volume_m3": volume_m3(built, result.solution.positions),
        "contact_share": contact_share(built, result.solution.positions),
        "unlike_sides_m": result.unlike_sides_m,
        "method": report.method,
        "iterations": report.iterations,
        "residual": report.residual,
        "stable": result.stable,
        "balance_error": balance_error(result),
        "converged": result.converged,
        "solve_ms": report.solve_ms,
    }


def settled(built: BuiltScene, positions: Floats, bar_tension: Floats) -> SceneResult:
    """Equilibrium of a scene from where its motion has come to, (n, 3) and (m,), by Newton's method with a barrier.

    Of netting that would pass through itself there: by gentle steps under contact, else as ``solve_scene`` finds it.
    """
    start = Solution(positions, bar_tension, np.zeros(built.problem.bands), START)
    solve = interior_point.solve if built.problem.body is None else floating.solve
    solution = solve(built.problem, built.scene.model.tolerance, start)
    if built.scene.model.contact is not False and solution.report.outcome is Outcome.PASSED_THROUGH:
        under = None
        if built.problem.body is None:
            under = from_there(built.problem, built.scene.model.tolerance, start)
        if under is None:
            return solve_scene(built)
        return SceneResult(replace(built, problem=under[0]), under[1], *loads_and_supports(*under))
    return SceneResult(built, solution, *loads_and_supports(built.problem, solution))


def _unlike(result: SceneResult) -> list[str]:
    """What is to be told of a shape that is not mirrored, of a scene that is."""
    net, unlike = result.built.problem.net, result.unlike_sides_m
    if not unlike > UNLIKE * float(net.bar_length[~net.bar_is_rope].min(initial=np.inf)):
        return []
    said = f"The scene is its own mirror image, and this shape is not: its two sides differ by up to {unlike:.2g} m"
    return [f"{said}. Its mirror image is in balance as well."]


def balance_error(result: SceneResult) -> float:
    """What loads and supports leave over together, over the sum of the sizes of the supports' forces and the loads.

    A frame that floats is no support: its weight and what carries it are loads. Where nothing pulls, nothing is left.
    """
    problem = result.built.problem
    held = np.where(problem.net.fixed, result.support, 0.0)
    own, own_size = np.zeros(3), 0.0
    if (body := problem.body) is not None:
        held[body.nodes] = 0.0
        own, own_size = load(body, pose_of(body, result.solution.positions))[:3], 2.0 * body.weight_n
    sizes = np.linalg.norm(result.load, axis=1).sum() + np.linalg.norm(held, axis=1).sum() + own_size
    return float(np.linalg.norm((result.load + held).sum(axis=0) + own) / sizes) if sizes != 0.0 else 0.0


def _highest(result: SceneResult) -> float:
    """Height of what lies highest, but for a frame that floats, m."""
    body = result.built.problem.body
    heights = result.solution.positions[:, 2]
    return float((heights if body is None else np.delete(heights, body.nodes)).max(initial=-np.inf))


def _highest_point(built: BuiltScene) -> float:
    """Height of the highest point as it was placed, at least that of the surface, m."""
    return max([0.0, *(float(built.problem.net.positions[node, 2]) for node in built.node_of.values())])


def _stretched(result: SceneResult) -> list[str]:
    """What is to be told of ropes that stretch by more than ropes do."""
    rows = [(row["name"], row["length_under_load_m"] / row["length_m"] - 1.0) for row in rope_rows(result)]
    return [
        f"{name} is stretched by {100.0 * strain:.3g} %: look at its axial_stiffness_n, which is in N."
        for name, strain in rows
        if strain > STRETCHES
    ]


def cautions(result: SceneResult) -> list[str]:
    """What a reader must know before using the numbers."""
    found = []
    scene = result.built.scene
    if not result.converged:
        found.append(f"No equilibrium was found: {result.solution.report.outcome.value}")
    elif (highest := _highest(result)) > _highest_point(result.built) + 1e-6:
        found.append(
            f"Something lies {highest:.3g} m above the surface, of which the model knows nothing: it is in water there."
        )
    found += frame_cautions(result.built, result.solution.positions)
    if result.converged and not result.load.any():
        found.append(NOTHING_PULLS)
    if result.converged:
        found += _stretched(result)
    if result.converged:
        found += _unlike(result)
    if result.stable == "no":
        found.append(WOULD_LEAVE)
    if result.converged and contact_share(result.built, result.solution.positions) > 0.0:
        found.append(LIES_ON_NETTING)
    if "density_kg_m3" not in scene.water.model_fields_set:
        found.append(f"Sea water of {scene.water.density_kg_m3:g} kg/m3 is assumed: water.density_kg_m3 is not given.")
    laws = sorted({rope.drag[0] for rope in scene.rope})
    if laws:
        found.append(f"Drag of the ropes by {' and '.join(laws)}: depths differ by a fifth from one law to another.")
    return found + netting_caution(result.built)
