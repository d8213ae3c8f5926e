"""matplotlib as it is shipped: what the user's matplotlibrc, backend and home are reaches no plot, and stops none."""

import importlib.util
import os
import sys
from collections.abc import Iterator
from contextlib import chdir, contextmanager, nullcontext
from pathlib import Path

from catch_models.kernel_cache import temporary_folder

_OF_THE_USER = ("backend", "backend_fallback", "interactive", "toolbar")
"""Settings that no plot depends on here, and that would load a window system."""


@contextmanager
def own_look() -> Iterator[None]:
    """Draw the block's figures with matplotlib's own settings; those of the user are back afterwards."""
    _import_matplotlib()
    import matplotlib

    shipped = {key: value for key, value in matplotlib.rcParamsDefault.items() if key not in _OF_THE_USER}
    with matplotlib.rc_context(shipped):
        yield


def load_quickly() -> None:
    """Import what figures need without lists of properties in docstrings, which take longer to write than a figure.

    For a program that ends with its figures, where nobody reads them.
    """
    _import_matplotlib()
    from matplotlib import artist

    written, artist.kwdoc = artist.kwdoc, lambda artist: ""
    try:
        import matplotlib.backends.backend_agg
        import matplotlib.figure  # noqa: F401 is what is loaded
    finally:
        artist.kwdoc = written


def _import_matplotlib() -> None:
    """Import it without the user's settings: a backend or a file it cannot read ends the import."""
    if "matplotlib" in sys.modules:
        return
    spec = importlib.util.find_spec("matplotlib")
    assert spec is not None
    assert spec.origin is not None
    shipped = Path(spec.origin).parent / "mpl-data"
    settings = {"MPLBACKEND": "agg", "MATPLOTLIBRC": str(shipped / "matplotlibrc")}
    if "MPLCONFIGDIR" not in os.environ and not _has_home() and (folder := temporary_folder()) is not None:
        os.environ["MPLCONFIGDIR"] = str(folder / "matplotlib")  # its list of fonts is kept for the next run
    # a matplotlibrc in the working folder comes before the one named
    aside = chdir(shipped) if os.path.exists("matplotlibrc") else nullcontext()
    asked = {name: os.environ.get(name) for name in settings}
    os.environ.update(settings)
    try:
        with aside:
            import matplotlib as _  # noqa: F401
    finally:
        for name, value in asked.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


def _has_home() -> bool:
    """Whether matplotlib finds a folder of the user's to keep its list of fonts in."""
    try:
        home = Path(os.environ.get("XDG_CACHE_HOME") or Path.home())
    except RuntimeError:
        return False
    return home.is_dir() and os.access(home, os.W_OK | os.X_OK)
