"""What the commands share: exit statuses, options of KEY=VALUE, and folders they write into."""

import os
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

import click

from codend.errors import InputError

if TYPE_CHECKING:
    from codend.io.table_form import TableForm
    from codend.studies.study import Study

NO_MEANS, BAD_INPUT, NOT_CONVERGED, INTERRUPTED = 1, 2, 3, 130
"""Exit statuses; 0 is success, 1 want of memory or of an output that can be written."""


class Stopped(click.ClickException):
    """Work that ended early, with what is left of it in one line."""

    def __init__(self, message: str, status: int) -> None:
        super().__init__(message)
        self.status = status


class SeveralPairs(click.Command):
    """A command whose options of KEY=VALUE take one or more of them, up to the next word that is none."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Write the option out before each of its values."""
        spread: list[str] = []
        option = ""
        expects_value = may_go_on = False
        for word in args:
            goes_on = may_go_on and "=" in word and not word.startswith("-")
            spread += [option, word] if goes_on else [word]
            may_go_on = goes_on or expects_value or word.startswith(tuple(f"{name}=" for name in _OF_PAIRS))
            expects_value = word in _OF_PAIRS
            if word.startswith(_OF_PAIRS):
                option = word.partition("=")[0]
        return super().parse_args(ctx, spread)


_OF_PAIRS = ("--set", "--vary")

out_option = click.option(
    "--out", "folder", required=True, metavar="DIR", type=click.Path(path_type=Path), help="Where to write."
)
set_option = click.option(
    "--set",
    "changes",
    multiple=True,
    metavar="KEY=VALUE ...",
    help="Change the plan, such as --set netting.0.bar_mm=25 tow.speed_m_s=[1.0,1.5]. May be repeated.",
)


def spreadsheet_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Options for those who want tables once more as a spreadsheet takes them; a command writes them as it ends."""

    @click.option("--xlsx", is_flag=True, help="Write the tables as one workbook, tables.xlsx, too.")
    @click.option("--semicolons", is_flag=True, help="Write them with semicolons and decimal commas too.")
    @wraps(command)
    def with_spreadsheets(*args: Any, xlsx: bool, semicolons: bool, **rest: Any) -> Any:
        from codend.io.spreadsheet import check_workbooks, write_spreadsheets

        if xlsx:
            check_workbooks()
        status = command(*args, **rest)
        if xlsx or semicolons:
            folder = rest["folder"]
            with written_into(folder):
                for path in write_spreadsheets(folder, xlsx, semicolons):
                    click.echo(f"the tables are in {path} too")
        return status

    return with_spreadsheets


def table_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Options that say how a table is laid out; the command gets them as ``form``, a ``TableForm``."""

    @click.option("--separator", metavar="MARK", help="Between the table's columns: , ; | or tab, if it is unsure.")
    @click.option("--decimal", metavar="MARK", help="In the table's numbers: . or , if it is unsure.")
    @click.option("--encoding", metavar="NAME", help="Of the table, such as latin-1. Left out: UTF-8 or UTF-16.")
    @wraps(command)
    def with_form(*args: Any, separator: str | None, decimal: str | None, encoding: str | None, **rest: Any) -> Any:
        from codend.io.table_form import TableForm

        return command(*args, form=TableForm.said(separator, decimal, encoding), **rest)

    return with_form


def haul_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Options that say what a table of hauls holds; the command gets them as ``reading``, a ``HaulReading``."""

    @table_options
    @click.option("--length-unit", metavar="UNIT", help="Of the lengths: mm or cm. Left out: as the column is called.")
    @click.option(
        "--length-is", metavar="PLACE", help="What lengths are of their classes: midpoint, the default, or lower end."
    )
    @click.option("--only", multiple=True, metavar="COLUMN=VALUE", help="Read these rows alone. May be repeated.")
    @wraps(command)
    def with_reading(
        *args: Any,
        form: "TableForm",
        length_unit: str | None,
        length_is: str | None,
        only: tuple[str, ...],
        **rest: Any,
    ) -> Any:
        from codend.selectivity.fits.haul_table import HaulReading

        return command(*args, reading=HaulReading(form, length_unit, length_is, only), **rest)

    return with_reading


def check_writable(folder: Path, files: Iterable[str] = ()) -> None:
    """Find out before the work is done whether a folder and files in it can be made or written to.

    From then on the command has the folder for itself, until it ends.

    Raises:
        InputError: one cannot, and is named; another codend works in the folder.
    """
    from codend.io.own_folder import owned

    paths = [folder / file for file in files]
    for needed in dict.fromkeys((folder, *(path.parent for path in paths))):
        _check_folder(needed)
    for path in paths:
        if path.is_dir():
            _refuse(path, "it is a folder", "a file that can be written")
    with _refusing(folder):
        click.get_current_context().with_resource(owned(folder))


def _check_folder(folder: Path) -> None:
    try:
        there = next(path for path in (folder, *folder.absolute().parents) if path.exists())
    except OSError as error:  # a name too long for the file system
        _refuse(folder, error.strerror or str(error))
    if not there.is_dir():
        _refuse(folder, f"{there} is no folder")
    if not os.access(there, os.W_OK | os.X_OK):
        _refuse(folder, "permission denied")


@contextmanager
def written_into(folder: Path, older: Iterable[str] = ()) -> Iterator[None]:
    """Make a folder for the block to write to; what cannot be written is an input error.

    Args:
        folder: to write to.
        older: files in it that the block writes anew; they go first, so that what is there is of one time.
    """
    with _refusing(folder):
        folder.mkdir(parents=True, exist_ok=True)
        for name in older:
            (folder / name).unlink(missing_ok=True)
        yield


@contextmanager
def _refusing(folder: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        # of a file that was to be renamed, the second name is that which it was to have
        path = Path(error.filename2 or error.filename or folder)
        _refuse(path, error.strerror or str(error), "a file or folder that can be written")


def _refuse(path: Path, reason: str, allowed: str = "a folder that can be written") -> NoReturn:
    raise InputError(path, "", None, allowed, f"cannot be written: {reason}") from None


def explain_failures(study: "Study") -> None:
    """Say of each case that was not solved why, and what was tried."""
    for result in study.cases:
        if not result.converged:
            case = result.case
            asked = f"{case.catch_kind} = {case.catch_value:g} at {case.speed_m_s:g} m/s"
            click.echo(f"case {case.number} ({asked}) was not solved: {result.report.outcome.value}", err=True)
            for attempt in result.report.attempts:
                click.echo(f"  tried {attempt}", err=True)
