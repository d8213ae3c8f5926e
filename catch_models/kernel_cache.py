"""Compiled functions whose cache can stop no program: damaged files are dropped, and what cannot be kept is not.

numba ends with whatever unpickling half a file raises, runs machine code with flipped bits as it is, and refuses to
start where it finds no folder to write to. Here every file of the cache ends in a digest of the rest, and is read only
where that holds.
"""

import atexit
import glob
import logging
import os
import pickle
import shutil
import stat
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from hashlib import sha256
from io import BytesIO
from pathlib import Path
from typing import Any, Final

import numba
from numba.core.caching import FunctionCache, IndexDataCacheFile, NullCache

from catch_models.kernel_loading import UnknownFormError, quick_loading

say = logging.getLogger("codend").warning
"""One line on standard error, where the user has not arranged for logging otherwise."""
_FORMAT: Final = f"{numba.__version__}, with digests"
_DIGEST_BYTES: Final = sha256().digest_size


class DamagedFileError(Exception):
    """A file of the cache is not as it was written."""


def njit(**options: Any) -> Callable[[Callable[..., Any]], Any]:
    """``numba.njit``, compiled whatever ``NUMBA_DISABLE_JIT`` says, with a cache that stops no program."""
    kept = options.pop("cache", False)

    def compiled(function: Callable[..., Any]) -> Any:
        with _compiling():
            kernel = numba.njit(**options)(function)
        if kept:
            kernel._cache = _cache_for(function)
        return kernel

    return compiled


def stamp_sources(kernel: Any, digest: str) -> None:
    """Make a kernel's cached code hold only for sources of this digest, beside numba's stamp of its own file."""
    if isinstance(kernel._cache, _Cache):
        files = kernel._cache._cache_file
        files._source_stamp = (files._source_stamp, digest)


def remove_damaged(folder: Path) -> list[Path]:
    """Remove damaged files of the cache from one of its folders; those that went. Other versions' files stay.

    Raises:
        OSError: one cannot be read or removed.
    """
    gone = []
    for index in sorted(folder.glob("*.nbi")):
        if _is_of_another_version(index.read_bytes()):
            continue
        for path in (index, *sorted(folder.glob(f"{glob.escape(index.stem)}.*.nbc"))):
            if not _ends_in_digest(path.read_bytes()):
                path.unlink()
                gone.append(path)
    return gone


def _ends_in_digest(content: bytes) -> bool:
    return sha256(content[:-_DIGEST_BYTES]).digest() == content[-_DIGEST_BYTES:]


def _is_of_another_version(index: bytes) -> bool:
    try:
        version = pickle.loads(index)
    except Exception:  # unpickling what is damaged may raise anything
        return False
    return isinstance(version, str) and version != _FORMAT


class _Files(IndexDataCacheFile):
    """Index and data files of one function, each closed by a digest."""

    def __init__(self, cache_path: str, filename_base: str, source_stamp: object) -> None:
        super().__init__(cache_path, filename_base, source_stamp)
        self._version = _FORMAT

    def drop(self) -> None:
        """Remove the index; functions that are in none are written over in time."""
        Path(self._index_path).unlink(missing_ok=True)

    def _load_index(self) -> Any:
        self._check(self._index_path)
        return super()._load_index()

    def _load_data(self, name: str) -> Any:
        self._check(self._data_path(name))
        return super()._load_data(name)

    def _check(self, name: str) -> None:
        path = Path(name)
        content = path.read_bytes() if path.exists() else b""
        if path.exists() and not _ends_in_digest(content) and not _is_of_another_version(content):
            raise DamagedFileError

    @contextmanager
    def _open_for_write(self, filepath: str) -> Iterator[Any]:
        content = BytesIO()
        yield content
        with super()._open_for_write(filepath) as file:
            file.write(content.getvalue())
            file.write(sha256(content.getvalue()).digest())


class _Cache(FunctionCache):
    """The cache of one function: what cannot be read is compiled anew, what cannot be written is done without."""

    def __init__(self, function: Callable[..., Any]) -> None:
        super().__init__(function)
        files = self._cache_file
        self._cache_file = _Files(files._cache_path, self._impl.filename_base, files._source_stamp)

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        try:
            with suppress(UnknownFormError), quick_loading(target_context), self._guard_against_spurious_io_errors():
                return self._load_overload(sig, target_context)
            return super().load_overload(sig, target_context)
        except MemoryError:
            raise
        except Exception:  # damaged, unreadable, or of classes that are no longer there
            say_once("codend: damaged or unreadable files of compiled kernels were dropped; they are compiled anew")
            self._drop()
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        try:
            super().save_overload(sig, data)
        except (OSError, DamagedFileError, EOFError, pickle.UnpicklingError) as error:
            reason = error.strerror if isinstance(error, OSError) else "damaged files"
            say_once(f"codend: compiled kernels cannot be kept in {self._cache_path}: {reason}")

    def _drop(self) -> None:
        try:
            self._cache_file.drop()
        except OSError as error:
            say_once(f"codend: a damaged file cannot be removed from {self._cache_path}: {error.strerror}")


@cache
def say_once(line: str) -> None:
    """Say a line the first time it is to be said."""
    say(line)


@contextmanager
def _compiling() -> Iterator[None]:
    """Have numba compile even where it is told not to: interpreted, a net takes hours."""
    asked = numba.config.DISABLE_JIT  # type: ignore[attr-defined] # set at run time
    if asked:
        say_once("codend: NUMBA_DISABLE_JIT is set aside: without compiled kernels a net would take hours")
    numba.config.DISABLE_JIT = 0  # type: ignore[attr-defined]
    try:
        yield
    finally:
        numba.config.DISABLE_JIT = asked  # type: ignore[attr-defined]


def _cache_for(function: Callable[..., Any]) -> Any:
    """Where numba keeps this function, or else in a temporary folder, or else nowhere."""
    try:
        return _Cache(function)
    except RuntimeError:  # no folder that numba knows can be written
        folder = temporary_folder()
    asked = numba.config.CACHE_DIR  # type: ignore[attr-defined] # set at run time
    if folder is None:
        say_once("codend: no folder can be written to keep compiled kernels in: every run compiles them anew")
        return NullCache()
    say_once(f"codend: no cache folder can be written (NUMBA_CACHE_DIR may name one); compiled kernels are in {folder}")
    numba.config.CACHE_DIR = str(folder)  # type: ignore[attr-defined]
    try:
        return _Cache(function)
    except RuntimeError:
        return NullCache()
    finally:
        numba.config.CACHE_DIR = asked  # type: ignore[attr-defined]


@cache
def temporary_folder() -> Path | None:
    """A folder of this user alone among the system's temporary files; None where those cannot be written.

    Compiled code is run as it is found, so that a folder another user could write to is not taken.
    """
    try:
        own = Path(tempfile.gettempdir()) / f"codend-{os.getuid() if hasattr(os, 'getuid') else 'cache'}"
        own.mkdir(mode=0o700, exist_ok=True)
        found = own.lstat()
        foreign = hasattr(os, "getuid") and (found.st_uid != os.getuid() or found.st_mode & 0o022)
        if stat.S_ISDIR(found.st_mode) and not foreign and os.access(own, os.W_OK | os.X_OK):
            return own
        own = Path(tempfile.mkdtemp(prefix="codend-"))
    except OSError:
        return None
    atexit.register(shutil.rmtree, own, ignore_errors=True)
    return own
