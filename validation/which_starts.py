"""What each start is worth: ``python -m validation.which_starts --nets {joined,single,small,full} [--plans 1000]``.

Solves random plans, many of them series of catches, and prints for every start how often it was tried, which is where
all before it had failed, how often it led to an equilibrium, and in what time. The figures in
``codend.equilibrium.starts`` are sums over all four.
"""

from collections import Counter, defaultdict
from typing import Any

import click
import numpy as np

from codend.equilibrium.bag_model import model_of
from codend.equilibrium.solve import solve
from codend.errors import InputError
from codend.plan.plan import Case, Plan, plan_from_dict
from codend.solvers import dynamic_relaxation
from codend.solvers.outcome import Solution

SEEDS = {"joined": 2, "single": 3, "small": 5, "full": 7}
MOST_KNOTS = 900
"""Of the model; larger nets are left out, for time."""


def random_plan(nets: str, number: int) -> Plan:
    """Sections of all kinds laced together (one of them, bent or not, if ``single``), with straps and series.

    Catches are given by meshes or volume; ``small`` ones, a plan each, by up to three meshes.
    """
    rng = np.random.default_rng([SEEDS[nets], number])
    count = 1 if nets == "single" else int(rng.choice([1, 2, 3], p=[0.3, 0.5, 0.2]))
    base = int(rng.choice([12, 20, 24, 30, 36, 40]))
    bar_mm = float(rng.uniform(20.0, 60.0))
    sections, half_perimeters_m = [], []
    for _ in range(count):
        section = _random_section(rng, nets, base, bar_mm)
        across_mm = section["bar_mm"] + (section["knot_mm"] if section["mesh"] == "t90" else 0.0)
        half_mesh = 0.5 if section["mesh"] == "square" else 1.0
        half_perimeters_m.append(half_mesh * across_mm * section["meshes_round"] / 1000.0)
        sections.append(section)
    meshes_long = sum(section["meshes_long"] for section in sections)
    tables: dict[str, object] = {
        "title": f"{nets} {number}",
        "tow": {"speed_m_s": float(rng.uniform(0.3, 2.0)), "water_density_kg_m3": 1026.0},
        "entry": {"radius_m": float(rng.uniform(0.15, 0.8)) * half_perimeters_m[0] / np.pi},
        "netting": sections,
        "drag": {"law": str(rng.choice(["le-bris-1999", "bessonneau-1997"]))},
        "model": {"fidelity": "full" if nets == "full" else "sector", "tolerance": 1e-8},
    }
    cases = 1 if nets == "small" else int(rng.choice([1, 4]))
    pressure = str(rng.choice(["sphere", "uniform"]))
    if nets == "small" or rng.random() < 0.6:
        most = 3.0 if nets == "small" else 0.85 * meshes_long
        sizes, kind = np.exp(rng.uniform(np.log(0.3), np.log(most), cases)), "filled_meshes"
    else:
        most = 0.42 * min(half_perimeters_m) ** 2 / np.pi * meshes_long * bar_mm / 1000.0
        sizes, kind = most * np.exp(rng.uniform(np.log(0.01), np.log(0.6), cases)), "volume_m3"
    tables |= {"catch": {kind: np.sort(sizes).tolist(), "pressure": pressure}}
    if rng.random() < 0.4:
        place = int(rng.integers(2, max(3, sections[-1]["meshes_long"] - 1)))
        length_m = float(rng.uniform(0.7, 1.3)) * half_perimeters_m[-1]
        tables |= {"strap": [{"meshes_from_codline": place, "length_m": length_m, "diameter_mm": 10.0}]}
    return plan_from_dict(tables)


def _random_section(rng: np.random.Generator, nets: str, base: int, bar_mm: float) -> dict[str, Any]:
    """A section of about as many meshes round as others, at counts that can be laced to theirs."""
    mesh = str(rng.choice(["diamond", "t90", "square"], p=[0.5, 0.25, 0.25]))
    bar_mm *= float(rng.uniform(0.7, 1.3))
    section = {
        "mesh": mesh,
        "meshes_round": int(base * rng.choice([0.5, 1.0, 1.5] if base % 2 == 0 else [1.0])),
        "meshes_long": 2 * int(rng.integers(4, 20)),
        "bar_mm": bar_mm,
        "knot_mm": 0.0 if mesh == "square" else float(rng.choice([0.0, 0.1])) * bar_mm,
        "twine_mm": float(rng.uniform(0.03, 0.1)) * bar_mm,
    }
    if rng.random() < 0.4:
        section["axial_stiffness_n"] = float(np.exp(rng.uniform(np.log(300.0), np.log(1e5))))
    if nets == "single" and mesh != "square" and rng.random() < 0.4:
        section["bending_stiffness_n_m2"] = float(np.exp(rng.uniform(np.log(1e-6), np.log(1e-3))))
        section["rest_opening_deg"] = float(rng.uniform(10.0, 40.0))
    return section


def solved(plan: Plan) -> list[Solution]:
    """The cases of a plan in turn, each with those before it known; none of a net that is too large to try many."""
    model = model_of(plan, 1, None if plan.model.fidelity == "full" else 1)
    if len(model.bag.net.positions) > MOST_KNOTS:
        return []
    known: list[tuple[Case, Solution]] = []
    found = []
    for case in plan.cases():
        found.append(solve(model, case, known, None)[1])
        if found[-1].report.outcome.converged:
            known.append((case, found[-1]))
    return found


@click.command()
@click.option("--nets", type=click.Choice(list(SEEDS)), default="joined", show_default=True)
@click.option("--plans", default=1000, show_default=True)
def main(nets: str, plans: int) -> None:
    """Solve random plans and tell which start led where those before it had failed."""
    tried: Counter[str] = Counter()
    solve_ms: dict[str, list[float]] = defaultdict(list)
    solves = refused = 0
    for number in range(plans):
        try:
            solutions = solved(random_plan(nets, number))
        except InputError:
            refused += 1
            continue
        for report in (solution.report for solution in solutions):
            solves += 1
            starts = list(dict.fromkeys(line.split(": ")[0] for line in report.attempts[:-1]))
            last = report.attempts[-1].split(": ")[0]
            if report.method == dynamic_relaxation.METHOD:
                last += ", relaxed to the end"
            starts = [*(start for start in starts if start != last), last]
            tried.update(starts)
            if report.outcome.balanced:
                solve_ms[last].append(report.solve_ms)
    print(f"{nets}: {plans} plans, {refused} refused, {solves} solves")
    for start, count in tried.items():
        median = f"median {np.median(solve_ms[start]):.1f} ms" if solve_ms[start] else ""
        print(f"{start:45} led to {len(solve_ms[start]):4} of {count:4}  {median}", flush=True)


if __name__ == "__main__":
    main()
