"""What is installed, what the program meets on this machine, and compilation of its kernels ahead of the first solve.

Every check stands alone: one that fails says so, and the others are made all the same.
"""

import os
import platform
import shutil
import sys
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from time import perf_counter
from typing import Any

REQUIRED = (
    "numpy",
    "scipy",
    "numba",
    "pandas",
    "threadpoolctl",
    "pyarrow",
    "matplotlib",
    "meshio",
    "pillow",
    "pydantic",
    "click",
    "rich",
    "jinja2",
    "filelock",
    "formulaic",
)
FOR_TESTS = (
    "pytest",
    "pytest-xdist",
    "hypothesis",
    "openpyxl",
    "statsmodels",
    "ipctk",
    "mkdocs",
    "pypdf",
    "ruff",
    "mypy",
    "import-linter",
    "pandas-stubs",
    "scipy-stubs",
    "hatchling",
)
ENOUGH_MB = 100.0
"""Free space below which a study of full nets may not fit."""
FAST = ("py-mkl-pardiso",)

_WARM_UP_PLAN = {
    "title": "Warm-up",
    "tow": {"speed_m_s": 1.0, "water_density_kg_m3": 1000.0},
    "entry": {"radius_m": 0.05},
    "netting": [{"mesh": "diamond", "meshes_round": 12, "meshes_long": 10, "bar_mm": 40.0, "twine_mm": 2.0}],
    "catch": {"filled_meshes": 4},
}


def version_of(package: str) -> str | None:
    """Version of an installed package, None where it is not installed."""
    try:
        return version(package)
    except PackageNotFoundError:
        return None


@dataclass(frozen=True)
class Finding:
    """A thing looked at and what was found."""

    topic: str
    found: str
    missing: bool = False
    """Whether the project cannot do without it."""


def examine() -> list[Finding]:
    """Versions, what this machine offers, and the state of the compiled kernels' cache, whose damaged files go."""
    findings = _looked_at("codend", _program)
    findings += [Finding("python", f"{platform.python_version()}, {platform.system()} {platform.machine()}")]
    findings += [_package(name, "MISSING", needed=True) for name in REQUIRED]
    findings += [_package(name, "not installed (only tests need it)", needed=False) for name in FOR_TESTS]
    findings += [_package(name, "not installed (SuperLU does its work, slower)", needed=False) for name in FAST]
    findings.append(Finding("cores", f"{_usable_cores()} usable of {os.cpu_count()}"))
    for topic, check in (
        ("home", _home),
        ("temporary files", _temporary),
        ("working folder", _working_folder),
        ("encodings", _encodings),
    ):
        findings += _looked_at(topic, check)
    if any(finding.missing for finding in findings):
        return findings
    for topic, check in (("plots", _plots), ("numba", _numba), ("kernel cache", _compiled_kernels)):
        findings += _looked_at(topic, check)
    return findings


def _looked_at(topic: str, check: Callable[[], list[Finding]]) -> list[Finding]:
    try:
        return check()
    except Exception as error:  # a diagnosis that dies of what it is to find is none
        return [Finding(topic, f"FAILS: {type(error).__name__}: {' '.join(str(error).split())}", missing=True)]


def _program() -> list[Finding]:
    found = version_of("codend") or "not installed, run from its source"
    return [Finding("codend", f"{found}, in {Path(__file__).parents[1]}")]


def _home() -> list[Finding]:
    try:
        home = Path.home()
    except RuntimeError:
        return [Finding("home", "none; kernels and fonts are cached among the temporary files")]
    state = "" if os.access(home, os.W_OK) else ", which cannot be written; temporary files stand in for it"
    return [Finding("home", f"{home}{state}")]


def _temporary() -> list[Finding]:
    try:
        return [_space("temporary files", tempfile.gettempdir())]
    except FileNotFoundError:
        return [Finding("temporary files", "no folder for them can be written (TMPDIR may name one)")]


def _working_folder() -> list[Finding]:
    state = "" if os.access(".", os.W_OK) else ", cannot be written"
    try:
        found = _space("working folder", os.getcwd())
    except FileNotFoundError:
        return [Finding("working folder", "is gone: it was removed")]
    return [Finding(found.topic, f"{found.found}{state}")]


def _space(topic: str, folder: str) -> Finding:
    free_mb = shutil.disk_usage(folder).free / 1e6
    little = ", too little for a run" if free_mb < ENOUGH_MB else ""
    return Finding(topic, f"{folder}, {free_mb:.0f} MB free{little}")


def _encodings() -> list[Finding]:
    names, output = sys.getfilesystemencoding(), getattr(sys.stdout, "encoding", None) or "none"
    lacking = "" if output.lower().replace("-", "") == "utf8" else "; letters it lacks are written as escapes"
    return [Finding("encodings", f"file names {names}, output {output}{lacking}; files are written in UTF-8")]


def _plots() -> list[Finding]:
    own = [name for name in ("MPLBACKEND", "MATPLOTLIBRC") if name in os.environ]
    places = (Path("matplotlibrc"), Path(os.path.expanduser("~/.config/matplotlib/matplotlibrc")))
    own += [str(path) for path in places if os.path.exists(path)]
    from codend.report.own_look import own_look

    with own_look():
        import matplotlib.figure  # noqa: F401 what plots need is there
    followed = f"{', '.join(own)} found, which plots do not follow" if own else "no settings of the user's"
    return [Finding("plots", f"as matplotlib is shipped; {followed}")]


def _numba() -> list[Finding]:
    import numba

    config: Any = numba.config
    found = f"{numba.get_num_threads()}, threading layer {config.THREADING_LAYER}"
    if config.DISABLE_JIT:
        return [Finding("numba threads", found), Finding("NUMBA_DISABLE_JIT", "set, and set aside: kernels compile")]
    return [Finding("numba threads", found)]


def _package(name: str, absent: str, *, needed: bool) -> Finding:
    found = version_of(name)
    return Finding(name, found or absent, missing=needed and found is None)


def _usable_cores() -> int | None:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()


def _compiled_kernels() -> list[Finding]:
    from catch_models.kernel_cache import remove_damaged

    findings = []
    for folder in sorted({kernel.stats.cache_path or "" for kernel in _kernels()}):
        if not folder:
            findings.append(Finding("kernel cache", "none can be written: every run compiles anew"))
            continue
        path = Path(folder)
        damaged = remove_damaged(path) if path.exists() else []
        count = len(list(path.glob("*.nbi")))
        state = f"{count} compiled" if count else "none compiled yet (the first solve will, or codend doctor --warm-up)"
        repaired = f", {len(damaged)} damaged files removed" if damaged else ""
        writable = "" if os.access(path, os.W_OK) or not path.exists() else ", folder cannot be written"
        findings.append(Finding("kernel cache", f"{state}{repaired}{writable}: {folder}"))
    return findings


def _kernels() -> Sequence[Any]:
    """All compiled functions of the project."""
    from numba.core.dispatcher import Dispatcher

    # these load every room that has kernels
    import codend.selectivity.escape.haul
    import codend.studies.study  # noqa: F401

    modules = [module for name, module in sys.modules.items() if name.split(".")[0] in ("codend", "catch_models")]
    found = {id(value): value for module in modules for value in vars(module).values() if isinstance(value, Dispatcher)}
    return list(found.values())


def warm_up() -> str:
    """Solve a tiny net, so that every kernel is compiled and cached; says what was compiled and how long it took."""
    from codend.plan.plan import plan_from_dict
    from codend.studies.study import solve

    started = perf_counter()
    solve(plan_from_dict(_WARM_UP_PLAN, "warm-up plan"))
    compiled = sum(sum(kernel.stats.cache_misses.values()) for kernel in _kernels())
    loaded = sum(sum(kernel.stats.cache_hits.values()) for kernel in _kernels())
    return f"{compiled} kernels compiled, {loaded} loaded from the cache, {perf_counter() - started:.1f} s"
