"""Time that a solve takes, without what its thread spends on having kernels compiled or read from the cache."""

from threading import get_ident
from time import perf_counter
from types import TracebackType
from typing import Self

from numba.core.event import Event, Listener, register, unregister

COMPILING = "numba:compiler_lock"
"""Event of numba that lasts while it compiles a function or reads one from the cache."""


class Clock(Listener):
    """Runs from where its block is entered.

    with Clock() as clock:
        ...
        clock.ms
    """

    def __enter__(self) -> Self:
        self._thread, self._depth, self._compiling_s = get_ident(), 0, 0.0
        self._started = perf_counter()
        register(COMPILING, self)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        unregister(COMPILING, self)

    @property
    def ms(self) -> float:
        """Milliseconds since the start, those of compiling left out."""
        return 1e3 * (perf_counter() - self._started - self._compiling_s)

    def on_start(self, event: Event) -> None:
        """See ``Listener``."""
        if get_ident() == self._thread:
            if self._depth == 0:
                self._compiling_since = perf_counter()
            self._depth += 1

    def on_end(self, event: Event) -> None:
        """See ``Listener``."""
        if get_ident() == self._thread:
            self._depth -= 1
            if self._depth == 0:
                self._compiling_s += perf_counter() - self._compiling_since
