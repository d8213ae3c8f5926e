"""Contact: where it finds its answers, and what it costs: a section of the validation report.

``python -m validation --only contact``. Two maps, each cell judged by what shares no code with the solvers: a chain
laid on a floor by the closed form of jointed bars, cages in a current by ``ipctk`` and by their balance. Then what
contact costs beside the same nets without it, and how its answers and time depend on the distance at which it begins.
"""

from collections.abc import Callable
from time import process_time
from typing import Any
from unittest.mock import patch

import numpy as np
import pandas as pd

from codend.equilibrium import folds
from codend.mechanics.contact import add_force
from codend.mechanics.problem import Problem
from codend.mechanics.surface import ContactLaw
from codend.net.net import Net
from codend.report.style import BLUE, INK, ORANGE, dress, new_figure
from codend.scenes.build import build
from codend.scenes.measures import balance_error, result_row, solve_scene
from codend.scenes.scene import scene_from_dict
from codend.solvers import gentle, interior_point
from codend.solvers.outcome import Outcome, Solution
from codend.studies.study import solve
from validation.cage.gear import box
from validation.cage.random_cages import crosses_itself
from validation.report import markdown_table
from validation.section import Picture, Section, Verdict
from validation.stability.drawing import counts_text, picture_of
from validation.stability.judge import Finding, Judgement
from validation.stability.maps import Axis, StabilityMap, cell_table, panel, spaced
from validation.wrinkles.matrix import commercial

LENGTH_M, WEIGHT_N_M, PULL_N = 10.0, 20.0, 30.0
"""Of the chain."""
ROUND_OFF = 1e-6
BALANCED = 1e-8
DISTANCES = 2.0, 1.0, 0.5, 0.25
"""Over the distance at which contact begins."""


def chain_on_a_floor(bars: int, z0: float, gap: float, push_n: float | None = None) -> Problem:
    """A chain that hangs from ``z0`` above a floor and is pulled along it at its end.

    At half of the ``gap`` at which contact begins a floor pushes with ``push_n``, 3.6 times what a bar weighs if left
    out.
    """
    length = LENGTH_M / bars
    along = np.arange(bars + 1) * length
    slope = np.hypot(z0, 5.0)
    down = np.minimum(along / slope, 1.0)
    chain = np.stack([5.0 * down + np.maximum(along - slope, 0.0), 0 * along, z0 * (1.0 - down) + 2.0 * gap], axis=1)
    chain[0, 2] = z0
    floor = np.array([[-30.0, -9.0, 0.0], [60.0, -9.0, 0.0], [10.0, 40.0, 0.0]])
    nodes = np.concatenate([chain, floor])
    held = np.zeros((len(nodes), 3), dtype=bool)
    held[0] = held[-3:] = held[:, 1] = True
    ends = np.stack([np.arange(bars), np.arange(1, bars + 1)], axis=1)
    facets = [[bars + 1, bars + 2, bars + 3]]
    net = Net.from_bars(nodes, ends, held, length_m=length, diameter_m=0.01, density_kg_m3=27000.0, facets=facets)
    force = np.zeros_like(nodes)
    force[: bars + 1, 2] = -WEIGHT_N_M * length
    force[[0, bars], 2] *= 0.5
    force[bars, 0] = PULL_N
    law = ContactLaw.pressing(gap, 3.6 * WEIGHT_N_M * length if push_n is None else push_n)
    return Problem.of(net, nodal_force_n=force, weight=False, contact=law)


def carried_n(bars: int, z: float) -> float:
    """What the upper end of jointed bars carries of their weight that hangs so high above a floor, N.

    Bar by bar from the floor up, V grows by the weight of a bar and its height is l V / (H^2 + V^2)^1/2; of the first,
    V is what is missing to z. Half a bar's weight acts at the upper end itself.
    """
    weight, length = WEIGHT_N_M * LENGTH_M / bars, LENGTH_M / bars

    def height(least: float, count: int) -> float:
        pull = least + weight * np.arange(count)
        return float((length * pull / np.hypot(PULL_N, pull)).sum())

    count = 1
    while height(weight, count) < z:
        count += 1
    low, high = 0.0, weight
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if height(middle, count) < z else (low, middle)
    return low + weight * (count - 1) + 0.5 * weight


def on_a_floor(bars: int, z0: float, gap: float, push_n: float, by: Callable[..., Solution]) -> Any:
    """The solution, and what it came to by the closed form: the floor holds up the chain at some share of the gap."""
    problem = chain_on_a_floor(bars, z0, gap, push_n)
    found = by(problem, 1e-9)
    if not found.report.outcome.converged:
        return found, Judgement(Finding.FAILED, np.nan, np.nan, found.report.residual, "")
    push = np.zeros_like(found.positions)
    add_force(found.positions, problem.touching_at(found.positions).loading.contact, push)
    carried = WEIGHT_N_M * LENGTH_M - float(push[: bars + 1, 2].sum())
    least, most = carried_n(bars, z0 - gap), carried_n(bars, z0)
    off = max(least - carried, carried - most, 0.0) / most
    faults = [
        name
        for name, there in (
            ("below the floor", found.positions[1 : bars + 1, 2].min() <= 0.0),
            ("pulled by the floor", push[: bars + 1, 2].min() < 0.0),
            ("not what the closed form carries", off > ROUND_OFF),
        )
        if there
    ]
    finding = Finding.WRONG if faults else Finding.RIGHT
    error = abs(carried / most - 1.0)
    explained = error / (1.0 - least / most + ROUND_OFF)
    return found, Judgement(finding, error, explained, found.report.residual, ", ".join(faults))


def floor_map(quick: bool) -> StabilityMap:
    """Where contact begins against how hard it presses, by the two solvers that start afar."""
    bars, z0 = 50, 2.0
    length, weight = LENGTH_M / bars, WEIGHT_N_M * LENGTH_M / bars
    distances = spaced(1e-5, 0.3, 3 if quick else 8)
    gaps = Axis("distance at which contact begins / bar", distances, tuple(f"{one:.1g}" for one in distances))
    pushes = Axis("push at half of it / weight of a bar", spaced(0.1, 100.0, 2 if quick else 7))
    panels = tuple(
        panel(name, gaps, pushes, lambda x, y, by=by: on_a_floor(bars, z0, x * length, y * weight, by))
        for name, by in (("interior point", interior_point.solve), ("gentle steps", gentle.solve))
    )
    return StabilityMap(
        "contact_floor",
        "Contact: where it begins against how hard it presses",
        f"A chain of {bars} bars that hangs to a floor and is pulled along it, by the closed form of jointed bars held "
        "up at some share of the gap.",
        panels,
    )


def _in_current(data: dict[str, Any]) -> tuple[Solution, Judgement]:
    result = solve_scene(build(scene_from_dict(data)))
    solution = result.solution
    report = solution.report
    if not result.converged:
        return solution, Judgement(Finding.FAILED, np.nan, np.nan, report.residual, "")
    off = balance_error(result)
    faults = [
        name
        for name, there in (
            ("passes through itself, by ipctk", crosses_itself(result.built, solution.positions)),
            ("loads and supports do not balance", not off <= BALANCED),
            ("twine that pushes", solution.bar_tension.min() < 0.0),
        )
        if there
    ]
    failed = [outcome.value for outcome in Outcome if not outcome.converged]
    rescued = any(sentence in line for line in report.attempts[:-1] for sentence in failed)
    finding = Finding.WRONG if faults else Finding.RESCUED if rescued else Finding.RIGHT
    return solution, Judgement(finding, off, off / BALANCED, report.residual, ", ".join(faults))


def cage_map(quick: bool) -> StabilityMap:
    """Current against ballast."""
    speeds = (0.0, 0.5, 1.2) if quick else (0.0, 0.05, 0.1, 0.2, 0.3, 0.5, 0.8, 1.2, 2.0)
    currents = Axis("current, m/s", speeds, tuple(f"{speed:g}" for speed in speeds))
    kg = (6.0,) if quick else (0.5, 2.0, 6.0, 12.0, 40.0, 200.0)
    ballasts = Axis("ballast, kg", kg, tuple(f"{one:g}" for one in kg))
    panels = tuple(
        panel(
            name,
            currents,
            ballasts,
            lambda x, y, density=density: _in_current(box(x, merged=10, ballast_kg=y, twine_density_kg_m3=density)),
        )
        for name, density in (("twine lighter than water", 950.0), ("twine heavier than water", 1140.0))
    )
    return StabilityMap(
        "contact_cages",
        "Contact: cages in a current against their ballast",
        "The cage of the papers in netting of 320 bars, by ipctk and by the balance of loads and supports to 1e-8.",
        panels,
    )


def _timed(call: Callable[[], Any]) -> tuple[Any, float]:
    began = process_time()
    found = call()
    return found, process_time() - began


def cost_rows(quick: bool) -> list[dict[str, object]]:
    """What contact costs: the same nets with and without it."""
    rows: list[dict[str, object]] = []
    for merged in (10,) if quick else (8, 5, 4):
        for contact in (False, True):
            built = build(scene_from_dict(box(0.5, merged=merged) | {"model": {"contact": contact}}))
            result, seconds = _timed(lambda built=built: solve_scene(built))
            row = result_row(result) if result.converged else {}
            rows.append(
                {"net": f"cage of {len(built.problem.net.bars)} bars at 0.5 m/s", "contact": "yes" if contact else "no",
                 "seconds": seconds, "found": result.solution.report.outcome.name.lower().replace("_", " "),
                 "volume_m3": row.get("volume_m3", np.nan)}
            )  # fmt: skip
    for meshes, kg in ((50, 50.0),) if quick else ((50, 300.0), (100, 300.0)):
        for name, model in (
            ("no", {"wrinkles": False}),
            ("no, followed", {"wrinkles": True, "contact": False}),
            ("yes", {"wrinkles": True}),
        ):
            study, seconds = _timed(lambda model=model, n=meshes, kg=kg: solve(commercial("t90", n, 0.0, kg, **model)))
            case = study.cases[0]
            rows.append(
                {"net": f"T90 codend, {meshes} round, {kg:g} kg", "contact": name, "seconds": seconds,
                 "found": "converged" if case.converged else "not converged", "drag_n": case.measures.drag_n,
                 "drag_error_n": case.errors.drag_error_n, "opening_deg": case.measures.opening_ahead_deg}
            )  # fmt: skip
    return rows


def distance_rows(quick: bool) -> list[dict[str, object]]:
    """A T90 codend in folds, by the distance at which contact begins: time, and what drag and opening depend on it."""
    rows = []
    for share in DISTANCES[1:3] if quick else DISTANCES:
        law = {"BEGINS_M": share * folds.BEGINS_M, "OF_A_BAR": share * folds.OF_A_BAR}
        with patch.multiple(folds, **law):
            study, seconds = _timed(lambda: solve(commercial("t90", 50, 0.0, 50.0, wrinkles=True)))
        case = study.cases[0]
        rows.append(
            {"distance_mm": 1e3 * law["BEGINS_M"], "seconds": seconds, "drag_n": case.measures.drag_n,
             "drag_error_n": case.errors.drag_error_n, "opening_deg": case.measures.opening_ahead_deg,
             "opening_error_deg": case.errors.opening_ahead_error_deg, "stable": case.stability.stable}
        )  # fmt: skip
    finest = rows[-1]
    for row in rows:
        row["drag_off"] = abs(row["drag_n"] / finest["drag_n"] - 1.0)
        row["opening_off_deg"] = abs(row["opening_deg"] - finest["opening_deg"])
    return rows


def section(quick: bool) -> Section:
    """Maps, what contact costs, and time against accuracy."""
    solve_scene(build(scene_from_dict(box(0.3, merged=10))))  # compiles
    solve(commercial("t90", 50, 0.0, 50.0, wrinkles=True))
    maps = floor_map(quick), cage_map(quick)
    costs, distances = pd.DataFrame(cost_rows(quick)), pd.DataFrame(distance_rows(quick))
    verdicts = [Verdict(f"{m.title}: no cell is wrong", not m.count(Finding.WRONG), counts_text(m)) for m in maps]
    within = (
        distances["drag_off"] * distances["drag_n"] <= distances["drag_error_n"] + distances["drag_error_n"].iloc[-1]
    )
    verdicts.append(
        Verdict(
            "Drag in folds by the distance at which contact begins differs by no more than the errors that are told",
            bool(within.all()),
            f"largest {100.0 * distances['drag_off'].max():.2g} % in drag, "
            f"{distances['opening_off_deg'].max():.2g} degrees in opening, by distances of "
            f"{distances['distance_mm'].max():g} to {distances['distance_mm'].min():g} mm",
        )
    )
    text = "\n\n".join(
        [
            "Every cell of the maps is one solve, judged by what shares no code with it. What contact costs stands "
            "beside the same nets without it: a cage that would pass through itself is refused there, and a codend in "
            "folds keeps its symmetric shape, with an error that covers the folds. Seconds are of processor time; of a "
            "codend they hold the symmetric answer, its stability and all starts.",
            _markdown(costs),
            "A T90 codend in folds (50 round, 50 kg) by the distance at which contact begins: time against what "
            "depends on it.",
            _markdown(distances),
        ]
    )
    pictures = (*(picture_of(m) for m in maps), _chart(costs, distances))
    data = {m.name: cell_table(m) for m in maps} | {"contact_costs": costs, "contact_distances": distances}
    return Section("Contact", text, pictures, data, tuple(verdicts))


def _markdown(table: pd.DataFrame) -> str:
    rows = [
        tuple("" if pd.isna(v) else f"{v:.4g}" if isinstance(v, float) else str(v) for v in row)
        for row in table.to_numpy()
    ]
    return markdown_table(tuple(table.columns), rows)


def _chart(costs: pd.DataFrame, distances: pd.DataFrame) -> Picture:
    figure = new_figure(9.0, 3.8)
    left, right = figure.subplots(1, 2)
    nets = list(dict.fromkeys(costs["net"]))
    for kind, colour, marker in (("no", INK, "o"), ("no, followed", BLUE, "s"), ("yes", ORANGE, "D")):
        rows = costs[costs["contact"] == kind]
        left.plot(rows["seconds"], [nets.index(net) for net in rows["net"]], marker, color=colour,
                  label={"no": "without contact", "yes": "with contact"}.get(kind, "followed without"))  # fmt: skip
    left.set_yticks(range(len(nets)), nets)
    left.set_xscale("log")
    left.set_xlabel("processor time (s)")
    left.legend(frameon=False)
    off = distances.iloc[:-1]
    right.plot(off["seconds"], 100.0 * off["drag_off"], "D", color=ORANGE)
    for row in off.itertuples():
        right.annotate(
            f"{row.distance_mm:g} mm", (row.seconds, 100.0 * row.drag_off), (5, 5), textcoords="offset points"
        )
    right.set_xlabel("processor time (s)")
    right.set_ylabel("drag off that of the smallest distance (%)")
    right.set_ylim(bottom=0.0)
    for axes in (left, right):
        dress(axes)
    return Picture(
        "contact_costs",
        figure,
        "What contact costs, and a T90 codend in folds by the distance at which contact begins.",
    )
