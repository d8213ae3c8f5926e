"""A folder that one command has for itself while it works in it."""

import re
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Final

from codend.errors import InputError

LOCK: Final = ".codend.lock"
"""Locked by the process that works in the folder; the lock ends with that process, however it ends."""
_PART = re.compile(r"\..+\.\d+\.part")


@contextmanager
def owned(folder: Path) -> Iterator[None]:
    """Have a folder for the block alone: made where it is missing, and removed again if nothing came into it.

    Half-written files that a killed process left are removed.

    Raises:
        InputError: another process works in it.
        OSError: it cannot be made or written to.
    """
    from filelock import FileLock, Timeout

    made = [path for path in (folder, *folder.absolute().parents) if not path.exists()]
    folder.mkdir(parents=True, exist_ok=True)
    lock = FileLock(folder / LOCK, timeout=0)
    try:
        lock.acquire()
    except Timeout:
        allowed = "a folder that no other run of codend works in; it is free once that has ended"
        raise InputError(folder, "", None, allowed, "is in use by another run of codend") from None
    try:
        for part in (*folder.glob(".*.part"), *(folder / "plots").glob(".*.part")):
            if _PART.fullmatch(part.name):
                part.unlink(missing_ok=True)
        yield
    finally:
        with suppress(OSError):  # an open file cannot be removed everywhere; it does no harm
            (folder / LOCK).unlink(missing_ok=True)
        lock.release()
        with suppress(OSError):  # the first that is not empty
            for path in made:
                path.rmdir()
