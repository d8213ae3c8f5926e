"""Having a kernel compiled, or read from the cache, without running it."""

from typing import Any

from numba import typeof


def compile_kernel(kernel: Any, *arguments: object) -> None:
    """Compile a kernel for the types of these arguments; nothing is done to them."""
    kernel.compile(tuple(typeof(argument) for argument in arguments))
