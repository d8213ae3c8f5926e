"""The trawl in equilibrium, found at once and come to by its motion: the same opening, pulls and depths.

``python -m validation.trawl.towed`` lays the half gear about as it is towed (``gear.SPREAD``), finds its equilibrium as
``codend scene`` does, follows its motion under contact from its equilibrium at ``FIRST`` knots for ``--end`` seconds,
and prints both: opening, pull, depth of the weights, tension of every rope. Without contact wings and sides fold
through each other along their seams. The end of the motion, whose speeds were 0.0002 m/s, is brought to its balance
by gentle steps: of 1540 bars both agree within 0.001 % in every number. 600 s took 142 s of processor time.
"""

import argparse
from time import process_time

import numpy as np

from codend.scenes.build import build
from codend.scenes.follow import follow
from codend.scenes.measures import result_row, rope_rows, settled, solve_scene
from codend.scenes.scene import scene_from_dict
from validation.trawl.gear import KNOT_M_S, SPEED_M_S, half_trawl

FIRST = 3.2
"""Knots at which the motion begins in equilibrium."""


def equilibrium(merged: int = 24, speed_m_s: float = SPEED_M_S):  # type: ignore[no-untyped-def]
    """The half gear's equilibrium, from about where it comes to rest."""
    return solve_scene(build(scene_from_dict(half_trawl(merged, speed_m_s=speed_m_s, spread=True))))


def told(result) -> dict[str, float]:  # type: ignore[no-untyped-def]
    """What is compared."""
    node, places = result.built.node_of, result.solution.positions
    row = result_row(result)
    found = {"opening_m": places[node["upper centre"], 2] - places[node["lower centre"], 2]}
    found |= {"pull_n": row["pull_n"], "pull_ahead_n": row["pull_ahead_n"]}
    found |= {"weight_depth_m": -places[node["lower wing end"], 2], "doors_apart_m": 2.0 * places[node["door"], 1]}
    return found | {f"{rope['name']}, N": rope["tension_from_n"] for rope in rope_rows(result)}


def main() -> None:
    """Print both."""
    asked = argparse.ArgumentParser(description=__doc__)
    asked.add_argument("--merged", type=int, default=24)
    asked.add_argument("--end", type=float, default=600.0)
    asked.add_argument("--step", type=float, default=0.025)
    given = asked.parse_args()
    began = process_time()
    result = equilibrium(given.merged)
    print(f"{len(result.built.problem.net.bars)} bars, converged {result.converged}, {process_time() - began:.1f} s")
    for attempt in result.solution.report.attempts:
        print(f"  {attempt}")
    time = {"end_s": given.end, "output_s": min(10.0, given.end), "step_s": given.step}
    built = build(scene_from_dict(half_trawl(given.merged, spread=True, time=time, model={"contact": True})))
    start = equilibrium(given.merged, FIRST * KNOT_M_S).solution.positions
    began = process_time()
    *_, frame = follow(built, start)
    spent = process_time() - began
    print(f"{given.end:g} s of motion under contact in {spent:.0f} s, {given.end / spent:.1f} times the sea's pace; "
          f"netting through itself at {frame.passages[0]:.0f} outputs")  # fmt: skip
    speed = float(np.sqrt(np.mean(np.sum(frame.velocities**2, axis=1))))
    print(f"root mean square of its speeds then {speed:.2g} m/s")
    come_to = settled(built, frame.positions, frame.bar_tension)
    one, other = told(result), told(come_to)
    for name, value in one.items():
        print(
            f"{name:28} at once {value:10.3f}, by motion {other[name]:10.3f}: {100 * (other[name] / value - 1):+.3f} %"
        )


if __name__ == "__main__":
    main()
