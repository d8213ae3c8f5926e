"""What commands show in a terminal: plain tables, and the progress of long work."""

import math
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from textwrap import wrap
from time import monotonic

from codend.cli.streams import say

ShownProgress = Callable[[int, int, str], None]
"""Told how many parts are done, of how many, and what is being done."""

SECONDS_BETWEEN_LINES, SECONDS_BETWEEN_DRAWINGS = 10.0, 0.1

WIDTH = 80
"""Columns of letters that a table keeps within, unless one of its own columns is wider."""


def text_table(headers: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """Columns of text, numbers to four digits and to the right; what is not known is a dash.

    Headings are broken between words, and a table wider than ``WIDTH`` goes on below, its first column repeated.
    """
    values = [list(row) for row in rows]
    columns = [_Column(header, [row[c] for row in values]) for c, header in enumerate(headers)]
    blocks, first = [columns[:1]], columns[0].width
    for column in columns[1:]:
        if len(blocks[-1]) > 1 and sum(one.width + 2 for one in blocks[-1]) + column.width > max(WIDTH, first):
            blocks.append(columns[:1])
        blocks[-1] = [*blocks[-1], column]
    return "\n\n".join(_block(block) for block in blocks)


class _Column:
    """A column of a table: its heading in lines, and its cells."""

    def __init__(self, header: str, values: Sequence[object]) -> None:
        self.right = all(isinstance(value, int | float) and not isinstance(value, bool) for value in values)
        self.cells = [_shown(value) for value in values]
        widest = max(map(len, [*self.cells, *header.split()]), default=0)
        self.head = wrap(header, widest) or [""]
        self.width = max(map(len, [*self.cells, *self.head]))

    def line(self, text: str) -> str:
        """A text as wide as the column."""
        return text.rjust(self.width) if self.right else text.ljust(self.width)


def _block(columns: Sequence[_Column]) -> str:
    high = max(len(column.head) for column in columns)
    heads = [[""] * (high - len(column.head)) + column.head for column in columns]
    lines = [*zip(*heads, strict=True), *zip(*(column.cells for column in columns), strict=True)]
    padded = (
        "  ".join(column.line(text) for column, text in zip(columns, line, strict=True)).rstrip() for line in lines
    )
    return "\n".join(padded)


def _shown(value: object) -> str:
    if isinstance(value, bool):
        return "yes" if value else "NO"
    if isinstance(value, float):
        return "-" if math.isnan(value) else f"{value:.1e}" if 0.0 < abs(value) < 1e-4 else f"{value:.4g}"
    return str(value)


@contextmanager
def shown_progress() -> Iterator[ShownProgress]:
    """A bar on standard error where that is a terminal, otherwise a line there every ten seconds."""
    if sys.stderr is None or not sys.stderr.isatty():
        yield _progress_lines()
        return
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TaskProgressColumn,
        TextColumn,
        TimeRemainingColumn,
    )

    left = (TaskProgressColumn(), MofNCompleteColumn(), TimeRemainingColumn(), TextColumn("left"))
    columns = (BarColumn(bar_width=20), *left, TextColumn("{task.description}", markup=False))
    # drawn as it is told, by no thread of its own: workers are copies of processes without any
    with Progress(*columns, console=Console(stderr=True), transient=True, auto_refresh=False) as bar:
        task, drawn = bar.add_task("starting", total=None), monotonic()
        bar.refresh()

        def report(done: int, total: int, doing: str) -> None:
            nonlocal drawn
            if bar.tasks[0].total not in (None, total):
                bar.reset(task, total=total)
            bar.update(task, completed=done, total=total, description=doing)
            if monotonic() - drawn > SECONDS_BETWEEN_DRAWINGS:
                bar.refresh()
                drawn = monotonic()

        yield report


def _progress_lines() -> ShownProgress:
    begun = last = monotonic()
    parts = 0

    def report(done: int, total: int, doing: str) -> None:
        nonlocal begun, last, parts
        now = monotonic()
        # other work has parts of another length
        begun, parts = now if parts not in (0, total) else begun, total
        if now - last > SECONDS_BETWEEN_LINES:
            last = now
            share = (
                f" ({done / total:.0%}, {(now - begun) * (total - done) / done:.0f} s left)" if done and total else ""
            )
            say(f"{done} of {total} done{share}, {doing}")

    return report
