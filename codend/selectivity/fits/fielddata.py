"""Field data of selectivity trials: covered-codend and paired-gear tables, read and checked."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from codend.errors import OPTIONS, InputError
from codend.io.input_table import InputTable, read_table

if TYPE_CHECKING:
    import pandas as pd

Array = NDArray[np.float64]


class DesignColumns(NamedTuple):
    """The two columns of counts of a design: the gear under test, and the cover or control."""

    test: str
    other: str


DESIGNS: Final = MappingProxyType(
    {"covered": DesignColumns("codend", "cover"), "paired": DesignColumns("test", "control")}
)


@dataclass(frozen=True)
class FieldData:
    """Counted fish of a selectivity trial, R rows (a haul and length class each).

    Attributes:
        source: the file, for messages.
        design: "covered" (codend and cover) or "paired" (test and control gear).
        haul_names: the H hauls, in order of appearance.
        haul: (R,) index into `haul_names`.
        length_cm: (R,) length class.
        test_count: (R,) fish counted in the codend or test gear; never raised numbers.
        other_count: (R,) fish counted in the cover or control gear.
        test_raising: (R,) raising factor >= 1 of the codend or test gear: raised number = count * factor.
        other_raising: (R,) raising factor >= 1 of the cover or control gear.
        covariate_names: the C haul covariates.
        covariates: (H, C) their values.
    """

    source: str
    design: str
    haul_names: tuple[str, ...]
    haul: NDArray[np.int64]
    length_cm: Array
    test_count: Array
    other_count: Array
    test_raising: Array
    other_raising: Array
    covariate_names: tuple[str, ...]
    covariates: Array

    @property
    def log_offset(self) -> Array:
        """(R,) ln of the ratio of the counted fractions, test to other: ln(other_raising / test_raising)."""
        return np.log(self.other_raising / self.test_raising)


def read_field_data(data: str | Path | pd.DataFrame, design: str, covariates: Sequence[str] = ()) -> FieldData:
    """Read and check a table of counted fish.

    Args:
        data: CSV file (lines starting with `#` are comments) or DataFrame. Columns `haul, length_cm, codend, cover`
            with optional `codend_raising, cover_raising` (design "covered"), or `haul, length_cm, test, control` with
            optional `test_raising, control_raising` ("paired").
        design: "covered" or "paired".
        covariates: names of numeric columns, constant within a haul, that L50 and SR may depend on.

    Raises:
        InputError: a missing or empty table or column, a value that is not a number, not in range, or not whole,
            a column or a length class of a haul given twice, a row of another length than the header, a covariate that
            changes within a haul or not at all.
    """
    import pandas as pd

    if design not in DESIGNS:
        raise InputError(OPTIONS, "design", design, " or ".join(DESIGNS))
    table = _table_of(data)
    source, frame = table.source, table.frame
    if frame.empty:
        raise InputError(source, "", None, "a header and at least one row", "the table has no rows")
    test, other = DESIGNS[design]
    table.require(("haul", "length_cm", test, other, *covariates))
    table.check("haul", frame["haul"].notna().to_numpy(), "a name or number in every row")
    length_cm = table.numbers("length_cm", "a length above 0", lambda v: v > 0.0)
    test_count, other_count = (
        table.numbers(
            name,
            f"a whole number of counted fish, 0 or more (raised numbers: give the count here and {name}_raising)",
            lambda v: (v >= 0.0) & (v == np.round(v)),
        )
        for name in (test, other)
    )
    test_raising, other_raising = (
        table.numbers(f"{name}_raising", "a factor of 1 or more (raised number = count * factor)", lambda v: v >= 1.0)
        if f"{name}_raising" in frame.columns
        else np.ones(len(frame))
        for name in (test, other)
    )
    if test_count.sum() + other_count.sum() == 0.0:
        raise InputError(source, test, None, "at least one fish", "and the other column hold no fish")

    haul, names = pd.factorize(frame["haul"].astype(str).to_numpy())
    repeated = pd.DataFrame({"haul": haul, "length": length_cm}).duplicated().to_numpy()
    if repeated.any():
        row = int(np.flatnonzero(repeated)[0])
        where = f"{length_cm[row]:g} (haul {names[haul[row]]})"
        raise InputError(source, "length_cm", where, "each length once in a haul", "is given twice")
    per_haul = [_covariate(table, name, haul) for name in covariates]
    return FieldData(
        source=source,
        design=design,
        haul_names=tuple(map(str, names)),
        haul=haul.astype(np.int64),
        length_cm=length_cm,
        test_count=test_count,
        other_count=other_count,
        test_raising=test_raising,
        other_raising=other_raising,
        covariate_names=tuple(covariates),
        covariates=np.stack(per_haul, axis=-1) if per_haul else np.empty((len(names), 0)),
    )


def catch_volumes_m3(data: str | Path | pd.DataFrame, field: FieldData, density_kg_m3: float) -> Array | None:
    """(H,) final catch of every haul, from the column `catch_volume_m3` or else `catch_kg`; None where there is none.

    Args:
        data: the table `field` was read from.
        field: its counted fish.
        density_kg_m3: of the catch, by which a mass becomes a volume.

    Raises:
        InputError: a catch that is no number above 0 or changes within its haul.
    """
    table = _table_of(data)
    for column, per_m3 in (("catch_volume_m3", 1.0), ("catch_kg", density_kg_m3)):
        if column in table.frame.columns:
            values = table.numbers(column, "a catch above 0", lambda v: v > 0.0)
            return _one_a_haul(table, column, values, field.haul) / per_m3
    return None


def is_simulated(path: str | Path) -> bool:
    """Whether the comments of a table say that its fish are simulated."""
    return any("simulated" in comment.lower() for comment in read_table(path).comments)


def _table_of(data: str | Path | pd.DataFrame) -> InputTable:
    return read_table(data) if isinstance(data, str | Path) else InputTable("data frame", data)


def _covariate(table: InputTable, column: str, haul: NDArray[np.int64]) -> Array:
    """(H,) values of a covariate, one a haul, not all the same."""
    values = _one_a_haul(table, column, table.numbers(column), haul)
    if np.all(values == values[0]):
        raise InputError(table.source, column, values[0].item(), "values that differ between hauls", "never changes")
    return values


def _one_a_haul(table: InputTable, column: str, values: Array, haul: NDArray[np.int64]) -> Array:
    """(H,) of the values (R,) of a column, which are to be the same in all rows of a haul."""
    first = values[np.unique(haul, return_index=True)[1]]
    table.check(column, values == first[haul], "one value that never changes within its haul")
    return first
