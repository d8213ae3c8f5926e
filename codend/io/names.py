"""Names of files as texts and as this system takes them, whatever encoding it believes names to be in."""

import os
from pathlib import Path


def as_text(path: Path) -> str:
    """A path as text: UTF-8 where it is that, also where the system is set to ASCII (``LC_ALL=C``)."""
    return os.fsencode(path).decode(errors="surrogateescape")


def as_name(text: str) -> str:
    """The name of a file that a text in UTF-8 gives: the same bytes, where the system's encoding lacks its letters."""
    try:
        os.fsencode(text)
    except UnicodeEncodeError:
        return os.fsdecode(text.encode(errors="replace"))
    return text
