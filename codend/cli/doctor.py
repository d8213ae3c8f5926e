"""What is installed, how compiled kernels are cached, and their compilation ahead of the first solve."""

import os
import platform
import sys
from collections.abc import Sequence
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
    "matplotlib",
    "meshio",
    "pillow",
    "pydantic",
    "click",
    "rich",
    "jinja2",
)
FOR_TESTS = ("pytest", "hypothesis", "statsmodels", "ruff", "mypy", "import-linter", "pandas-stubs", "scipy-stubs")
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
    """Versions, cores and threads, and the state of the compiled kernels' cache."""
    findings = [
        Finding("codend", version_of("codend") or "not installed, run from its source"),
        Finding("python", f"{platform.python_version()}, {platform.system()} {platform.machine()}"),
    ]
    findings += [_package(name, "MISSING", needed=True) for name in REQUIRED]
    findings += [_package(name, "not installed (only tests need it)", needed=False) for name in FOR_TESTS]
    findings += [_package(name, "not installed (SuperLU does its work, slower)", needed=False) for name in FAST]
    findings.append(Finding("cores", f"{_usable_cores()} usable of {os.cpu_count()}"))
    if any(finding.missing for finding in findings):
        return findings
    return findings + _compiled_kernels()


def _package(name: str, absent: str, *, needed: bool) -> Finding:
    found = version_of(name)
    return Finding(name, found or absent, missing=needed and found is None)


def _usable_cores() -> int | None:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()


def _compiled_kernels() -> list[Finding]:
    import numba

    folders = sorted({str(kernel.stats.cache_path) for kernel in _kernels()})
    layer = numba.config.THREADING_LAYER  # type: ignore[attr-defined] # set at run time
    findings = [Finding("numba threads", f"{numba.get_num_threads()}, threading layer {layer}")]
    for folder in folders:
        count = len(list(Path(folder).glob("*.nbi")))
        state = f"{count} compiled" if count else "none compiled yet (the first solve will, or codend doctor --warm-up)"
        writable = "" if os.access(folder, os.W_OK) or not Path(folder).exists() else ", folder cannot be written"
        findings.append(Finding("kernel cache", f"{state}{writable}: {folder}"))
    return findings


def _kernels() -> Sequence[Any]:
    """All compiled functions of the project."""
    from numba.core.dispatcher import Dispatcher

    import codend.studies.study  # noqa: F401 loads every room that has kernels

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
