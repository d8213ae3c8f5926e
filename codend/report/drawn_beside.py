"""Figures drawn by a copy of this process, beside the tables and files that this one writes."""

import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from multiprocessing import get_context
from multiprocessing.connection import Connection
from typing import TYPE_CHECKING

from codend.report.own_look import load_quickly, own_look
from codend.report.style import png
from codend.studies.workers import cores, end_with_parent

if TYPE_CHECKING:
    from collections.abc import Callable

    from matplotlib.figure import Figure


LONGEST_WAIT_S = 30.0
"""For a figure that takes a fraction of a second: a copy that hangs is not waited for."""


def can_draw_beside() -> bool:
    """Whether a copy of the process is safe and of use; elsewhere than on Linux libraries do not bear to be copied."""
    return sys.platform == "linux" and cores() > 1


@contextmanager
def drawn_beside(draw: "Sequence[Callable[[], Figure]]") -> Iterator["Callable[[], bytes | None]"]:
    """Begin to draw figures, where a copy can be made; the block is given what waits for the next one's PNG, in order.

    None stands for one that could not be drawn there, and for all after it. The copy ends with the block, and with
    this process however that ends.
    """
    if not draw or not can_draw_beside():
        yield lambda: None
        return
    context = get_context("fork")
    here, there = context.Pipe(duplex=False)
    copy = context.Process(target=_draw_all, args=(draw, there), daemon=True)
    copy.start()
    there.close()

    def next_one() -> bytes | None:
        try:
            return here.recv_bytes() if here.poll(LONGEST_WAIT_S) else None
        except (EOFError, OSError):
            return None

    try:
        yield next_one
    finally:
        here.close()
        copy.kill()
        copy.join()


def _draw_all(draw: "Sequence[Callable[[], Figure]]", there: Connection) -> None:
    end_with_parent()
    with suppress(Exception):  # the other process draws what does not come, and tells why it cannot
        load_quickly()
        with own_look():
            for figure in draw:
                there.send_bytes(png(figure()))
