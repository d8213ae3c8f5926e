"""The last few things that were made, for whoever asks for the same once more."""

from collections import OrderedDict
from collections.abc import Callable, Hashable
from threading import local
from typing import Generic, TypeVar

T = TypeVar("T")


class LastMade(local, Generic[T]):
    """What was made last by what it was made of, in every thread its own, as much as is no larger than ``most``."""

    def __init__(self, most: int) -> None:
        self._most, self._held = most, 0
        self._made: OrderedDict[Hashable, tuple[int, T]] = OrderedDict()

    def of(self, key: Hashable, size: int, make: Callable[[], T]) -> T:
        """What was made of this, or is made now, in the place of what was longest not asked for."""
        kept = self._made.get(key)
        if kept is not None:
            self._made.move_to_end(key)
            return kept[1]
        made = make()
        if size <= self._most:
            self._made[key] = size, made
            self._held += size
        while self._held > self._most:
            self._held -= self._made.popitem(last=False)[1][0]
        return made
