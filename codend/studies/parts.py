"""Parts of a study's table as Parquet files: each there whole or not at all, and known by what it was made of."""

import re
from collections.abc import Sequence
from hashlib import sha256
from pathlib import Path
from typing import Final

import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq

from codend.io.columns import REASON
from codend.io.files import table_text, whole_file

FOLDER: Final = "parts"
_INPUTS: Final = b"codend_inputs"
_CONTENT: Final = b"codend_content"
_PART = re.compile(r"part-\d{6}\.parquet")


def part_path(folder: Path, number: int) -> Path:
    """Where the part of a number, from 0, lies in the folder of a study."""
    return folder / FOLDER / f"part-{number:06d}.parquet"


def write_part(table: pa.Table, path: Path, inputs: str) -> None:
    """Write a part; ``inputs`` is a digest of all that decides its numbers."""
    told = {_INPUTS: inputs.encode(), _CONTENT: _content(table)}
    with whole_file(path) as temporary:
        pq.write_table(table.replace_schema_metadata(told), temporary, write_page_checksum=True)


def why_not_whole(path: Path, inputs: str) -> str | None:
    """Why a part is to be solved; None where it is whole and of these inputs."""
    if not path.is_file():
        return "it is missing"
    try:
        found = _read(path)
    except (OSError, pa.ArrowException):
        return "it is not as it was written"
    told = found.schema.metadata or {}
    if told.get(_CONTENT) != _content(found):
        return "it is not as it was written"
    return None if told.get(_INPUTS) == inputs.encode() else "it is of other inputs"


def remove_others(folder: Path, count: int) -> None:
    """Remove parts beyond so many, which another study left."""
    kept = {part_path(folder, number).name for number in range(count)}
    for path in (folder / FOLDER).iterdir():
        if _PART.fullmatch(path.name) and path.name not in kept:
            path.unlink()


def read_parts(paths: Sequence[Path]) -> pd.DataFrame:
    """The rows of all parts, in order."""
    found = pa.concat_tables([_read(path) for path in paths], promote_options="permissive")
    return _ordered(found.to_pandas())


def write_csv(paths: Sequence[Path], path: Path) -> None:
    """Write the rows of all parts as one CSV table, a part in memory at a time."""
    schema = pa.unify_schemas([pq.read_schema(one) for one in paths], promote_options="permissive")
    names = list(_ordered(pd.DataFrame(columns=schema.names)).columns)
    with whole_file(path) as temporary, temporary.open("wb") as file:
        for number, one in enumerate(paths):
            text = table_text(read_parts([one]).reindex(columns=names))
            file.write((text if number == 0 else text.partition("\n")[2]).encode(errors="replace"))


def _read(path: Path) -> pa.Table:
    return pq.read_table(path, page_checksum_verification=True, partitioning=None)


def _content(table: pa.Table) -> bytes:
    """A digest of the columns' names and values."""
    return sha256(repr(table.to_pydict()).encode(errors="replace")).hexdigest().encode()


def _ordered(table: pd.DataFrame) -> pd.DataFrame:
    """With the reason last, also where columns came with later parts."""
    return table[[name for name in table.columns if name != REASON] + [REASON]]
