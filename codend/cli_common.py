"""What the commands share: exit statuses, and folders they write into."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NoReturn

from codend.errors import InputError

BAD_INPUT, NOT_CONVERGED, INTERRUPTED = 2, 3, 130
"""Exit statuses; 0 is success."""


def check_writable(folder: Path) -> None:
    """Find out before the work is done whether a folder can be made or written to."""
    there = next(path for path in (folder, *folder.absolute().parents) if path.exists())
    if not there.is_dir():
        _refuse(folder, f"{there} is no folder")
    if not os.access(there, os.W_OK | os.X_OK):
        _refuse(folder, "permission denied")


@contextmanager
def written_into(folder: Path) -> Iterator[None]:
    """Make a folder for the block to write to; one that cannot be written is an input error."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        yield
    except OSError as error:
        _refuse(folder, error.strerror or str(error))


def _refuse(folder: Path, reason: str) -> NoReturn:
    raise InputError(folder, "", None, "a folder that can be written", f"cannot be written: {reason}") from None
