"""Tables of hauls as people keep them: what is in them besides single hauls of one gear and species is refused.

A row of totals counts its fish again, and a curve through two gears or two species is of neither.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from codend.errors import OPTIONS, InputError
from codend.io.input_table import InputTable, read_table
from codend.io.table_form import TableForm
from codend.selectivity.fits.haul_lengths import LENGTH_IS, LENGTH_UNITS

if TYPE_CHECKING:
    import pandas as pd

Array = NDArray[np.float64]

CATCHES: Final = ("catch_volume_m3", "catch_kg")
"""Columns of the final catch of a haul."""
_TOTAL: Final = {"total", "totals", "subtotal", "sum", "pooled", "summe", "gesamt", "insgesamt", "totaal", "totalt"}
_TOTAL_OF: Final = _TOTAL | {"totale", "totaux", "somme", "suma", "soma", "all", "grand", "sub", "haul", "hauls", "of"}
_KIND: Final = re.compile(
    r"(?:species|taxon|gear|trawl|net|netting|rig|treatment|configuration)(?:_(?:name|id|type|code|no|nr|number|kind))?"
    r"|(?:mesh|twine)(?:_(?:size|type|kind|code|mm|size_mm))?"
)
"""Names of columns that tell gears or species apart."""


@dataclass(frozen=True)
class HaulReading:
    """What a user says of a table of hauls; None: to be told from the table."""

    form: TableForm | None = None
    length_unit: str | None = None
    """"mm" or "cm"."""
    length_is: str | None = None
    """"midpoint" or "lower": what the lengths are of their classes."""
    only: tuple[str, ...] = ()
    """Rows to be read, as COLUMN=VALUE."""

    def __post_init__(self) -> None:
        """Check the choices.

        Raises:
            InputError: one does not exist.
        """
        for key, value, allowed in (
            ("--length-unit", self.length_unit, LENGTH_UNITS),
            ("--length-is", self.length_is, LENGTH_IS),
        ):
            if value is not None and value not in allowed:
                raise InputError(OPTIONS, key, value, " or ".join(allowed))
        for pair in self.only:
            if not re.fullmatch(r"[^=]*[^=\s][^=]*=.*\S.*", pair):
                raise InputError(OPTIONS, "--only", pair, "COLUMN=VALUE, such as species=cod")


AS_IT_STANDS: Final = HaulReading()


def read_haul_table(data: str | Path | pd.DataFrame, reading: HaulReading, names: Iterable[str] = ()) -> InputTable:
    """A table of hauls with the rows that are wanted, its columns named as ``names`` where they are spelt like them.

    Raises:
        InputError: as in ``read_table``; no row is left.
    """
    wanted = [tuple(part.strip() for part in pair.split("=", 1)) for pair in reading.only]
    known = (*names, *(column for column, _ in wanted))
    table = read_table(data, reading.form, known) if isinstance(data, str | Path) else InputTable("data frame", data)
    for column, value in wanted:
        table.require((column,))
        cells = table.frame[column].map(str)
        if not (kept := cells == value).any():
            raise InputError(table.where, f"--only {column}", value, _listed(cells.unique()), "is in no row")
        table = replace(table, frame=table.frame[kept.to_numpy()])
    return table


def check_no_total(table: InputTable, column: str) -> None:
    """Refuse a row whose cell in a column says that it is a total.

    Raises:
        InputError: there is one.
    """
    totals = table.frame[column].map(_says_total).to_numpy(dtype=bool)
    if not totals.all():  # hauls pooled by the user are one haul
        table.check(column, ~totals, "rows of single hauls, no totals")


def check_no_sum(table: InputTable, haul: NDArray[np.int64], length_cm: Array, test: Array, other: Array) -> None:
    """Refuse a haul that is the sum of all others, and a last row that is the sum of its haul, whatever their names.

    Raises:
        InputError: there is one.
    """
    hauls, (lengths, at) = haul.max() + 1, np.unique(length_cm, return_inverse=True)
    counted = np.zeros((2, hauls, len(lengths)))
    np.add.at(counted[0], (haul, at), test)
    np.add.at(counted[1], (haul, at), other)
    if hauls > 2 and np.count_nonzero(counted.sum(axis=(0, 1))) > 2:
        sums = (2.0 * counted == counted.sum(axis=1, keepdims=True)).all(axis=(0, 2)) & (counted.sum(axis=(0, 2)) > 0.0)
        table.check("haul", ~sums[haul], "single hauls: the fish of this one are those of all others together")
    for number in range(hauls):
        rows = np.flatnonzero(haul == number)
        last = rows[np.argmax(length_cm[rows])]
        fished = np.count_nonzero(test[rows] + other[rows])
        if fished > 4 and all(2.0 * count[last] == count[rows].sum() for count in (test, other)):
            good = np.arange(len(haul)) != last
            table.check("length_cm", good, "single length classes: the fish of this row are those of its haul together")


def check_one_kind(table: InputTable, used: Sequence[str], covariates: Array, haul: NDArray[np.int64]) -> None:
    """Refuse a table with several gears or species, unless the covariates tell them apart.

    Args:
        table: of R rows.
        used: columns that are counts, lengths, hauls or covariates.
        covariates: (H, C) of the hauls.
        haul: (R,) index of the haul.

    Raises:
        InputError: a column that names gears or species has several values.
    """
    for column in (str(name) for name in table.frame.columns if name not in used):
        if not _KIND.fullmatch(re.sub(r"[\W_]+", "_", column.casefold()).strip("_")):
            continue
        cells = table.frame[column].dropna().map(lambda cell: str(cell).strip().casefold())
        kinds = cells.unique()
        measured = cells.map(_is_number).all()
        if len(kinds) < 2 or (measured and len(kinds) > max(2, len(covariates) // 2)):
            continue  # as many as hauls: measured in each
        alike = {row.tobytes(): set[str]() for row in covariates}
        for kind, number in zip(cells, haul[table.frame[column].notna().to_numpy()], strict=True):
            alike[covariates[number].tobytes()].add(kind)
        if all(len(found) < 2 for found in alike.values()):
            continue
        first = table.frame[column].dropna().iloc[0]
        allowed = f"one gear and species at a time: --only {column}={first}"
        allowed += f", or --covariate {column}" if measured else f", or --group {column} for a curve each"
        raise InputError(table.where, column, None, allowed, f"has {len(kinds)} values ({_listed(kinds)})")


def unused(table: InputTable, used: Iterable[str]) -> list[str]:
    """In words, which columns with different values in them nobody asked for."""
    known = {*used, *CATCHES}
    left = [str(name) for name in table.frame.columns if name not in known and table.frame[name].nunique() > 1]
    return [f"not used: {', '.join(left)}"] if left else []


def _says_total(cell: object) -> bool:
    words = set(re.findall(r"[^\W\d_]+", cell.casefold())) if isinstance(cell, str) else set()
    return bool(words & _TOTAL_OF) and words <= _TOTAL_OF and not words <= {"haul", "hauls", "of", "sub", "grand"}


def _is_number(text: str) -> bool:
    return re.fullmatch(r"[\d.,]+", text) is not None


def _listed(values: Iterable[object]) -> str:
    shown = [str(value) for value in values]
    return ", ".join(shown[:5]) + (", ..." if len(shown) > 5 else "")
