"""A stability map: a grid over two numbers, a solve in every cell, and what each came to."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pandas as pd

from codend.net.net import Floats
from codend.report.style import number_text
from codend.solvers.outcome import Solution
from validation.section import Verdict
from validation.stability.judge import Finding, Judgement

Solve = Callable[[float, float], tuple[Solution, Judgement]]
"""Solves the cell with these two numbers."""


@dataclass(frozen=True)
class Axis:
    """One of the two numbers of a map."""

    label: str
    values: tuple[float, ...]
    """From the least to the largest."""
    names: tuple[str, ...] = ()
    """How the values are called where that is not their number."""

    def name(self, place: int) -> str:
        """Name of a value."""
        if self.names:
            return self.names[place]
        value = self.values[place]
        return number_text(value, 2) if value < 1e4 else f"{value:.0e}".replace("e+0", "e")


@dataclass(frozen=True)
class Cell:
    """One solve of a map."""

    panel: str
    x: float
    y: float
    judgement: Judgement
    outcome: str
    iterations: int
    solve_ms: float
    says: str
    """What the tool says: its last attempt."""


@dataclass(frozen=True)
class Line:
    """A border that theory knows, drawn over the cells."""

    name: str
    x: Floats
    y: Floats


@dataclass(frozen=True)
class Panel:
    """One grid of a map."""

    title: str
    x: Axis
    y: Axis
    cells: tuple[tuple[Cell, ...], ...]
    """Rows by ``y``, each by ``x``."""
    lines: tuple[Line, ...] = ()

    def count(self, finding: Finding) -> int:
        """Number of cells that came to this."""
        return sum(cell.judgement.finding is finding for row in self.cells for cell in row)


@dataclass(frozen=True)
class StabilityMap:
    """Panels that answer one question."""

    name: str
    title: str
    question: str
    """What is varied, on which net, and how the reference was found: a sentence or two."""
    panels: tuple[Panel, ...]
    checks: tuple[Verdict, ...] = ()
    """What else was claimed: of theory, mostly."""

    @property
    def cells(self) -> list[Cell]:
        """All cells of all panels."""
        return [cell for panel in self.panels for row in panel.cells for cell in row]

    def count(self, finding: Finding) -> int:
        """Number of cells that came to this."""
        return sum(panel.count(finding) for panel in self.panels)


def panel(title: str, x: Axis, y: Axis, solve: Solve, lines: tuple[Line, ...] = ()) -> Panel:
    """Solve every cell of a grid."""
    rows = []
    for y_value in y.values:
        row = []
        for x_value in x.values:
            solution, judgement = solve(x_value, y_value)
            report = solution.report
            says = report.attempts[-1] if report.attempts else report.outcome.value
            if judgement.why:
                says = f"{judgement.why}; {says}"
            row.append(
                Cell(
                    title,
                    x_value,
                    y_value,
                    judgement,
                    report.outcome.name.lower(),
                    report.iterations,
                    report.solve_ms,
                    says,
                )
            )
        rows.append(tuple(row))
    return Panel(title, x, y, tuple(rows), lines)


def cell_table(stability_map: StabilityMap) -> pd.DataFrame:
    """The CSV of a map: a row a cell."""
    places = {p.title: p for p in stability_map.panels}
    rows = [
        {
            "panel": cell.panel,
            "x": places[cell.panel].x.label,
            "x_value": cell.x,
            "y": places[cell.panel].y.label,
            "y_value": cell.y,
            "finding": cell.judgement.finding.name.lower(),
            "outcome": cell.outcome,
            "relative_error": cell.judgement.error,
            "error_over_explained": cell.judgement.explained,
            "residual": cell.judgement.residual,
            "iterations": cell.iterations,
            "solve_ms": round(cell.solve_ms, 2),
            "says": cell.says,
        }
        for cell in stability_map.cells
    ]
    return pd.DataFrame(rows)


def spaced(first: float, last: float, count: int) -> tuple[float, ...]:
    """Values in equal ratios, to three digits."""
    return tuple(float(f"{value:.3g}") for value in np.geomspace(first, last, count))
