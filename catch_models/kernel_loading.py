"""Compiled kernels read from their cache without what only compiling needs.

Before numba reads a kernel it makes ready to compile (implementations of all numpy functions are imported and
registered), and it parses beside the machine code the bitcode by which other kernels take this one over: two thirds of
the time that a command spends on reading kernels. Here both wait until something is compiled. Where numba's inner parts
are not as they are known here, it reads kernels in its own way.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, Final, Self

from llvmlite import binding as llvm
from numba.core import environment
from numba.core.codegen import JITCodeLibrary
from numba.core.runtime import rtsys

_ENTRY: Final = "_ZN7cpython"
"""How the name of the function begins by which Python calls a kernel."""
_NEEDS_MORE: Final = b"_numba_hashsecret"
"""In the machine code of what hashes, which needs symbols that come with the implementations."""

_REBUILT_BY_NUMBA: Final = environment._rebuild_env


class _LaterLinked(JITCodeLibrary):
    """Machine code whose bitcode is parsed when another kernel first takes it over."""

    _bitcode: bytes | None = None
    _module: Any = None

    @classmethod
    def _unserialize(cls, codegen: Any, state: Any) -> Self:
        name, kind, data = state
        if kind != "object" or _NEEDS_MORE in data[0]:
            raise UnknownFormError
        try:
            library = codegen.create_library(name)
            library.enable_object_caching()
            library._set_compiled_object(data[0])
            library._bitcode = data[1]
            library._finalize_final_module()
        except (AttributeError, TypeError) as error:
            raise UnknownFormError from error
        return library

    @property
    def _shared_module(self) -> Any:
        if self._bitcode is not None:
            self._module, self._bitcode = llvm.parse_bitcode(self._bitcode), None
            self._codegen._engine._load_defined_symbols(self._module)
        return self._module

    @_shared_module.setter
    def _shared_module(self, module: Any) -> None:
        self._module = module

    def get_pointer_to_function(self, name: str) -> int:
        """Address of a function, 0 of one that is not there; numba asks the bitcode whether it is."""
        if self._bitcode is not None and name.startswith(_ENTRY):
            return self._codegen._engine.get_function_address(name)
        _ = self._shared_module
        return super().get_pointer_to_function(name)


def _rebuilt(module: str, constants: Any, name: str) -> Any:
    """What a function refers to as it runs; of numba's own, which use no globals then, without importing its module."""
    if not module.startswith("numba."):
        return _REBUILT_BY_NUMBA(module, constants, name)
    if (found := environment.lookup_environment(name)) is None:
        found = environment.Environment({"__name__": module})
        found.consts[:] = constants
        found.env_name = name
        environment.Environment._memo[name] = found
    return found


class UnknownFormError(Exception):
    """A kernel is to be read in numba's own way."""


@contextmanager
def quick_loading(target_context: Any) -> Iterator[None]:
    """Kernels that the block reads are made ready to run, and not to be taken over by others.

    Args:
        target_context: numba's, of this processor; its lock of compilation is held, as whenever it reads kernels.

    Raises:
        UnknownFormError: numba is not as it is known here, or a kernel is not.
    """
    codegen = target_context.codegen()
    if codegen._library_class is not JITCodeLibrary:
        raise UnknownFormError
    rtsys.initialize(target_context)  # numba's memory, which kernels call as they run
    codegen._library_class, environment._rebuild_env = _LaterLinked, _rebuilt
    try:
        yield
    finally:
        codegen._library_class, environment._rebuild_env = JITCodeLibrary, _REBUILT_BY_NUMBA
