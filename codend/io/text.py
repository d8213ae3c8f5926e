"""Text files that users write: read, or refused with the reason in one line."""

from pathlib import Path

from codend.errors import InputError


def read_text(path: str | Path, kind: str) -> str:
    """The text of a file in UTF-8, with or without a byte order mark.

    Args:
        path: of the file.
        kind: what it is to be, for messages, such as "CSV table".

    Raises:
        InputError: no such file, or not UTF-8.
    """
    try:
        return Path(path).read_text(encoding="utf-8-sig")
    except OSError as error:
        raise InputError(path, "", None, f"the path of a {kind}", f"cannot be read: {error.strerror}") from None
    except ValueError as error:  # bytes that are not UTF-8, a null character in the path
        raise InputError(path, "", None, f"a {kind} in UTF-8", f"cannot be read: {error}") from None
