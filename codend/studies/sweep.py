"""Studies over many plans: every combination of chosen values, solved side by side and taken up where it stopped."""

import math
import re
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from itertools import product
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import pandas as pd

from codend.errors import OPTIONS, InputError
from codend.io.files import COMPARISON_FILES, SELECTIVITY_TABLES, TRIAL_TABLES, whole_file, write_table
from codend.io.run_tables import read_run_table
from codend.plan.copy import plan_toml, toml_value
from codend.plan.overrides import parsed_override
from codend.plan.plan import Plan, load_plan
from codend.studies.study import solve

SweepProgress = Callable[[int, int, str], None]
"""Told how many runs are done, of how many, and what was done last."""

TABLES = ("plan.toml", "results.csv", "profile.csv", "meshes.csv")
"""Files of a run; the last one for nets without symmetry."""
MOST_RUNS = 10_000
"""Hours of solving, and a folder each; a list that makes more is a slip."""
_VALUES = "KEY=[VALUE, VALUE, ...], such as netting.0.bar_mm=[20, 25, 30]"


@dataclass(frozen=True)
class Run:
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


def runs_of(path: str | Path, vary: Sequence[str], changes: Sequence[str] = ()) -> list[Run]:
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
        runs.append(Run(number, values, load_plan(path, [*changes, *own])))
    return runs


def solve_runs(
    runs: Sequence[Run], folder: Path, processes: int = 1, progress: SweepProgress | None = None
) -> pd.DataFrame:
    """Solve the runs and keep each in ``folder/runs/<number>`` as ``codend run`` does, but for plots and VTK.

    A run whose folder holds its plan and results already is not solved again, however it ended: remove the folder to
    have it solved anew, as after an update of the program or of a Cp curve that the plan names. Once all are solved,
    runs that a longer sweep left behind are removed, and what ``codend selectivity`` and ``codend compare`` made of
    them; other files stay.

    Args:
        runs: the plans, from ``runs_of``.
        folder: where to write; every file appears whole or not at all.
        processes: how many runs are solved at once.
        progress: called after every run.

    Returns:
        ``results.csv`` of all runs, one after the other, with columns for the run and for what varies.

    Raises:
        InputError: a plan asks for what its netting does not allow; runs that are done stay done.
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


def _solved(runs: Sequence[Run], folder: Path, processes: int) -> Iterator[Run]:
    """Solve what is not solved yet; yields every run as it is done."""
    waiting = []
    for run in runs:
        if _is_done(run, folder):
            yield run
        else:
            waiting.append(run)
    # the first one alone: where no kernel is compiled yet, the others find them ready
    for run in waiting[: 1 if processes > 1 else None]:
        _solve_into(run.plan, _folder_of(run, folder))
        yield run
    if processes == 1 or len(waiting) < 2:
        return
    with ProcessPoolExecutor(processes, mp_context=get_context("spawn")) as pool:
        futures = {pool.submit(_solve_into, run.plan, _folder_of(run, folder)): run for run in waiting[1:]}
        for future in as_completed(futures):
            future.result()
            yield futures[future]


def files_of(runs: Sequence[Run]) -> list[str]:
    """Every file that ``solve_runs`` may write or remove, relative to its folder."""
    return [f"{_place_of(run)}/{name}" for run in runs for name in TABLES]


def _folder_of(run: Run, folder: Path) -> Path:
    return folder / _place_of(run)


def _place_of(run: Run) -> str:
    return f"runs/{run.number:03d}"


def _is_done(run: Run, folder: Path) -> bool:
    own = _folder_of(run, folder)
    copy = own / "plan.toml"
    return copy.is_file() and copy.read_text(encoding="utf-8") == plan_toml(run.plan)


def _solve_into(plan: Plan, folder: Path) -> None:
    """Solve a plan and write its tables; the plan's copy comes last and tells that all is there."""
    study = solve(plan)
    folder.mkdir(parents=True, exist_ok=True)
    _remove_run(folder)
    write_table(study.table, folder / "results.csv")
    write_table(study.profile, folder / "profile.csv")
    if not study.meshes.empty:
        write_table(study.meshes, folder / "meshes.csv")
    with whole_file(folder / "plan.toml") as temporary:
        temporary.write_text(plan_toml(plan), encoding="utf-8")


def _remove_leftovers(count: int, folder: Path) -> None:
    """Remove runs beyond so many. A folder with a report is one that ``codend run`` wrote, not a sweep."""
    for own in (folder / "runs").iterdir():
        beyond = re.fullmatch(r"\d{3,}", own.name) is not None and int(own.name) > count
        of_sweep = all((own / name).is_file() for name in TABLES[:3]) and not (own / "report.html").exists()
        if beyond and of_sweep and not own.is_symlink():
            _remove_run(own)
            if not any(own.iterdir()):
                own.rmdir()


def _remove_run(folder: Path) -> None:
    """Remove an earlier run from its folder, the plan's copy first, and what other commands made of it."""
    plots = folder / "plots"
    named = [folder / name for name in (*TABLES, *COMPARISON_FILES, *SELECTIVITY_TABLES, *TRIAL_TABLES)]
    for path in (*named, *plots.glob("selectivity_*.png")):
        path.unlink(missing_ok=True)
    if plots.is_dir() and not any(plots.iterdir()):
        plots.rmdir()
