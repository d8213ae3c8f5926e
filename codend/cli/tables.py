"""The command ``codend tables``: tables of a folder as spreadsheets take them."""

from pathlib import Path

import click

from codend.cli.common import check_writable, written_into
from codend.errors import OPTIONS, InputError


@click.command()
@click.argument("folder", metavar="DIR", type=click.Path(path_type=Path, file_okay=False))
@click.option("--xlsx", is_flag=True, help="As one workbook, DIR/tables.xlsx, a sheet a table.")
@click.option("--semicolons", is_flag=True, help="As CSV with semicolons and decimal commas, in DIR/semicolons.")
def tables(folder: Path, xlsx: bool, semicolons: bool) -> int:
    """Write the CSV tables of DIR once more, as a workbook or with semicolons and decimal commas.

    `codend run`, `sweep`, `search` and `sensitivities` do the same as they end, by the same options. Workbooks need
    openpyxl: pip install 'codend[xlsx]'.
    """
    from codend.io.spreadsheet import WORKBOOK, check_workbooks, write_spreadsheets

    if not xlsx and not semicolons:
        raise InputError(OPTIONS, "--xlsx", None, "--xlsx or --semicolons", "is missing")
    if xlsx:
        check_workbooks()
    if not folder.is_dir():
        raise InputError(folder, "", None, "a folder with tables in CSV", "does not exist")
    check_writable(folder, (WORKBOOK,))
    with written_into(folder):
        written = write_spreadsheets(folder, xlsx, semicolons)
    for path in written:
        click.echo(f"the tables are in {path} too")
    return 0
