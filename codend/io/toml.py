"""TOML files that users write: read, or refused with the line at fault and what is probably meant."""

import re
import tomllib
from pathlib import Path
from typing import Any, Final

from codend.errors import InputError
from codend.io.text import read_text

MOST_MB: Final = 1
"""A plan of ten thousand catches is a tenth of that."""
_DECIMAL_COMMA: Final = re.compile(r"=\s*([+-]?\d+),(\d+)\s*(?:#.*)?$")


def read_toml(path: str | Path, kind: str) -> dict[str, Any]:
    """The tables of a TOML file.

    Args:
        path: of the file.
        kind: what it is to be, for messages, such as "TOML plan".

    Raises:
        InputError: as in ``read_text``, or the text is not TOML.
    """
    text = read_text(path, kind, most_mb=MOST_MB)
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise InputError(path, "", None, f"a {kind}", "cannot be read: arrays or tables nested too deep") from None
    except ValueError as error:
        lines = text.splitlines()
        problem = str(error).replace("at end of document", f"at line {len(lines)}, the end")
        raise InputError(path, "", None, f"a {kind}", f"is not TOML: {problem}{_hint(problem, lines)}") from None


def _hint(problem: str, lines: list[str]) -> str:
    """What the line at fault probably has, if it is one of the usual slips."""
    at = re.search(r"line (\d+)", problem)
    line = lines[int(at[1]) - 1] if at and 0 < int(at[1]) <= len(lines) else ""
    if comma := _DECIMAL_COMMA.search(line):
        return f": a decimal comma, where TOML has a point ({comma[1]}.{comma[2]})"
    if quotes := re.search("[“”„«»‘’]", line):
        return f': a typographic quotation mark {quotes[0]}, where TOML has "'
    return ""
