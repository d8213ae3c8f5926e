"""A study: all its designs solved by all cores, its table kept in parts as they are done, taken up where it stopped."""

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict
from hashlib import sha256
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final

import pandas as pd

from codend.io.names import as_name
from codend.plan.plan import Plan, plan_from_dict
from codend.selectivity.escape.species import species_toml
from codend.studies.chunks import Chunk, solve_chunk
from codend.studies.designs import Base, Designs
from codend.studies.parts import part_path, read_parts, remove_others, why_not_whole, write_part
from codend.studies.run_record import program
from codend.studies.study_file import StudyPlan, load_study, study_from_dict
from codend.studies.workers import done_by_workers

ManyProgress = Callable[[int, int, str], None]
"""Told how many runs are done, of how many, and what was done last."""

CASES_IN_A_CHUNK: Final = 100
"""At most: some tenths of a second of solving, which is what a killed study loses."""
CURVE: Final = "catch.sphere_cp_csv"
"""Key that names a file beside the plan."""
LEAST_CHUNKS: Final = 16
"""Where there are as many runs, so that many cores have work."""


def sweep(
    study: str | Path | Mapping[str, Any] | Sequence[Mapping[str, Any] | Plan],
    folder: str | Path | None = None,
    *,
    workers: int = 1,
    scheduler: str | None = None,
    progress: ManyProgress | None = None,
) -> pd.DataFrame:
    """Solve all designs of a study.

    Args:
        study: the path of a study file, its tables, or plans (``Plan`` or tables), each a design.
        folder: where parts of the table are kept as they are done; a study that stopped there goes on.
        workers: processes, each with one thread; 1 works in this one.
        scheduler: address of a Dask scheduler, whose workers solve instead.
        progress: called as parts are done.

    Returns:
        A row a case: ``run``, ``design`` where they have names, what varies, ``results.csv``, L50 and SR of every
        species, and why a case was not solved.

    Raises:
        InputError: the study, a plan or a species cannot be used.
    """
    found = study_of(study)
    if folder is None:
        with TemporaryDirectory() as temporary:
            return read_parts(solve_parts(found, Path(temporary), workers, scheduler, progress))
    return read_parts(solve_parts(found, Path(folder), workers, scheduler, progress))


def study_of(study: str | Path | Mapping[str, Any] | Sequence[Mapping[str, Any] | Plan]) -> StudyPlan:
    """A study however it is given; see ``sweep``."""
    if isinstance(study, str | Path):
        return load_study(study)
    if isinstance(study, Mapping):
        return study_from_dict(study)
    plans = [one if isinstance(one, Plan) else plan_from_dict(one) for one in study]
    bases = (Base(str(number), plan.to_dict(), str(plan.source)) for number, plan in enumerate(plans, start=1))
    return StudyPlan("study", Designs(tuple(bases)), ())


def solve_parts(
    study: StudyPlan,
    folder: Path,
    workers: int = 1,
    scheduler: str | None = None,
    progress: ManyProgress | None = None,
) -> list[Path]:
    """Solve what a folder does not hold whole of these inputs; the files of all parts, in order.

    Parts depend on the study alone, whoever solves them. Those of another study go.
    """
    count = chunk_count(study.designs)
    paths = [part_path(folder, number) for number in range(count)]
    paths[0].parent.mkdir(parents=True, exist_ok=True)
    for half_written in paths[0].parent.glob(".*.part"):
        half_written.unlink()
    remove_others(folder, count)
    inputs = digest_of(study)
    waiting = [number for number, path in enumerate(paths) if why_not_whole(path, inputs) is not None]
    for number in waiting:
        paths[number].unlink(missing_ok=True)
    runs, size = len(study.designs), _chunk_size(study.designs)
    done = sum(len(_numbers(runs, size, i)) for i in set(range(count)) - set(waiting))
    for chunk, table in done_by_workers(solve_chunk, _chunks(study, waiting), min(workers, len(waiting)), scheduler):
        write_part(table, paths[chunk.number], inputs)
        done += len(chunk.runs)
        if progress is not None:
            progress(done, runs, f"run {chunk.runs[-1].number}")
    return paths


def chunk_count(designs: Designs) -> int:
    """In how many parts a study is solved."""
    return -(-len(designs) // _chunk_size(designs))


def _chunk_size(designs: Designs) -> int:
    """Runs of a chunk: decided by the study alone."""
    cases = len(plan_from_dict(designs.bases[0].data, designs.bases[0].source).cases())
    return max(1, min(CASES_IN_A_CHUNK // cases, len(designs) // LEAST_CHUNKS))


def _numbers(runs: int, size: int, chunk: int) -> range:
    return range(1 + chunk * size, 1 + min((chunk + 1) * size, runs))


def _chunks(study: StudyPlan, numbers: Sequence[int]) -> Iterator[Chunk]:
    count, size = len(study.designs), _chunk_size(study.designs)
    named, text = any(base.name for base in study.designs.bases), study.designs.text_keys
    for number in numbers:
        runs = tuple(study.designs.run(i) for i in _numbers(count, size, number))
        yield Chunk(number, runs, study.species, named, text)


def digest_of(study: StudyPlan) -> str:
    """A digest of all that decides a study's table: the program, plans, what varies, species, and files they name."""
    designs = asdict(study.designs)
    curves = [_digests_of_curves(base, study.designs) for base in study.designs.bases]
    species = [species_toml(one) for one in study.species]
    text = json.dumps([program(), designs, curves, species], sort_keys=True, default=str)
    return sha256(text.encode(errors="replace")).hexdigest()


def _digests_of_curves(base: Base, designs: Designs) -> dict[str, str]:
    """Of every file that a plan or what varies names as its curve of pressure; none of a file that is not there."""
    names = {base.data["catch"].get("sphere_cp_csv")}
    for axis in designs.axes:
        if CURVE in axis.keys:
            names |= {point[axis.keys.index(CURVE)] for point in axis.points}
    paths = {name: Path(base.source).parent / as_name(name) for name in names if isinstance(name, str)}
    return {name: sha256(path.read_bytes()).hexdigest() for name, path in paths.items() if path.is_file()}
