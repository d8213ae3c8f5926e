"""Residual volume of the papers' cage against the current, its drag and what holds its frame, and its shapes.

``python -m validation.cage --out DIR`` solves the cage of ``gear`` for currents of 0 to 1 m/s under several ballasts
(figure 18 of Le Bris et al. 1999), once more in finer netting, and once more with a current that rises by steps from
one speed to the next; prints the tables and draws figure 18 and the shapes of figures 14 and 15. ``--random N`` solves
random cages in their place and has every answer judged by ``ipctk``; ``--covered N`` holds their errors to shapes found
on other ways. Both exit with 1 if an answer is wrong.
"""

import argparse
import sys
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
import pandas as pd

from codend.report.style import png
from codend.scenes.build import build
from codend.scenes.equilibrium import NEARBY, contact_law
from codend.scenes.frame_measures import frame_rows
from codend.scenes.measures import SceneResult, result_row, solve_scene
from codend.scenes.netting_measures import netting_rows, volume_m3
from codend.scenes.scene import scene_from_dict
from codend.solvers import interior_point
from codend.solvers.outcome import Solution
from validation.cage.covered import rows_of
from validation.cage.drawing import shapes_figure, volume_figure
from validation.cage.gear import BALLAST_KG, box
from validation.cage.random_cages import judged

SPEEDS_M_S = tuple(round(0.1 * k, 1) for k in range(11))
BALLASTS_KG = (6.0, BALLAST_KG, 24.0)
COARSE, FINE, OF_2000_BARS = 8, 5, 4


def solved(data: dict[str, Any]) -> tuple[SceneResult, dict[str, Any]]:
    """A cage in balance, and what is told of it."""
    built, began = build(scene_from_dict(data)), process_time()
    result = solve_scene(built)
    spent = process_time() - began
    if not result.converged:
        raise ArithmeticError("; ".join(result.solution.report.attempts))
    row = result_row(result)
    places, tension = result.solution.positions, result.solution.bar_tension
    frame = frame_rows(built, places, result.support)[0]
    told = {
        "speed_m_s": float(np.linalg.norm(data["water"]["flow_m_s"])),
        "bars": len(built.problem.net.bars),
        "volume_m3": row["volume_m3"],
        "drag_n": sum(one["drag_n"] for one in netting_rows(built, places, tension)),
        "frame_pull_x_n": frame["pull_x_n"],
        "frame_pull_z_n": frame["pull_z_n"],
        "contact_share": row["contact_share"],
        "unlike_sides_m": row["unlike_sides_m"],
        "residual": row["residual"],
        "processor_s": spent,
    }
    return result, told


def against_current(ballast_kg: float, merged: int) -> tuple[pd.DataFrame, list[SceneResult]]:
    """A row a speed, and the cages."""
    found = [solved(box(speed, merged=merged, ballast_kg=ballast_kg)) for speed in SPEEDS_M_S]
    table = pd.DataFrame([told for _, told in found])
    table.insert(1, "volume_share", table["volume_m3"] / table["volume_m3"][0])
    return table, [result for result, _ in found]


def by_steps(first: SceneResult, ballast_kg: float, merged: int) -> list[float]:
    """Volumes where every speed starts from the equilibrium of the one before, m3; nan where none is found."""
    start, volumes = first.solution, [volume_m3(first.built, first.solution.positions)]
    law = contact_law(first.built.problem, start.mean_tension)
    for speed in SPEEDS_M_S[1:]:
        built = build(scene_from_dict(box(speed, merged=merged, ballast_kg=ballast_kg)))
        problem = built.problem.touching_by(law).touching_at(start.positions)
        found: Solution = interior_point.solve(problem, built.scene.model.tolerance, start, NEARBY)
        good = found.report.outcome.converged
        volumes.append(volume_m3(built, found.positions) if good else np.nan)
        start = found if good else start
    return volumes


def main() -> None:
    """Print the tables and draw the figures."""
    asked = argparse.ArgumentParser(description=__doc__)
    asked.add_argument("--out", type=Path, default=Path("cage"))
    asked.add_argument("--random", type=int, default=0)
    asked.add_argument("--covered", type=int, default=0)
    asked.add_argument("--seed", type=int, default=0)
    given = asked.parse_args()
    if given.random:
        said, right = judged(given.random, given.seed)
        print(said)
        sys.exit(0 if right else 1)
    if given.covered:
        table = pd.DataFrame(rows_of(given.covered, given.seed))
        print(table.to_string(index=False, float_format="%.4g"))
        sys.exit(0 if table["over_stated"].max() <= 1.0 else 1)
    given.out.mkdir(parents=True, exist_ok=True)
    solved(box(0.3, merged=10))  # compiles
    tables, cages = {}, {}
    for ballast in BALLASTS_KG:
        tables[ballast], cages[ballast] = against_current(ballast, COARSE)
        if ballast == BALLAST_KG:
            tables[ballast]["by_steps_m3"] = by_steps(cages[ballast][0], ballast, COARSE)
        print(f"\nballast of {ballast:g} kg at the corners; {tables[ballast]['processor_s'].sum():.1f} s of processor "
              f"time for all speeds\n{tables[ballast].to_string(index=False, float_format='%.4g')}")  # fmt: skip
    fine, _ = against_current(BALLAST_KG, FINE)
    off = tables[BALLAST_KG]["volume_m3"] / fine["volume_m3"] - 1.0
    print(f"\nthe same in finer netting: {fine['bars'][0]} bars, {fine['processor_s'].sum():.1f} s\n"
          f"{fine.to_string(index=False, float_format='%.4g')}\nvolume of the coarse over that of the fine, less 1: "
          f"{', '.join(f'{100.0 * x:+.1f} %' for x in off)}")  # fmt: skip
    for speed in SPEEDS_M_S:
        _, told = solved(box(speed, merged=OF_2000_BARS))
        print(f"{told['bars']} bars at {speed:g} m/s: {told['processor_s']:.2f} s of processor time, "
              f"residual {told['residual']:.1e}")  # fmt: skip
    pd.concat({kg: table for kg, table in tables.items()}, names=["ballast_kg"]).to_csv(given.out / "cage.csv")
    (given.out / "figure_18.png").write_bytes(png(volume_figure(tables, fine)))
    shown = [cages[BALLAST_KG][k] for k in (0, 5, 10)]
    (given.out / "figures_14_15.png").write_bytes(png(shapes_figure(shown)))


if __name__ == "__main__":
    main()
