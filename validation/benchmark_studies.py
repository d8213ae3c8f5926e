"""How fast studies are solved: cases a second with one and two workers, and what they take of time and memory.

Run as ``python -m validation.benchmark_studies [--cases 10000]``. T0 and T90 codends 40 to 140 meshes long, drawn over
mesh size, meshes round, twine, speed and catch (Sobol), under the sphere law, all columns but selectivity: once in
series of forty catches a design, and once every case a design of its own. Wall time counts for the goals; processor
time is printed beside it, for machines that have other work.
"""

import os
import resource
from dataclasses import dataclass
from multiprocessing import active_children
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import Any

import click
import numpy as np

import codend

CATCHES = 40
GOALS = {"series of catches": 1000.0, "designs of their own": 400.0}
"""Cases a second over two cores."""


def study_of(cases: int, catches: int) -> dict[str, Any]:
    """The study with so many cases, so many of them catches of one design."""
    filled = np.linspace(10.0, 34.5, catches).tolist() if catches > 1 else [30.0]
    designs = []
    for mesh, knot_mm in (("diamond", 0.0), ("t90", 4.0)):
        for meshes_long in (40, 60, 90, 140):
            netting = {"mesh": mesh, "meshes_round": 100, "meshes_long": meshes_long, "bar_mm": 40.0}
            plan = {
                "title": f"{mesh} {meshes_long}",
                "tow": {"speed_m_s": 1.5, "water_density_kg_m3": 1026.0},
                "entry": {"radius_m": 0.4},
                "netting": [{**netting, "knot_mm": knot_mm, "twine_mm": 4.0}],
                "catch": {"filled_meshes": filled, "pressure": "sphere"},
            }
            designs.append({"name": str(plan["title"]), "plan": plan})
    vary: dict[str, Any] = {
        "sample": "sobol",
        "size": cases // catches // len(designs),
        "netting.0.bar_mm": {"from": 35.0, "to": 60.0},
        "netting.0.meshes_round": {"from": 60, "to": 140},
        "netting.0.twine_mm": {"from": 2.0, "to": 5.0},
        "tow.speed_m_s": {"from": 1.0, "to": 2.0},
    }
    if catches == 1:
        vary["catch.filled_meshes"] = {"from": 10.0, "to": 35.0}
    return {"title": "benchmark", "design": designs, "vary": vary}


@dataclass(frozen=True)
class Measured:
    """What a study took."""

    cases: int
    converged: int
    wall_s: float
    processor_s: float
    """Of all processes."""
    solver_s: float
    memory_mb: list[float]
    """Of all processes, as parts were done."""


def measured(study: dict[str, Any], workers: int) -> Measured:
    """Solve a study."""
    memory_mb = []

    def watch(*_: object) -> None:
        memory_mb.append(sum(map(_resident_mb, [os.getpid(), *(child.pid or 0 for child in active_children())])))

    with TemporaryDirectory() as folder:
        started, before_s = perf_counter(), _processor_s()
        table = codend.sweep(study, folder, workers=workers, progress=watch)
        wall_s, processor_s = perf_counter() - started, _processor_s() - before_s
    solver_s = 1e-3 * float(table["solve_ms"].sum())
    return Measured(len(table), int(table["converged"].sum()), wall_s, processor_s, solver_s, memory_mb)


def _processor_s() -> float:
    spent = [resource.getrusage(whose) for whose in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(usage.ru_utime + usage.ru_stime for usage in spent)


def _resident_mb(process: int) -> float:
    """Memory of a process, 0 of one that is gone."""
    try:
        pages = int(Path(f"/proc/{process}/statm").read_text(encoding="ascii").split()[1])
    except OSError:
        return 0.0
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


@click.command()
@click.option("--cases", default=10_000, show_default=True, help="Of every study.")
@click.option("--workers", default=2, show_default=True, help="As against one.")
def main(cases: int, workers: int) -> None:
    """Print the table."""
    codend.sweep(study_of(8 * CATCHES, CATCHES))  # kernels compiled or read
    head = ("cases", "solved", "cases/s", "of processor", "in solver", "memory MB")
    print(f"{'':22}{'workers':>8}" + "".join(f"{name:>14}" for name in head))
    for name, catches in (("series of catches", CATCHES), ("designs of their own", 1)):
        study = study_of(cases, catches)
        speeds = []
        for count in (1, workers):
            found = measured(study, count)
            speeds.append(found.cases / found.wall_s)
            # after the first tenth all room to work in is taken
            start, end = found.memory_mb[len(found.memory_mb) // 10], found.memory_mb[-1]
            print(
                f"{name:22}{count:8}{found.cases:14}{found.converged:14}{speeds[-1]:14.0f}"
                f"{found.cases / found.processor_s:14.0f}{found.solver_s / found.processor_s:14.0%}"
                f"{f'{start:.0f} to {end:.0f}':>14}"
            )
        print(
            f"{'':22}{workers} workers over one: {speeds[1] / speeds[0]:.2f}; goal {GOALS[name]:.0f} cases/s over two"
        )


if __name__ == "__main__":
    main()
