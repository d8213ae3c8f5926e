"""Text files that users write: read, or refused in one line that says what the file is.

Text is UTF-8, or UTF-16 or UTF-32 with the byte order mark that tells them. Any other encoding is asked for: which
letters its bytes stand for cannot be seen in the file.
"""

import codecs
from pathlib import Path
from typing import Final

from codend.errors import OPTIONS, InputError

MOST_MB: Final = 20
"""Far more than anyone types: half a million rows of counted fish."""
ENCODING: Final = "the file saved as UTF-8"
ENCODING_OPTION: Final = "the file saved as UTF-8, or --encoding with the name of its own, such as --encoding latin-1"

_MARKS: Final = (
    (codecs.BOM_UTF8, "utf-8"),
    (codecs.BOM_UTF32_LE, "utf-32"),  # before UTF-16, whose mark it begins with
    (codecs.BOM_UTF32_BE, "utf-32"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
)
_NO_TEXTS: Final = (
    (b"PK\x03\x04", "a spreadsheet (.xlsx or .ods) or another zip archive"),
    (b"\xd0\xcf\x11\xe0", "a spreadsheet or document of old Office (.xls, .doc)"),
    (b"%PDF", "a PDF"),
    (b"{\\rtf", "a document in rich text (.rtf)"),
    (b"\x1f\x8b", "packed by gzip"),
    (b"<!DOCTYPE html", "a web page (HTML)"),
    (b"<html", "a web page (HTML)"),
)


def read_text(
    path: str | Path, kind: str, *, encoding: str | None = None, allowed: str = ENCODING, most_mb: float = MOST_MB
) -> str:
    """The text of a file, without a byte order mark, all line ends alike.

    Args:
        path: of the file.
        kind: what it is to be, for messages, such as "CSV table".
        encoding: of a file without a byte order mark; None: UTF-8.
        allowed: what is asked for where the encoding is unsure.
        most_mb: size from which the file is refused, unread.

    Raises:
        InputError: no such file, too large, no text, or in another encoding.
    """
    _check_encoding(encoding)
    most = int(1e6 * most_mb)
    try:
        with Path(path).open("rb") as file:
            content = file.read(most + 1)
    except OSError as error:
        raise InputError(path, "", None, f"the path of a {kind}", f"cannot be read: {error.strerror}") from None
    except ValueError as error:  # a null character in the path
        raise InputError(path, "", None, f"the path of a {kind}", f"cannot be read: {error}") from None
    if len(content) > most:
        raise InputError(path, "", None, f"a {kind} of at most {most_mb:g} MB", "is too large to be read")
    for start, what in _NO_TEXTS:
        if content.lower().startswith(start.lower()):
            raise InputError(path, "", None, f"a {kind}, which is plain text", f"cannot be read: it is {what}")
    used = next((name for mark, name in _MARKS if content.startswith(mark)), encoding or "utf-8")
    if used == "utf-8":
        content = content.removeprefix(codecs.BOM_UTF8)
    try:
        text = content.decode(used)
    except UnicodeError as error:
        what = _what_it_is(content, used, getattr(error, "start", 0))
        raise InputError(path, "", None, allowed, f"cannot be read: {what}") from None
    if "\0" in text:
        where = "UTF-16 without a byte order mark, or no text at all"
        raise InputError(path, "", None, allowed, f"cannot be read: it holds null characters, as {where}")
    return text.replace("\r\n", "\n").replace("\r", "\n")


def _what_it_is(content: bytes, encoding: str, start: int) -> str:
    if b"\0" in content and encoding == "utf-8":
        return "it is not UTF-8 but UTF-16 without a byte order mark, or no text at all"
    line = content[:start].count(b"\n") + 1
    found = content[start : start + 1]
    where = f"byte {found.hex()} in line {line}"
    if encoding != "utf-8":
        return f"it is not {encoding.upper()}, from {where} on"
    letter = found.decode("cp1252", errors="replace")
    return f"it is not UTF-8 but probably Latin-1 (Windows-1252), in which {where} is {letter}"


def _check_encoding(encoding: str | None) -> None:
    if encoding is None:
        return
    try:
        "".encode(encoding)
    except (LookupError, ValueError):
        allowed = "the name of an encoding of text, such as utf-8, utf-16, latin-1 or cp1252"
        raise InputError(OPTIONS, "encoding", encoding, allowed) from None
