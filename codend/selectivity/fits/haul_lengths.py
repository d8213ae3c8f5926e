"""Lengths of a haul table in cm, each the middle of its class, whatever the table has.

It may have cm or mm, the lower end of classes, or intervals such as 20-22. What cannot be told from it is asked for.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from codend.errors import InputError
from codend.io.input_table import LINE, InputTable
from codend.io.table_form import interval_of

Array = NDArray[np.float64]

LENGTH_UNITS: Final = ("mm", "cm")
LENGTH_IS: Final = ("midpoint", "lower")
LONGEST_CM, LEAST_LONG_CM, SHORTEST_CM = 150.0, 50.0, 2.0
"""Beyond these the unit is asked for: few fish in a codend are longer than the first, trials whose smallest fish is
longer than the second or whose largest is shorter than the third are rare, and lengths in mm or m look like that."""
_ALLOWED: Final = "a length above 0, or an interval such as 20-22"


def middles_cm(table: InputTable, unit: str | None, length_is: str | None) -> tuple[Array, list[str]]:
    """(R,) lengths in cm at the middle of each class, and what was done to those of the table, in words.

    Args:
        table: with a column ``length_cm`` or ``length_mm``.
        unit: "mm", "cm", or None for that in the name of the column.
        length_is: "midpoint" or "lower" end of each class; None: the middle.

    Raises:
        InputError: no such column, no lengths, or their unit or classes cannot be told.
    """
    columns = table.frame.columns
    column = "length_mm" if "length_mm" in columns and "length_cm" not in columns else "length_cm"
    table.require((column,))
    if column == "length_mm" and unit == "cm":
        raise InputError(table.where, column, None, "--length-unit mm, or none", "is not in cm")
    cells = table.with_points(column)
    intervals = cells.map(lambda cell: interval_of(cell) if isinstance(cell, str) else None)
    if intervals.notna().any():
        table.check(column, intervals.notna().to_numpy(), "intervals in every row, or in none")
        lower, upper = (intervals.map(lambda ends, end=end: float(ends[end])).to_numpy(dtype=float) for end in (0, 1))
        table.check(column, (lower > 0.0) & (lower < upper), "an interval from a length above 0 to a greater one")
        lengths, notes = _middles_of(table, column, lower, upper, length_is)
    else:
        lengths = table.numbers(column, _ALLOWED, lambda v: v > 0.0)
        notes = []
        if length_is == "lower":
            width = _class_width(table, column, lengths)
            lengths = lengths + 0.5 * width
            notes = [f"{column} is the lower end of classes {width:g} wide: their middles are taken"]
        else:
            said = "" if length_is else "; --length-is lower says otherwise"
            notes = [f"{column} is taken as the middle of each class{said}"]
    if column == "length_mm" or unit == "mm":
        return lengths / 10.0, [*notes, f"{column} is in mm"]
    if unit is None and table.frame.index.name == LINE:  # whoever makes a frame knows its unit
        _check_unit(table, column, lengths)
    return lengths, [f"{note} (in cm)" for note in notes]


def _middles_of(
    table: InputTable, column: str, lower: Array, upper: Array, length_is: str | None
) -> tuple[Array, list[str]]:
    """Middles of intervals. Where some begin at the end of others they are bounds of classes, else that is asked."""
    classes = np.unique(np.stack([lower, upper], axis=1), axis=0)
    gaps = classes[1:, 0] - classes[:-1, 1]
    begin, end = classes[0]
    shown = f"{begin:g}-{end:g}"
    if (gaps < 0.0).any():
        first = int(np.argmin(gaps))
        pair = " and ".join(f"{a:g}-{b:g}" for a, b in classes[first : first + 2])
        raise InputError(table.where, column, None, "classes side by side", f"has classes that overlap, {pair}")
    if (gaps == 0.0).any():
        return 0.5 * (lower + upper), [f"{column} has intervals such as {shown}: their middles are taken"]
    if length_is is None:
        allowed = (
            f"--length-is midpoint (the class {shown} has its middle at {0.5 * (begin + end):g}) or --length-is lower "
            "(it reaches to where the next one begins)"
        )
        problem = f"has intervals such as {shown} of which none begins where another ends"
        raise InputError(table.where, column, None, allowed, problem)
    if length_is == "midpoint":
        return 0.5 * (lower + upper), [f"{column} has intervals such as {shown}: their middles are taken"]
    width = _class_width(table, column, lower)
    return lower + 0.5 * width, [
        f"{column} has intervals such as {shown}, each {width:g} wide: their middles are taken"
    ]


def _class_width(table: InputTable, column: str, lower: Array) -> float:
    """The width of classes with these lower ends: their smallest distance, where all others are multiples of it."""
    steps = np.diff(np.unique(lower))
    if steps.size:
        width = float(steps.min())
        if np.allclose(steps / width, np.round(steps / width), atol=1e-6):
            return width
    allowed = "lower ends of two or more classes, all of one width; else give their middles"
    raise InputError(table.where, column, None, allowed, "does not tell how wide its classes are")


def _check_unit(table: InputTable, column: str, lengths: Array) -> None:
    shortest, longest = lengths.min(), lengths.max()
    if SHORTEST_CM <= longest <= LONGEST_CM and shortest < LEAST_LONG_CM:
        return
    row = int(lengths.argmin() if longest <= LONGEST_CM and shortest >= LEAST_LONG_CM else lengths.argmax())
    which = "the shortest" if row == int(lengths.argmin()) and longest <= LONGEST_CM else "the longest"
    allowed = "lengths in cm; --length-unit mm or --length-unit cm says which these are"
    problem = f"in line {table.frame.index[row]} is {which}, which can hardly be in cm"
    raise InputError(table.where, column, float(lengths[row]), allowed, problem)
