"""Errors a user can mend: a file, a key in it, the value found and what is allowed there; a net too large."""

from collections.abc import Mapping, Sequence
from datetime import date, time
from pathlib import Path
from typing import Final

OPTIONS: Final = "options"
"""In the place of the file where what is wrong was asked for on the command line or in a call."""
_LONGEST_VALUE = 60
_MOST_LINES = 30


class InputError(Exception):
    """Something the user wrote cannot be used; ``str()`` is one line that says where, what and what is allowed.

    ``InputError("p.toml", "tow.speed_m_s", -1, "a number above 0")`` reads
    ``p.toml: tow.speed_m_s = -1 is not allowed; allowed: a number above 0``.
    """

    def __init__(
        self,
        file: str | Path,
        key: str,
        value: object,
        allowed: str,
        problem: str = "is not allowed",
    ) -> None:
        """Hold the four parts of the message.

        Args:
            file: the file the error is in, or ``OPTIONS``.
            key: dotted key or column, as the user would write it; "" when the whole file is at fault.
            value: what was found; None when nothing was, and then it is not shown.
            allowed: what would have been accepted.
            problem: what is wrong, as the words between value and ``allowed``.
        """
        super().__init__(file, key, value, allowed, problem)
        self.file = str(file)
        self.key = key
        self.value = value
        self.allowed = allowed
        self.problem = problem
        self.others: tuple[InputError, ...] = ()
        """What else is wrong in the same file."""

    @property
    def lines(self) -> list[str]:
        """A line for each mistake, or for the first of very many."""
        told = [str(one) for one in (self, *self.others)]
        more = len(told) - _MOST_LINES
        return told if more <= 0 else [*told[:_MOST_LINES], f"{self.file}: and {more} more mistakes"]

    def __str__(self) -> str:
        found = self.key if self.value is None else f"{self.key} = {_shown(self.value)}"
        return _one_line(f"{self.file}: {found} {self.problem}; allowed: {self.allowed}")


class TooLittleMemory(MemoryError):
    """A net that does not fit into memory; ``str()`` says how large it is and which would fit."""


def all_at_once(found: Sequence[InputError]) -> InputError:
    """The first of some mistakes, with the others beside it."""
    first, *others = found
    first.others = tuple(others)
    first.__notes__ = list(map(str, others))  # tracebacks in Python show them too
    return first


def _shown(value: object) -> str:
    """The value as TOML would spell it, shortened."""
    try:
        return _shortened(_as_toml(value))
    except (ValueError, RecursionError):  # whole numbers too long to print, arrays nested too deep
        return f"a {type(value).__name__} too long to show"


def _as_toml(value: object) -> str:
    match value:
        case bool():
            return str(value).lower()
        case str():
            return f'"{value}"'
        case list() | tuple():
            return f"[{', '.join(map(_as_toml, value))}]"
        case Mapping():
            return f"{{{', '.join(f'{key} = {_as_toml(item)}' for key, item in value.items())}}}"
        case date() | time():
            return value.isoformat()
    return repr(value)


def _shortened(text: str) -> str:
    return text if len(text) <= _LONGEST_VALUE else f"{text[: _LONGEST_VALUE - 3]}..."


def _one_line(text: str) -> str:
    """Fold all white space to single blanks; control characters, which could rewrite a terminal, become "?"."""
    return "".join(char if char.isprintable() else "?" for char in " ".join(text.split()))
