"""Compiled functions whose cached code is never older than any source it was compiled from.

numba compiles a cached function anew when the file that holds it has changed, not when another file has, from which
it takes functions or constants: after an update in place old code would go on running, and quietly give wrong answers.
"""

import re
import sys
from collections.abc import Callable
from functools import cache
from hashlib import sha256
from typing import Any

from catch_models import kernel_cache

_FROM_IMPORT = re.compile(r"^from +((?:codend|catch_models)[\w.]*) +import +(\([^)]*\)|.*)", re.MULTILINE)
"""The one form of import that the files of this project have at their top."""


def njit(**options: Any) -> Callable[[Callable[..., Any]], Any]:
    """``kernel_cache.njit``, with cached code that is dropped when any file it may come from has changed.

    These are the function's own file and those of this project it imports from, directly or by way of others.
    """

    def compiled(function: Callable[..., Any]) -> Any:
        kernel = kernel_cache.njit(**options)(function)
        kernel_cache.stamp_sources(kernel, digest_of_sources(function.__module__))
        return kernel

    return compiled


@cache
def digest_of_sources(module: str) -> str:
    """A digest of the source of an imported module and of all it imports of this project, in hexadecimal.

    Of a module that is being imported: of what stands at its top, ahead of the first function that asks.
    """
    digest = sha256()
    for name in sorted(modules_behind(module)):
        source, _ = _source_of(name)
        digest.update(f"{name} {len(source)} {source}".encode())
    return digest.hexdigest()


def modules_behind(module: str) -> set[str]:
    """An imported module and all modules of this project that it imports at its top, directly or by way of others."""
    found, left = {module}, [module]
    while left:
        _, imported = _source_of(left.pop())
        left += imported - found
        found |= imported
    return found


@cache
def _source_of(module: str) -> tuple[str, frozenset[str]]:
    """Source of a module, and the modules of this project it imports from; nothing where only its bytecode is there."""
    loader: Any = sys.modules[module].__loader__
    source: str = loader.get_source(module) or ""
    imported = set()
    for package, names in _FROM_IMPORT.findall(source):
        imported |= {package, *(f"{package}.{name}" for name in re.findall(r"\w+", names))}
    return source, frozenset(imported & sys.modules.keys())
