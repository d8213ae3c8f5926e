"""Runs of a study that are solved one after the other by one worker, and the rows that come of them."""

import gc
from collections.abc import Iterator, Sequence, Set
from contextlib import contextmanager
from dataclasses import dataclass, replace
from itertools import chain
from threading import Lock
from typing import Any

import numpy as np
import pyarrow as pa

from catch_models.fish import Species
from codend.equilibrium.fidelity import choose
from codend.errors import InputError
from codend.io.columns import REASON, TEXT_COLUMNS
from codend.plan.copy import toml_value
from codend.plan.plan import Plan
from codend.studies import tables
from codend.studies.case_result import CaseResult
from codend.studies.catches_solved import selectivity_in
from codend.studies.designs import Run
from codend.studies.study import Study, solve

_LOOKED_FOR_AFTER = 20_000
"""Objects made, over those that went, after which Python looks for some that only refer to each other: what some ten
cases of a sector make. As often as it does otherwise that takes a twentieth of a study's time."""
_seen_to = Lock()


@dataclass(frozen=True)
class Chunk:
    """Neighbouring runs: every equilibrium helps to the next, and what comes of them depends on nothing else."""

    number: int
    """Counted from 0."""
    runs: tuple[Run, ...]
    species: tuple[Species, ...]
    with_design: bool
    """Whether the study's designs have names, which make a column."""
    text: frozenset[str] = frozenset()
    """Keys that vary whose values are text in the table, in every chunk alike."""


def solve_chunk(chunk: Chunk) -> pa.Table:
    """Solve the runs of a chunk in turn.

    Returns:
        ``results.csv`` of all, with columns for the run and for what varies ahead, selectivity and reason behind. A
        run whose values make no plan is one row with its reason.
    """
    with _seldom_looked_for():
        return _table(_rows_of_chunk(chunk), chunk.text.union(TEXT_COLUMNS))


@contextmanager
def _seldom_looked_for() -> Iterator[None]:
    """Have Python look for objects that only refer to each other as seldom as ``_LOOKED_FOR_AFTER`` in the block.

    As often as before behind it, for whoever calls; of several threads the first sees to that for all.
    """
    if not _seen_to.acquire(blocking=False):
        yield
        return
    usual = gc.get_threshold()
    gc.set_threshold(max(_LOOKED_FOR_AFTER, usual[0]) if usual[0] else 0, *usual[1:])
    try:
        yield
    finally:
        gc.set_threshold(*usual)
        _seen_to.release()


def _rows_of_chunk(chunk: Chunk) -> list[dict[str, Any]]:
    rows: list[dict[str, Any]] = []
    near: list[CaseResult] = []
    for run in chunk.runs:
        told: dict[str, Any] = {"run": run.number}
        if chunk.with_design:
            told["design"] = run.base.name
        try:
            told |= {key: _cell(value) for key, value in run.all_values.items()}
            plan = run.plan()
        except InputError as error:
            rows.append({**told, "converged": False, REASON: str(error)})
            continue
        for study, reason in _studies_of(plan, near):
            rows += [{**told, **row} for row in _rows_of(study, chunk.species)] if study else []
            if reason is not None:
                rows.append({**told, **reason})
            near += [result for result in study.cases if result.converged] if study else []
    return rows


def _studies_of(plan: Plan, near: Sequence[CaseResult]) -> Iterator[tuple[Study | None, dict[str, Any] | None]]:
    """The study of a plan; where an error of the program ends it, one of every case, or a row that says so."""
    try:
        yield solve(plan, near=near), None
        return
    except InputError as error:
        yield None, {"converged": False, REASON: str(error)}
        return
    except Exception as error:
        problem = error
    cases = plan.cases()
    for case in cases:
        asked = {"case": case.number, "speed_m_s": case.speed_m_s}
        if len(cases) > 1:
            alone = plan.model_copy(
                update={
                    "tow": plan.tow.model_copy(update={"speed_m_s": (case.speed_m_s,)}),
                    "catch": plan.catch.model_copy(update={case.catch_kind: (case.catch_value,)}),
                }
            )
            try:
                (found,) = solve(alone).cases
            except Exception as error:
                problem = error
            else:
                # numbered as in the whole plan
                renumbered = replace(found, case=case)
                yield Study(plan, choose(plan), (renumbered,)), None
                continue
        words = f"an error of the program: {type(problem).__name__}: {' '.join(str(problem).split())}"
        yield None, {**asked, "converged": False, REASON: words}


def _rows_of(study: Study, species: Sequence[Species]) -> Iterator[dict[str, Any]]:
    selected = selectivity_in(study, species) if species else {}
    columns = tables.result_columns(study.plan)
    for result in study.cases:
        found = tables.result_row(study.plan, study.choice.fidelity, result)
        row = {name: found[name] for name in columns}
        reason = None if result.converged else result.report.outcome.value
        yield {**row, **selected.get(result.case.number, {}), REASON: reason}


def _cell(value: Any) -> Any:
    return toml_value(list(value)) if isinstance(value, list | tuple) else value


def _table(rows: Sequence[dict[str, Any]], text: Set[str]) -> pa.Table:
    """Rows as columns of one kind each, those named as ``text``, the reason last; what no row has is missing."""
    names = [name for name in dict.fromkeys(chain.from_iterable(rows)) if name != REASON]
    columns = zip(*(map(row.get, (*names, REASON)) for row in rows), strict=True)
    found = zip((*names, REASON), columns, strict=True)
    return pa.table({name: _column(cells, name in text) for name, cells in found})


def _column(cells: Sequence[Any], is_text: bool) -> pa.Array:
    kinds = set(map(type, cells))
    if kinds == {float} and not is_text:
        return pa.array(cells, pa.float64())
    kinds.discard(type(None))
    if is_text or str in kinds:
        return pa.array([_text(cell) for cell in cells], pa.string())
    if kinds and kinds <= {bool, np.bool_}:
        return pa.array(cells, pa.bool_())
    if kinds and all(issubclass(kind, int | np.integer) and kind is not bool for kind in kinds):
        return pa.array(cells, pa.int64())
    return pa.array([np.nan if cell is None else float(cell) for cell in cells], pa.float64())


def _text(cell: Any) -> str | None:
    missing = cell is None or (isinstance(cell, float) and np.isnan(cell))
    return None if missing else cell if isinstance(cell, str) else toml_value(cell)
