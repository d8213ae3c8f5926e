"""Writing files so that nobody ever meets half of one, and the names of those that are made of a run later."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import pandas as pd

COMPARISON_FILES = ("comparison.csv", "comparison_summary.csv", "comparison.png")
"""What ``codend compare`` writes: every value, their statistics, and the figure."""
TRIAL_TABLES = ("together.csv", "together_l50.csv", "calibration.csv", "calibrated_species.toml")
"""What ``codend selectivity`` writes beside ``SELECTIVITY_TABLES`` when it is given a trial."""
SELECTIVITY_TABLES = ("selectivity.csv", "retention.csv", "sensitivity.csv")

_FORMULA = ("=", "+", "-", "@")


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """Give a temporary path beside ``path`` to write to, and rename it once the block has ended well.

    A block that raises leaves ``path`` as it was, and no temporary file behind.
    """
    temporary = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        yield temporary
        os.replace(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)


def table_text(table: "pd.DataFrame", separator: str = ",", decimal: str = ".") -> str:
    """A table as CSV; a number nobody computed (nan, or the infinite residual of no answer) is an empty cell.

    Texts that a spreadsheet would take for formulas get an apostrophe ahead, by which it knows them for texts.
    """
    import pandas as pd

    table = table.rename(columns=_no_formula)
    for place, dtype in enumerate(table.dtypes):
        if not pd.api.types.is_numeric_dtype(dtype):
            table.isetitem(place, [_no_formula(cell) for cell in table.iloc[:, place]])
    return table.replace([np.inf, -np.inf], np.nan).to_csv(
        index=False, na_rep="", float_format="%.12g", lineterminator="\n", sep=separator, decimal=decimal
    )


def write_table(table: "pd.DataFrame", path: Path) -> None:
    """Write a table as ``table_text``."""
    write_text(table_text(table), path)


def write_text(text: str, path: Path) -> None:
    """Write a text in UTF-8; of names that no text can hold (bytes that are not UTF-8) a question mark stays."""
    write_bytes(text.encode(errors="replace"), path)


def write_bytes(content: bytes, path: Path) -> None:
    """Write bytes, such as a picture, whole or not at all."""
    with whole_file(path) as temporary:
        temporary.write_bytes(content)


def as_named(cell: object) -> object:
    """A text read back from a table, without the apostrophe it was given."""
    bare = cell[1:] if isinstance(cell, str) and cell.startswith("'") else cell
    return bare if _no_formula(bare) == cell else cell


def _no_formula(cell: object) -> object:
    return f"'{cell}" if isinstance(cell, str) and cell.lstrip().startswith(_FORMULA) else cell
