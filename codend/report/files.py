"""Writing files so that nobody ever meets half of one."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import pandas as pd


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


def write_table(table: "pd.DataFrame", path: Path) -> None:
    """Write a table as CSV; a number nobody computed (nan, or the infinite residual of no answer) is an empty cell."""
    with whole_file(path) as temporary:
        table.replace([np.inf, -np.inf], np.nan).to_csv(
            temporary, index=False, na_rep="", float_format="%.12g", encoding="utf-8", lineterminator="\n"
        )
