"""Sensitivities and intervals of all designs of a study, by several processes."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import pandas as pd

from catch_models.fish import Species
from codend.errors import InputError
from codend.studies.sensitivity.table import case_sensitivities, sensitivity_table
from codend.studies.sensitivity.uncertain import interval_table
from codend.studies.study_file import StudyPlan
from codend.studies.workers import done_by_workers

MOST_DESIGNS: Final = 1000
"""A second each, or more."""
DesignsProgress = Callable[[int, int, str], None]


@dataclass(frozen=True)
class OfDesigns:
    """What was found of a study's designs."""

    sensitivities: pd.DataFrame
    """``sensitivities.csv``, with columns for the run and its design ahead."""
    intervals: pd.DataFrame
    """``intervals.csv``, likewise."""
    missing: int
    """Cases of which nothing was found, for they are not solved."""


@dataclass(frozen=True)
class _Job:
    study: StudyPlan
    number: int
    species: tuple[Species, ...]
    keys: tuple[str, ...] | None


def check_count(study: StudyPlan) -> None:
    """Refuse a study of too many designs to ask each.

    Raises:
        InputError: it has.
    """
    if (count := len(study.designs)) > MOST_DESIGNS:
        allowed = f"at most {MOST_DESIGNS} designs, whose numbers are asked one by one"
        raise InputError(
            study.source, "uncertain" if study.uncertain else "vary", None, allowed, f"has {count} designs"
        )


def of_designs(
    study: StudyPlan,
    species: Sequence[Species],
    keys: Sequence[str] | None = None,
    workers: int = 1,
    progress: DesignsProgress | None = None,
) -> OfDesigns:
    """Ask every design of a study.

    Args:
        study: with its designs, and what is uncertain.
        species: whose L50 and SR are asked.
        keys: numbers of the plans to ask; all that they name by default.
        workers: processes.
        progress: told how many designs are done.
    """
    count = len(study.designs)
    wanted = None if keys is None else tuple(keys)
    jobs = [_Job(study, number, tuple(species), wanted) for number in range(1, count + 1)]
    found: dict[int, tuple[pd.DataFrame, pd.DataFrame, int]] = {}
    for job, tables in done_by_workers(_asked, jobs, min(workers, count)):
        found[job.number] = tables
        if progress is not None:
            progress(len(found), count, f"sensitivities of run {job.number}")
    ordered = [found[number] for number in sorted(found)]
    return OfDesigns(
        sensitivities=pd.concat([one[0] for one in ordered], ignore_index=True),
        intervals=pd.concat([one[1] for one in ordered], ignore_index=True),
        missing=sum(one[2] for one in ordered),
    )


def _asked(job: _Job) -> tuple[pd.DataFrame, pd.DataFrame, int]:
    """Sensitivities and intervals of a design, and how many cases have none; all of a plan that cannot be."""
    run = job.study.designs.run(job.number)
    try:
        plan = run.plan()
        cases = case_sensitivities(plan, job.species, job.keys)
        missing = len(plan.cases()) - len(cases)
    except InputError:
        if len(job.study.designs) == 1:
            raise
        cases, missing = [], 1  # of a sweep a row says why
    uncertain: Mapping[str, float] = job.study.uncertain
    tables = sensitivity_table(cases), interval_table(cases, uncertain)
    ahead: dict[str, Any] = {"run": job.number} if len(job.study.designs) > 1 else {}
    if run.base.name:
        ahead["design"] = run.base.name
    for table in tables:
        for place, (name, value) in enumerate(ahead.items()):
            table.insert(place, name, value)
    return *tables, missing
