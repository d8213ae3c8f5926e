"""The section of the validation report on stability: all maps, their verdicts, the worst of their cells in words."""

from collections.abc import Iterable

from codend.report.style import number_text
from validation.section import Section, Verdict
from validation.stability.automatic_maps import automatic_maps
from validation.stability.drawing import counts_text, picture_of
from validation.stability.judge import SAFETY, Finding
from validation.stability.maps import Cell, StabilityMap, cell_table
from validation.stability.newton_map import newton_map
from validation.stability.perturbation_map import perturbation_map
from validation.stability.relaxation_map import relaxation_map
from validation.stability.rigid_bars_map import rigid_bars_map

INTRODUCTION = """
Each map is a grid over the two numbers that decide whether a method finds its answer. Every cell is one solve, held to
the equations in plain numpy (`validation/reference.py`, which shares no code with the kernels) and to a reference found
by two methods. A state may be off by what its own residual and length errors explain to first order (the sums of the
moduli of the inverse tangent's rows, times {safety:g}), and no more. What a cell can come to:

{findings}

How far off a right answer is: "of what is explained" tells the error in drag, volume or shape, whichever is worst, over
the largest that the state's own residual allows.
""".strip()


COLUMNS = {
    Finding.RIGHT: "right at once",
    Finding.RESCUED: "after a fall-back",
    Finding.ANOTHER: "another equilibrium",
    Finding.UNSTABLE: "told unstable",
    Finding.FAILED: "honest failure",
    Finding.WRONG: "wrong",
}
"""Head of the column of every finding."""


def section(quick: bool) -> Section:
    """All maps; ``quick`` asks for coarse grids."""
    maps = (
        relaxation_map(quick),
        rigid_bars_map(quick),
        newton_map(quick),
        *automatic_maps(quick),
        perturbation_map(quick),
    )
    return section_of(maps)


def section_of(maps: Iterable[StabilityMap]) -> Section:
    """Section of the report from solved maps."""
    maps = tuple(maps)
    verdicts = [verdict for m in maps for verdict in (_no_wrong_answer(m), *m.checks)]
    return Section(
        title="Stability",
        text="\n\n".join([_introduction(), _table(maps), _worst(maps)]),
        pictures=tuple(picture_of(m) for m in maps),
        data={m.name: cell_table(m) for m in maps},
        verdicts=tuple(verdicts),
    )


def _introduction() -> str:
    findings = "\n".join(f"- {finding.value}" for finding in Finding)
    return INTRODUCTION.format(safety=SAFETY, findings=findings)


def _no_wrong_answer(m: StabilityMap) -> Verdict:
    claim = f"{m.title}: no cell says that it converged and is wrong."
    return Verdict(claim, not m.count(Finding.WRONG), counts_text(m))


def _table(maps: tuple[StabilityMap, ...]) -> str:
    heads = ("map", "cells", *(COLUMNS[finding] for finding in Finding))
    lines = ["| " + " | ".join(heads) + " |", "| --- |" + " ---: |" * (len(heads) - 1)]
    for m in maps:
        counts = " | ".join(str(m.count(finding)) for finding in Finding)
        lines.append(f"| {m.title} | {len(m.cells)} | {counts} |")
    return "\n".join(lines)


def _worst(maps: tuple[StabilityMap, ...]) -> str:
    """Of every map the cells that a sceptic would look at, with what the tool says there."""
    parts = ["The worst cells, and what the tool says there:"]
    for m in maps:
        answered = [cell for cell in m.cells if cell.judgement.finding in (Finding.RIGHT, Finding.RESCUED)]
        chosen = [_told(m, cell, "wrong") for cell in m.cells if cell.judgement.finding is Finding.WRONG]
        if answered:
            off = max(answered, key=lambda cell: cell.judgement.explained)
            share = number_text(off.judgement.explained, 2)
            chosen.append(_told(m, off, f"farthest off, {share} of what is explained"))
        slow = max(m.cells, key=lambda cell: cell.solve_ms)
        chosen.append(_told(m, slow, f"slowest, {number_text(slow.solve_ms, 2)} ms"))
        failures = [cell for cell in m.cells if cell.judgement.finding is Finding.FAILED]
        if failures:
            nearest = min(failures, key=lambda cell: cell.judgement.residual)
            chosen.append(_told(m, nearest, "honest failure nearest to an answer"))
        others = [cell for cell in m.cells if cell.judgement.finding is Finding.ANOTHER]
        if others:
            farthest = max(others, key=lambda cell: cell.judgement.error)
            error = number_text(100.0 * farthest.judgement.error, 2)
            chosen.append(_told(m, farthest, f"another equilibrium, {error} % from the reference"))
        parts.append(f"*{m.title}*\n" + "\n".join(chosen))
    return "\n\n".join(parts)


def _told(m: StabilityMap, cell: Cell, what: str) -> str:
    grid = next(panel for panel in m.panels if panel.title == cell.panel)
    x, y = (
        f"{axis.label} = {axis.name(axis.values.index(value))}" for axis, value in ((grid.x, cell.x), (grid.y, cell.y))
    )
    return f"- {what} ({cell.panel}; {x}; {y}): {cell.says}"
