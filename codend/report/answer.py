"""The answer of a study, first on its page: what was asked, as large numbers, each quantity with one small plot."""

import base64
from dataclasses import dataclass

import numpy as np

from codend.net.net import Floats
from codend.report.style import BLUE, INK, PALE, number_text, spread, worth
from codend.studies.case_result import CaseResult
from codend.studies.study import Study

MOST_NUMBERS = 4
"""Catches of which a card shows the numbers; the plot beside them shows all."""
WIDTH_PX, HEIGHT_PX, LEFT_PX, BOTTOM_PX, EDGE_PX = 300.0, 110.0, 44.0, 30.0, 8.0


@dataclass(frozen=True)
class Number:
    """A number, how far it may be off, and of what."""

    value: str
    error: str
    of: str


@dataclass(frozen=True)
class Card:
    """A quantity: its numbers, and a small plot of it."""

    title: str
    unit: str
    numbers: tuple[Number, ...]
    plot: str
    """Address of the picture; empty where there is nothing to plot."""
    remark: str = ""


def cards_of(study: Study) -> list[Card]:
    """Opening and drag at the catches asked for, of the first speed that was solved."""
    results = [result for result in study.cases if result.converged]
    results = [result for result in results if result.case.speed_m_s == results[0].case.speed_m_s]
    if not results:
        return []
    results.sort(key=lambda result: result.measures.catch_volume_m3)
    density = study.plan.catch_density_kg_m3
    speeds = len(study.plan.tow.speed_m_s)
    at = f"at {number_text(results[0].case.speed_m_s)} m/s, the first of {speeds} speeds" if speeds > 1 else ""
    catch = np.array([density * result.measures.catch_volume_m3 for result in results])
    found = []
    for title, unit, name, error in (
        ("Mesh opening ahead of the catch", "°", "opening_ahead_deg", "opening_ahead_error_deg"),
        ("Drag", " N", "drag_n", "drag_error_n"),
    ):
        values = np.array([getattr(result.measures, name) for result in results])
        errors = np.array([getattr(result.errors, error) for result in results])
        numbers = tuple(
            Number(*worth(values[i], errors[i]), catch_words(results[i], density))
            for i in spread(len(results), MOST_NUMBERS)
        )
        exact = np.isfinite(errors).all() and not any(number.error for number in numbers)
        off = "estimated errors are below these digits" if exact else "" if np.isfinite(errors).all() else "± not known"
        remark = "; ".join(words for words in (at, off) if words)
        found.append(
            Card(title, unit, numbers, small_plot(catch, values, errors, "kg"), remark[:1].upper() + remark[1:])
        )
    return found


def catch_words(result: CaseResult, density_kg_m3: float) -> str:
    """The catch of a case in its mass."""
    kg = density_kg_m3 * result.measures.catch_volume_m3
    return f"{number_text(kg / 1000)} t" if kg >= 1000.0 else f"{number_text(kg)} kg"


def small_plot(x: Floats, y: Floats, error: Floats, unit: str) -> str:
    """A line of points with their errors as the address of a picture; nothing of a single point."""
    if len(x) < 2:
        return ""
    reach = np.where(np.isfinite(error), error, 0.0)
    x_range, y_range = _range(x, x), _range(y - reach, y + reach)

    def place(one: float, two: float) -> tuple[float, float]:
        across = LEFT_PX + (WIDTH_PX - LEFT_PX - EDGE_PX) * (one - x_range[0]) / (x_range[1] - x_range[0])
        up = (HEIGHT_PX - BOTTOM_PX - EDGE_PX) * (two - y_range[0]) / (y_range[1] - y_range[0])
        return across, HEIGHT_PX - BOTTOM_PX - up

    points = [place(one, two) for one, two in zip(x, y, strict=True)]
    line = " ".join(f"{a:.1f},{b:.1f}" for a, b in points)
    floor = HEIGHT_PX - BOTTOM_PX
    parts = [
        f'<path d="M{LEFT_PX},{EDGE_PX}V{floor}H{WIDTH_PX - EDGE_PX}" fill="none" stroke="{PALE}"/>',
        f'<polyline points="{line}" fill="none" stroke="{BLUE}" stroke-width="2"/>',
    ]
    for (across, up), one, two, off in zip(points, x, y, reach, strict=True):
        low, high = place(one, two - off)[1], place(one, two + off)[1]
        parts.append(f'<path d="M{across:.1f},{low:.1f}V{high:.1f}" stroke="{BLUE}" stroke-width="1.5"/>')
        parts.append(f'<circle cx="{across:.1f}" cy="{up:.1f}" r="3" fill="{BLUE}"/>')
    for value in dict.fromkeys((float(y.min()), float(y.max()))):
        parts.append(_text(LEFT_PX - 5, place(float(x[0]), value)[1] + 4, number_text(value), "end"))
    for value, anchor in ((float(x[0]), "start"), (float(x[-1]), "end")):
        parts.append(_text(place(value, float(y[0]))[0], floor + 14, f"{number_text(value)} {unit}", anchor))
    parts.append(_text((LEFT_PX + WIDTH_PX) / 2, floor + 27, "catch", "middle"))
    svg = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH_PX:.0f} {HEIGHT_PX:.0f}">{"".join(parts)}</svg>'
    return "data:image/svg+xml;base64," + base64.b64encode(svg.encode()).decode("ascii")


def _range(low: Floats, high: Floats) -> tuple[float, float]:
    first, last = float(low.min()), float(high.max())
    return (first, last) if last > first else (first - 0.5 * abs(first) - 0.5, last + 0.5 * abs(last) + 0.5)


def _text(x: float, y: float, words: str, anchor: str) -> str:
    look = f'font-family="sans-serif" font-size="11" fill="{INK}" text-anchor="{anchor}"'
    return f'<text x="{x:.1f}" y="{y:.1f}" {look}>{words}</text>'
