"""The last few things that were made, for whoever asks for the same once more."""

from collections import OrderedDict
from collections.abc import Callable, Hashable
from threading import local
from typing import Generic, TypeVar

T = TypeVar("T")


class LastMade(local, Generic[T]):
    """What was made last by what it was made of, in every thread its own."""

    def __init__(self, most: int) -> None:
        self._most = most
        self._made: OrderedDict[Hashable, T] = OrderedDict()

    def of(self, key: Hashable, make: Callable[[], T]) -> T:
        """What was made of this, or is made now in the place of what was longest not asked for."""
        if key not in self._made:
            self._made[key] = make()
            if len(self._made) > self._most:
                self._made.popitem(last=False)
        self._made.move_to_end(key)
        return self._made[key]
