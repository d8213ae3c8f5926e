"""Tables as spreadsheets take them: one XLSX workbook, and CSV with semicolons and decimal commas."""

import math
from collections.abc import Mapping, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from codend.errors import OPTIONS, InputError
from codend.io.files import as_named, table_text, write_bytes

if TYPE_CHECKING:
    import pandas as pd

WORKBOOK: Final = "tables.xlsx"
SEMICOLONS: Final = "semicolons"
"""Folder of the tables with semicolons and decimal commas."""
MOST_ROWS: Final = 1_048_576
"""Of a sheet, its head among them."""
WIDEST: Final = 40
"""Characters that a column is wide at most."""


def check_workbooks() -> None:
    """Find out whether workbooks can be written.

    Raises:
        InputError: openpyxl is not installed.
    """
    if find_spec("openpyxl") is None:
        allowed = "with openpyxl installed: pip install 'codend[xlsx]'"
        raise InputError(OPTIONS, "--xlsx", None, allowed, "writes no workbook")


def tables_in(folder: Path) -> "dict[str, pd.DataFrame]":
    """The CSV tables of a folder as they stand, by their files' names; what no number is stays text."""
    import pandas as pd

    found = {}
    for path in sorted(folder.glob("*.csv")):
        table = pd.read_csv(path, comment=None, keep_default_na=False, na_values=[""], low_memory=False)
        found[path.name] = table.map(as_named).rename(columns=lambda name: str(as_named(name)))
    return found


def write_workbook(tables: "Mapping[str, pd.DataFrame]", path: Path) -> None:
    """Write tables as sheets of one workbook, numbers as numbers, texts as texts and never as formulas.

    Raises:
        InputError: a table has more rows than a sheet can hold.
    """
    from io import BytesIO

    from openpyxl import Workbook
    from openpyxl.styles import Font
    from openpyxl.utils import get_column_letter

    book = Workbook()
    book.remove(book.active)
    for name, table in tables.items():
        if len(table) >= MOST_ROWS:
            raise InputError(path, "", None, f"tables of fewer than {MOST_ROWS} rows", f"cannot hold {name}")
        sheet = book.create_sheet(Path(name).stem[:31])
        for number, cells in enumerate([list(table.columns), *table.itertuples(index=False)], start=1):
            for column, value in enumerate(cells, start=1):
                _write(sheet.cell(number, column), value)
        for column, head in enumerate(table.columns, start=1):
            sheet.cell(1, column).font = Font(bold=True)
            width = min(max(len(str(head)), 8) + 2, WIDEST)
            sheet.column_dimensions[get_column_letter(column)].width = width
        sheet.freeze_panes = "A2"
    content = BytesIO()
    book.save(content)
    write_bytes(content.getvalue(), path)


def _write(cell: Any, value: Any) -> None:
    from openpyxl.cell.cell import ILLEGAL_CHARACTERS_RE

    value = value.item() if hasattr(value, "item") else value
    if value is None or (isinstance(value, float) and not math.isfinite(value)):
        return
    if isinstance(value, bool | int | float):
        cell.value = value
        return
    cell.value = ILLEGAL_CHARACTERS_RE.sub("?", str(value))
    cell.data_type = "s"


def semicolon_text(table: "pd.DataFrame") -> str:
    """A table as CSV with semicolons between columns and commas in numbers.

    Texts that a spreadsheet would take for formulas get an apostrophe ahead.
    """
    return table_text(table, separator=";", decimal=",")


def write_semicolons(tables: "Mapping[str, pd.DataFrame]", folder: Path) -> None:
    """Write tables into a folder with semicolons and decimal commas, marked as UTF-8 for spreadsheets."""
    folder.mkdir(exist_ok=True)
    for name, table in tables.items():
        write_bytes(semicolon_text(table).encode("utf-8-sig", errors="replace"), folder / name)


def write_spreadsheets(folder: Path, xlsx: bool, semicolons: bool) -> list[Path]:
    """Write the tables of a folder once more, as asked; where.

    Raises:
        InputError: the folder holds no table, or one that a workbook cannot hold.
    """
    tables = tables_in(folder)
    if not tables:
        raise InputError(folder, "", None, "a folder with tables in CSV", "holds none")
    written = []
    if xlsx:
        write_workbook(tables, folder / WORKBOOK)
        written.append(folder / WORKBOOK)
    if semicolons:
        write_semicolons(tables, folder / SEMICOLONS)
        written.append(folder / SEMICOLONS)
    return written


def spreadsheets_in(folder: Path) -> Sequence[Path]:
    """What ``write_spreadsheets`` wrote into a folder."""
    return [folder / WORKBOOK, *(folder / SEMICOLONS).glob("*.csv")]
