"""Recompute the validation, section by section, and write REPORT.md with its figures and data.

Exit status 1 when a check failed; a line says which.
"""

from collections.abc import Iterator, Sequence
from importlib import import_module
from pathlib import Path
from time import perf_counter
from traceback import print_exc

import click

from codend.cli.common import BAD_INPUT, check_writable, written_into
from codend.errors import InputError
from validation.machine import machine
from validation.report import Part, write_report
from validation.section import Section, Verdict

SECTIONS = {
    "checks": "validation.independent_checks",
    "agreement": "validation.agreement",
    "flume": "validation.flume",
    "work_precision": "validation.work_precision",
    "stability": "validation.stability",
    "wrinkles": "validation.wrinkles",
    "folds": "validation.folds",
    "contact": "validation.contact",
    "motion": "validation.motion_map",
}
"""Name and module, with a function ``section(quick)``, of every section, in the report's order."""

FAILED = 1
"""Exit status where a check failed."""
COMMITTED, ASIDE = Path(__file__).parent, Path("results/validation")
"""Where the report goes by default: the whole one, and one that is quick or in part."""


@click.command(help=__doc__)
@click.option("--quick", is_flag=True, help="A coarser version, in minutes, for machines that test changes.")
@click.option("--only", "names", multiple=True, metavar="NAME", help="This section; may be repeated.")
@click.option(
    "--out",
    "folder",
    type=click.Path(path_type=Path),
    metavar="DIR",
    help=f"Where to write; by default {ASIDE} with --quick or --only, else the folder validation.",
)
def main(quick: bool, names: tuple[str, ...], folder: Path | None) -> None:
    """Run the sections and write the report; exit status 1 if a check failed."""
    for name in names:
        if name not in SECTIONS:
            raise click.BadParameter(f"{name!r} is none of {', '.join(SECTIONS)}", param_hint="--only")
    chosen = [name for name in SECTIONS if name in names or not names]
    folder = folder or (ASIDE if quick or names else COMMITTED)
    facts = machine()  # ahead of the work, which may change files
    try:
        check_writable(folder)
        parts = list(run_sections(chosen, quick))
        with written_into(folder):
            report = write_report(folder, parts, _how(chosen, quick), facts)
    except InputError as error:
        click.echo(f"validation: {error}", err=True)
        raise SystemExit(BAD_INPUT) from None
    click.echo(f"{report} written")
    failures = [failure for part in parts for failure in part.failures]
    for failure in failures:
        click.echo(f"FAILED {failure}", err=True)
    raise SystemExit(FAILED if failures else 0)


def run_sections(names: Sequence[str], quick: bool) -> Iterator[Part]:
    """Run sections one after the other, telling how each went; one that raises is a section with a failed verdict."""
    taken: set[str] = set()
    for number, name in enumerate(names, start=1):
        click.echo(f"{name}, section {number} of {len(names)} ...", err=True)
        began = perf_counter()
        try:
            section = import_module(SECTIONS[name]).section(quick)
            files = [f"{p.name}.png" for p in section.pictures] + [f"{stem}.csv" for stem in section.data]
            if again := taken.intersection(files):
                raise ValueError(f"another section has files named {', '.join(sorted(again))}")
            taken.update(files)
        except Exception as error:  # whatever went wrong, the other sections are still wanted
            print_exc()
            section = _raised(name, error)
        passed = sum(verdict.passed for verdict in section.verdicts)
        seconds = perf_counter() - began
        click.echo(f"{name}: {passed} of {len(section.verdicts)} checks passed, {seconds:.1f} s", err=True)
        yield Part(name, section)


def _raised(name: str, error: Exception) -> Section:
    found = f"{type(error).__name__}: {error}"
    return Section(name, "This section could not be computed.", verdicts=(Verdict("It runs to its end", False, found),))


def _how(chosen: list[str], quick: bool) -> str:
    options = (["--quick"] if quick else []) + (
        [f"--only {name}" for name in chosen] if len(chosen) < len(SECTIONS) else []
    )
    command = " ".join(["python -m validation", *options])
    text = f"This report is what `{command}` wrote; every number in it was computed then, none typed by hand."
    if quick:
        text += " With `--quick` grids are coarser and nets smaller than in the full report."
    left_out = [name for name in SECTIONS if name not in chosen]
    if left_out:
        text += f" Left out: {', '.join(left_out)}."
    return text


if __name__ == "__main__":
    main()
