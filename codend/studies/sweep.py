"""Studies over many plans: every combination of chosen values, solved side by side and taken up where it stopped."""

import math
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any

import pandas as pd

from codend.errors import OPTIONS, InputError
from codend.io.files import table_text, write_text
from codend.io.own_folder import owned
from codend.io.run_tables import read_run_table
from codend.plan.copy import plan_toml, toml_value
from codend.plan.overrides import parsed_override
from codend.plan.plan import Plan, load_plan
from codend.studies.run_record import RECORD, TABLES, inputs_of, remove_run, why_not_done, write_record
from codend.studies.study import solve
from codend.studies.workers import done_by_workers

SweepProgress = Callable[[int, int, str], None]
"""Told how many runs are done, of how many, and what was done last."""

MOST_RUNS = 10_000
"""Hours of solving, and a folder each; a list that makes more is a slip."""
_VALUES = "KEY=[VALUE, VALUE, ...], such as netting.0.bar_mm=[20, 25, 30]"


@dataclass(frozen=True)
class SweepRun:
    """One plan of a sweep."""

    number: int
    """Counted from 1."""
    values: dict[str, Any]
    """What it has for each key that is varied."""
    plan: Plan

    @property
    def label(self) -> str:
        """Its values in words."""
        return ", ".join(f"{key} = {toml_value(value)}" for key, value in self.values.items())


def runs_of(path: str | Path, vary: Sequence[str], changes: Sequence[str] = ()) -> list[SweepRun]:
    """Plans with every combination of the varied values, the last key running fastest; all are checked.

    Args:
        path: the plan file.
        vary: ``KEY=[VALUE, ...]`` each.
        changes: ``KEY=VALUE`` that hold for all of them, as ``load_plan`` takes them.

    Raises:
        InputError: a key or value is not allowed, what varies is no list of different values, or has one value by
            ``changes``.
    """
    axes: dict[str, list[Any]] = {}
    fixed = {parsed_override(text, path)[0] for text in changes}
    for text in vary:
        key, values = parsed_override(text, path)
        dotted = ".".join(key)
        if not isinstance(values, list) or not values:
            raise InputError(OPTIONS, f"--vary {dotted}", values, _VALUES, "is no list of values to vary")
        if dotted in axes:
            raise InputError(OPTIONS, f"--vary {dotted}", values, "each key once", "is varied twice")
        if key in fixed:
            raise InputError(OPTIONS, f"--vary {dotted}", values, "--vary or --set", "is set to one value as well")
        for i, value in enumerate(values):
            if value in values[:i]:
                raise InputError(OPTIONS, f"--vary {dotted}", values, "each value once", "has a value twice")
        axes[dotted] = values
    count = math.prod(map(len, axes.values()))
    if count > MOST_RUNS:
        allowed = f"at most {MOST_RUNS} runs, every value with every other"
        raise InputError(OPTIONS, f"--vary {', '.join(axes)}", None, allowed, f"makes {count} runs")
    runs = []
    for number, combination in enumerate(product(*axes.values()), start=1):
        values = dict(zip(axes, combination, strict=True))
        own = [f"{key}={toml_value(value)}" for key, value in values.items()]
        runs.append(SweepRun(number, values, load_plan(path, [*changes, *own])))
    return runs


def solve_runs(
    runs: Sequence[SweepRun], folder: Path, processes: int = 1, progress: SweepProgress | None = None
) -> pd.DataFrame:
    """Solve the runs and keep each in ``folder/runs/<number>`` as ``codend run`` does, but for plots and VTK.

    A run is not solved again where ``why_again`` finds nothing, however it ended. Once all are solved, runs that a
    longer sweep left behind are removed, and what ``codend selectivity`` and ``codend compare`` made of them; other
    files stay.

    Args:
        runs: the plans, from ``runs_of``.
        folder: where to write; every file appears whole or not at all.
        processes: how many runs are solved at once.
        progress: called after every run.

    Returns:
        ``results.csv`` of all runs, one after the other, with columns for the run and for what varies.

    Raises:
        InputError: a plan asks for what its netting does not allow, or another codend works in the folder of a run;
            runs that are done stay done.
        BrokenProcessPool: one of several processes was killed, or found too little memory; the same holds.
    """
    for done, run in enumerate(_solved(runs, folder, processes), start=1):
        if progress is not None:
            progress(done, len(runs), run.label)
    tables = []
    for run in runs:
        table = read_run_table(_folder_of(run, folder) / "results.csv")
        for place, (key, value) in enumerate({"run": run.number, **run.values}.items()):
            table.insert(place, key, toml_value(value) if isinstance(value, list) else value)
        tables.append(table)
    _remove_leftovers(len(runs), folder)
    return pd.concat(tables, ignore_index=True)


def why_again(runs: Sequence[SweepRun], folder: Path) -> dict[str, list[int]]:
    """Numbers of the runs that a folder holds but that are to be solved again, by the reason why.

    A run is done when program, plan and the files the plan names are those it was solved with, and its tables are as
    they were written.
    """
    found: dict[str, list[int]] = {}
    for run in runs:
        own = _folder_of(run, folder)
        reason = why_not_done(own, inputs_of(run.plan))
        if reason is not None and any((own / name).exists() for name in ("plan.toml", RECORD, *TABLES)):
            found.setdefault(reason, []).append(run.number)
    return found


def _solved(runs: Sequence[SweepRun], folder: Path, processes: int) -> Iterator[SweepRun]:
    """Solve what is not solved yet; yields every run as it is done. Only this process writes, which owns the folder."""
    waiting = []
    for run in runs:
        if why_not_done(_folder_of(run, folder), inputs := inputs_of(run.plan)) is None:
            yield run
        else:
            waiting.append((run, inputs))
    # the first one alone: where no kernel is compiled yet, the others find them ready
    for run, inputs in waiting[: 1 if processes > 1 else None]:
        _write(run, inputs, _tables_of(run.plan), folder)
        yield run
    if processes == 1 or len(waiting) < 2:
        return
    plans = {run.number: (run, inputs) for run, inputs in waiting[1:]}
    jobs = [(run.number, run.plan) for run, _ in waiting[1:]]
    for (number, _), tables in done_by_workers(_numbered_tables, jobs, min(processes, len(jobs))):
        run, inputs = plans[number]
        _write(run, inputs, tables, folder)
        yield run


def _numbered_tables(job: tuple[int, Plan]) -> dict[str, str]:
    return _tables_of(job[1])


def files_of(runs: Sequence[SweepRun]) -> list[str]:
    """Every file that ``solve_runs`` may write or remove, relative to its folder."""
    return [f"{_place_of(run)}/{name}" for run in runs for name in ("plan.toml", *TABLES, RECORD)]


def _folder_of(run: SweepRun, folder: Path) -> Path:
    return folder / _place_of(run)


def _place_of(run: SweepRun) -> str:
    return f"runs/{run.number:03d}"


def _tables_of(plan: Plan) -> dict[str, str]:
    """Solve a plan; its tables as texts, by name."""
    return {name: table_text(table) for name, table in solve(plan).tables.items()}


def _write(run: SweepRun, inputs: dict[str, str], tables: dict[str, str], folder: Path) -> None:
    """Write a solved run in the place of an earlier one; its record comes last and tells that all is there."""
    own = _folder_of(run, folder)
    with owned(own):
        remove_run(own)
        write_text(plan_toml(run.plan), own / "plan.toml")
        for name, text in tables.items():
            write_text(text, own / name)
        write_record(own, inputs)


def _remove_leftovers(count: int, folder: Path) -> None:
    """Remove runs beyond so many. A folder with a report is one that ``codend run`` wrote, not a sweep."""
    for own in (folder / "runs").iterdir():
        beyond = re.fullmatch(r"\d{3,}", own.name) is not None and int(own.name) > count
        tables = all((own / name).is_file() for name in ("plan.toml", "results.csv", "profile.csv"))
        if beyond and tables and not (own / "report.html").exists() and not own.is_symlink():
            remove_run(own)
            if not any(own.iterdir()):
                own.rmdir()
