"""How a table of text is laid out: what stands between its columns and in its numbers, told from the text or asked for.

What stands between columns is told by the header. A comma or point in numbers is told by all columns of numbers
together, for one cell may be read both ways: 1,234 is 1.234 in some countries and 1234 in others.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from codend.errors import OPTIONS, InputError

SEPARATORS: Final = {",": "commas", ";": "semicolons", "\t": "tabs", "|": "bars"}
DECIMALS: Final = {".": "points", ",": "commas"}
_SPELT: Final = {"tab": "\t", "\\t": "\t", "comma": ",", "semicolon": ";", "bar": "|", "point": ".", "dot": "."}

_NUMBER: Final = re.compile(r"[+-]?[\d.,]*\d[\d.,]*(?:[eE][+-]?\d+)?")
_INTERVAL: Final = re.compile(r"([\d.,]*\d)\s*(?:[-\u2013\u2014]|to)\s*([\d.,]*\d)")
_GROUPED: Final = re.compile(r"[+-]?[1-9]\d{0,2}(?:[.,]\d{3})+")
"""What may be a whole number with a mark after its thousands."""


@dataclass(frozen=True)
class TableForm:
    """What a user says of the form of a table; None: to be told from its text."""

    separator: str | None = None
    """Between columns."""
    decimal: str | None = None
    """In numbers."""
    encoding: str | None = None

    @classmethod
    def said(cls, separator: str | None, decimal: str | None, encoding: str | None) -> TableForm:
        """From the values of the options.

        Raises:
            InputError: one is not known.
        """
        marks: list[str | None] = []
        for key, value, known in (("separator", separator, SEPARATORS), ("decimal", decimal, DECIMALS)):
            mark = None if value is None else _SPELT.get(value.lower(), value)
            if mark is not None and mark not in known:
                allowed = " or ".join("tab" if mark == "\t" else f'"{mark}"' for mark in known)
                raise InputError(OPTIONS, f"--{key}", value, allowed)
            marks.append(mark)
        return cls(marks[0], marks[1], encoding)


@dataclass(frozen=True)
class Decimal:
    """What stands between whole and fraction in the numbers of a table."""

    mark: str | None
    """None where it cannot be told."""
    doubt: str = ""
    """Why not."""


def words_of(separator: str, decimal: str | None) -> str:
    """The form of a table in words, such as "semicolons between columns and commas in numbers"; "" for the plain."""
    parts = [f"{SEPARATORS[separator]} between columns"] if separator != "," else []
    parts += ["commas in numbers"] if decimal == "," else []
    return " and ".join(parts)


def separator_of(header: str, path: str | Path, *, may_ask: bool) -> str:
    """What stands between the names of a header, a comma where there is one name only.

    Raises:
        InputError: several marks stand there, or blanks.
    """
    bare = re.sub(r'"[^"]*"', "", header)
    bare = re.sub(r"\t*([,;|])\t*", r"\1", bare.strip())
    found = [mark for mark in SEPARATORS if mark in bare]
    if len(found) == 1:
        return found[0]
    if found:
        problem = f"has {' and '.join(SEPARATORS[mark] for mark in found)} in its header"
        allowed = "one mark between columns" + (", which --separator names" if may_ask else "")
        raise InputError(path, "", None, allowed, problem)
    if len(bare.split()) > 1 and not re.search(r"[()\[\]]", bare):
        raise InputError(path, "", None, "commas, semicolons or tabs", "has blanks between its columns")
    return ","


def decimal_of(columns: Iterable[Sequence[str]], separator: str) -> Decimal:
    """What stands in the numbers of a table, from the filled cells of its columns."""
    split = ([part for cell in cells for part in interval_of(cell) or (cell,)] for cells in columns)
    marked = []
    for cells in split:
        numbers = [cell for cell in cells if _NUMBER.fullmatch(cell)]
        if 2 * len(numbers) > len(cells):  # a column of numbers, but for a slip or two
            marked += [cell for cell in numbers if _mark_in(cell)]
    commas, points = ([cell for cell in marked if mark in cell] for mark in (",", "."))
    if commas and points:
        return Decimal(None, f"has points and commas in numbers ({points[0]}, {commas[0]})")
    if points and separator == ",":
        return Decimal(".")
    if marked and all(map(_GROUPED.fullmatch, marked)):
        mark = _mark_in(marked[0])
        doubt = f"has numbers such as {marked[0]}, whose {'comma' if mark == ',' else 'point'}"
        return Decimal(None, f"{doubt} may stand before a fraction or after thousands")
    return Decimal("," if commas else ".")


def interval_of(cell: str) -> tuple[str, str] | None:
    """Both ends of an interval such as 20-22; None for any other text."""
    found = _INTERVAL.fullmatch(cell.strip())
    return (found[1], found[2]) if found else None


def _mark_in(cell: str) -> str:
    return "," if "," in cell else "." if "." in cell else ""
