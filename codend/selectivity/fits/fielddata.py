"""Field data of selectivity trials: covered-codend and paired-gear tables, read and checked."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from codend.errors import OPTIONS, InputError
from codend.io.input_table import InputTable, read_table
from codend.selectivity.fits.haul_lengths import middles_cm
from codend.selectivity.fits.haul_table import (
    AS_IT_STANDS,
    CATCHES,
    HaulReading,
    check_no_sum,
    check_no_total,
    check_one_kind,
    read_haul_table,
    unused,
)
from codend.selectivity.fits.raising import raising_notes

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
        length_cm: (R,) middle of the length class.
        test_count: (R,) fish counted in the codend or test gear; never raised numbers.
        other_count: (R,) fish counted in the cover or control gear.
        test_raising: (R,) raising factor >= 1 of the codend or test gear: raised number = count * factor.
        other_raising: (R,) raising factor >= 1 of the cover or control gear.
        covariate_names: the C haul covariates.
        covariates: (H, C) their values.
        notes: in words, what was done to the table and what of it was not used.
        columns: (H,) each, of the columns of the table that are constant within hauls, for formulas.
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
    notes: tuple[str, ...] = ()
    columns: Mapping[str, Array | NDArray[np.object_]] = field(default_factory=dict)

    def haul_columns(self) -> pd.DataFrame:
        """A row a haul, with its name and what else is known of it: numbers as such, others as text."""
        import pandas as pd

        return pd.DataFrame({"haul": list(self.haul_names)} | dict(self.columns))

    @property
    def log_offset(self) -> Array:
        """(R,) ln of the ratio of the counted fractions, test to other: ln(other_raising / test_raising)."""
        return np.log(self.other_raising / self.test_raising)


def read_field_data(
    data: str | Path | pd.DataFrame,
    design: str,
    covariates: Sequence[str] = (),
    reading: HaulReading = AS_IT_STANDS,
    *,
    factors: Sequence[str] = (),
    in_formulas: Sequence[str] = (),
) -> FieldData:
    """Read and check a table of counted fish.

    Args:
        data: CSV file (lines starting with `#` are comments) or DataFrame. Columns `haul, length_cm, codend, cover`
            with optional `codend_raising, cover_raising` (design "covered"), or `haul, length_cm, test, control` with
            optional `test_raising, control_raising` ("paired"); `length_mm` will do for `length_cm`.
        design: "covered" or "paired".
        covariates: names of numeric columns, constant within a haul, that L50 and SR may depend on.
        reading: what the user says of the form of the table, its lengths and the rows that are wanted.
        factors: columns, constant within a haul, whose values are names even where they look like numbers.
        in_formulas: columns that formulas use, and which so may tell gears apart.

    Raises:
        InputError: a missing or empty table or column, a value that is not a number, not in range, or not whole,
            a column or a length class of a haul given twice, a row of another length than the header, totals, several
            gears or species, lengths whose unit or classes cannot be told, a covariate that changes within a haul or
            not at all, or that says what others say.
    """
    import pandas as pd

    if design not in DESIGNS:
        raise InputError(OPTIONS, "design", design, " or ".join(DESIGNS))
    test, other = DESIGNS[design]
    raisings = f"{test}_raising", f"{other}_raising"
    used = ("haul", "length_cm", "length_mm", test, other, *raisings, *covariates, *factors, *in_formulas)
    table = read_haul_table(data, reading, used)
    source, frame = table.source, table.frame
    if frame.empty:
        raise InputError(source, "", None, "a header and at least one row", "the table has no rows")
    length = "length_mm" if "length_mm" in frame.columns and "length_cm" not in frame.columns else "length_cm"
    table.require(("haul", length, test, other, *covariates, *factors))
    for column in ("haul", length):
        check_no_total(table, column)
    table.check("haul", frame["haul"].notna().to_numpy(), "a name or number in every row")
    length_cm, notes = middles_cm(table, reading.length_unit, reading.length_is)
    test_count, other_count = (
        table.numbers(
            name,
            f"a whole number of counted fish, 0 or more (raised numbers: give the count here and the factor in "
            f"{name}_raising; fitted as counts they make errors too small)",
            lambda v: (v >= 0.0) & (v == np.round(v)),
        )
        for name in (test, other)
    )
    test_raising, other_raising = (
        table.numbers(name, "a factor of 1 or more (raised number = count * factor)", lambda v: v >= 1.0)
        if name in frame.columns
        else np.ones(len(frame))
        for name in raisings
    )
    if test_count.sum() + other_count.sum() == 0.0:
        raise InputError(source, test, None, "at least one fish", "and the other column hold no fish")

    raised = raising_notes((test, other), (test_count, other_count), (test_raising, other_raising))
    haul, names = pd.factorize(frame["haul"].astype(str).to_numpy())
    per_haul = [_covariate(table, name, haul) for name in covariates]
    of_hauls = np.stack(per_haul, axis=-1) if per_haul else np.empty((len(names), 0))
    check_one_kind(table, used, of_hauls, haul)
    check_no_sum(table, haul, length_cm, test_count, other_count)
    _check_independent(table, covariates, of_hauls)
    repeated = pd.DataFrame({"haul": haul, "length": length_cm}).duplicated().to_numpy()
    if repeated.any():
        row = int(np.flatnonzero(repeated)[0])
        where = f"{length_cm[row]:g} (haul {names[haul[row]]})"
        raise InputError(source, "length_cm", where, "each length once in a haul", "is given twice")
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
        covariates=of_hauls,
        columns=_haul_columns(table, haul, factors),
        notes=(*([f"{source} has {table.form}"] if table.form else []), *notes, *raised, *unused(table, used)),
    )


def _haul_columns(
    table: InputTable, haul: NDArray[np.int64], factors: Sequence[str]
) -> dict[str, Array | NDArray[np.object_]]:
    """(H,) values of the columns of a table of R rows that are constant within hauls, but for `haul` itself.

    Raises:
        InputError: a factor changes within a haul.
    """
    import pandas as pd

    first = np.unique(haul, return_index=True)[1]
    kept: dict[str, Array | NDArray[np.object_]] = {}
    for column in table.frame.columns.difference(["haul"], sort=False):
        cells = table.frame[column]
        same = (cells.iloc[first[haul]].to_numpy() == cells.to_numpy()) & cells.notna().to_numpy()
        if column in factors:
            table.check(str(column), same, "one value that never changes within its haul")
        if not same.all():
            continue
        texts = cells.iloc[first].astype(str).to_numpy(dtype=object)
        if column in factors or not np.isfinite(pd.to_numeric(_pointed(table, column), errors="coerce")).all():
            kept[str(column)] = texts
        else:
            kept[str(column)] = pd.to_numeric(_pointed(table, column)).to_numpy(dtype=float)[first]
    return kept


def _pointed(table: InputTable, column: str) -> pd.Series:
    """The cells of a column with points in their numbers; as they stand where it is no column of text."""
    return table.with_points(column) if table.frame[column].dtype.kind not in "biuf" else table.frame[column]


def catch_volumes_m3(
    data: str | Path | pd.DataFrame, field: FieldData, density_kg_m3: float, reading: HaulReading = AS_IT_STANDS
) -> Array | None:
    """(H,) final catch of every haul, from the column `catch_volume_m3` or else `catch_kg`; None where there is none.

    Args:
        data: the table `field` was read from.
        field: its counted fish.
        density_kg_m3: of the catch, by which a mass becomes a volume.
        reading: as the table was read for `field`.

    Raises:
        InputError: a catch that is no number above 0 or changes within its haul.
    """
    table = read_haul_table(data, reading, CATCHES)
    for column, per_m3 in zip(CATCHES, (1.0, density_kg_m3), strict=True):
        if column in table.frame.columns:
            values = table.numbers(column, "a catch above 0", lambda v: v > 0.0)
            return _one_a_haul(table, column, values, field.haul) / per_m3
    return None


def is_simulated(path: str | Path, reading: HaulReading = AS_IT_STANDS) -> bool:
    """Whether the comments of a table say that its fish are simulated."""
    return any("simulated" in comment.lower() for comment in read_table(path, reading.form).comments)


def _check_independent(table: InputTable, names: Sequence[str], covariates: Array) -> None:
    """Refuse a covariate that is a constant and multiples of those before it, over the hauls; covariates (H, C)."""
    spread = (covariates - covariates.mean(axis=0)) / covariates.std(axis=0)
    for count in range(2, len(names) + 1):
        if np.linalg.matrix_rank(spread[:, :count], tol=1e-6 * len(spread) ** 0.5) < count:
            others = " and ".join(names[: count - 1])
            allowed = f"covariates that say something else each, over these {len(spread)} hauls"
            raise InputError(table.where, names[count - 1], None, allowed, f"says the same as {others}")


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
