import ast
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from codend.compiled import modules_behind
from tests import ROOT

# a bar from the axis to a point one metre away along y, turned by a quarter circle: a kernel in bars.py that calls one
# in images.py
WHERE_A_BAR_ENDS = """
import numpy as np
from codend.mechanics.bars import bar_vector

rotations = np.array([[0.0, -1.0], [1.0, 0.0], [0.0, 1.0]])
print(*bar_vector(np.array([[0.0, 0.0, 0.0], [0.0, 1.0, 0.0]]), 0, 1, 1, rotations))
print(sum(bar_vector.stats.cache_hits.values()))
"""


def said_by_a_new_process(project: Path, environment: dict[str, str]) -> list[str]:
    result = subprocess.run(
        [sys.executable, "-c", WHERE_A_BAR_ENDS],
        env={**os.environ, "PYTHONPATH": str(project), **environment},
        cwd=project,
        capture_output=True,
        text=True,
        check=True,
    )
    return result.stdout.splitlines()


@pytest.mark.parametrize("own_cache_folder", [False, True])
def test_a_change_in_a_called_kernels_file_changes_the_answer_of_the_next_run(tmp_path: Path, own_cache_folder: bool):
    for room in ("codend", "catch_models"):
        shutil.copytree(ROOT / room, tmp_path / room, ignore=shutil.ignore_patterns("__pycache__"))
    environment = {"NUMBA_CACHE_DIR": str(tmp_path / "cache")} if own_cache_folder else {}
    assert said_by_a_new_process(tmp_path, environment) == ["0.0 0.0 1.0", "0"]
    assert said_by_a_new_process(tmp_path, environment) == ["0.0 0.0 1.0", "1"]
    called = tmp_path / "codend" / "mechanics" / "images.py"
    source = called.read_text(encoding="utf-8")
    changed = source.replace(", sine * y + cosine * z", ", 2.0 * (sine * y + cosine * z)", 1)
    called.write_text(changed, encoding="utf-8")
    assert said_by_a_new_process(tmp_path, environment) == ["0.0 0.0 2.0", "0"]
    (caches,) = {path.parent for path in tmp_path.rglob("bars.bar_vector*.nbc")}
    assert len(list(caches.glob("bars.bar_vector*"))) == 2, "an index and one compiled function: nothing is left behind"


TAKEN_OVER_BY_A_NEW_KERNEL = """
import sys
import numpy as np
from catch_models import kernel_loading
if len(sys.argv) > 1:
    kernel_loading.JITCodeLibrary = object
from codend.mechanics.bars import bar_vector

here = np.array([[0.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
rotations = np.array([[0.0, -1.0], [1.0, 0.0], [0.0, 1.0]])
bar_vector(here, 0, 1, 1, rotations)
print(sum(bar_vector.stats.cache_hits.values()), "numba.np.linalg" in sys.modules)
import numba

@numba.njit
def doubled(places):
    x, y, z = bar_vector(places, 0, 1, 1, rotations)
    return 2.0 * x, 2.0 * y, 2.0 * z

print(*doubled(here))
"""


@pytest.mark.parametrize("arguments", [[], ["as if numba were another"]])
def test_a_kernel_read_from_its_cache_is_taken_over_by_one_compiled_later(arguments: list[str]):
    run = [sys.executable, "-c", TAKEN_OVER_BY_A_NEW_KERNEL, *arguments]
    for _ in range(2):
        result = subprocess.run(run, cwd=ROOT, capture_output=True, text=True, check=True)
        if result.stdout.startswith("1"):
            break
    assert result.stdout.splitlines() == [f"1 {bool(arguments)}", "0.0 0.0 2.0"]
    assert not result.stderr


def test_all_cached_kernels_but_those_that_take_from_no_other_file_are_compiled_in_the_one_way():
    for room in ("codend", "catch_models"):
        for path in (ROOT / room).rglob("*.py"):
            source = path.read_text(encoding="utf-8")
            if path.name not in ("compiled.py", "kernel_cache.py") and re.search(
                r"^from numba import .*njit|^import numba", source, re.MULTILINE
            ):
                assert not re.search(r"^(from|import) +\.*(codend|catch_models)", source, re.MULTILINE), path


def test_files_with_kernels_import_this_project_in_the_form_that_is_followed():
    for path in (ROOT / "codend").rglob("*.py"):
        source = path.read_text(encoding="utf-8")
        if "@njit" in source:
            assert not re.search(r"^import +(codend|catch_models)|^from +\.", source, re.MULTILINE), path


def test_sources_are_followed_through_other_files_and_other_rooms():
    import codend.mechanics.newton_step  # noqa: F401 loads what is looked at

    behind = modules_behind("codend.mechanics.newton_step")
    assert {"codend.mechanics.images", "codend.mechanics.structure", "catch_models.filling"} <= behind
    assert "codend.mechanics.newton_step" not in modules_behind("codend.mechanics.images")


KERNEL_ROOM = "codend.mechanics."
BELOW_KERNELS = {"codend.compiled", "codend.net.net", "catch_models.kernel_cache", "catch_models.fish_parameters"}
"""How kernels are compiled, the types of arrays, and the order of a species' numbers."""


def may_hold_kernels(module: str) -> bool:
    name = module.rpartition(".")[2]
    in_named_file = name == "kernels" or name.endswith("_kernels") or module == "catch_models.filling"
    return in_named_file or module.startswith(KERNEL_ROOM)


def imported_by(tree: ast.Module) -> set[str]:
    modules = {node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) and node.module}
    return {module for module in modules if module.split(".")[0] in ("codend", "catch_models")}


def has_kernels(tree: ast.Module) -> bool:
    called = [node.func for node in ast.walk(tree) if isinstance(node, ast.Call)]
    return any((func.attr if isinstance(func, ast.Attribute) else getattr(func, "id", "")) == "njit" for func in called)


def parsed_sources() -> dict[str, ast.Module]:
    paths = [path for room in ("codend", "catch_models") for path in (ROOT / room).rglob("*.py")]
    names = {path: ".".join(path.relative_to(ROOT).with_suffix("").parts) for path in paths}
    return {name: ast.parse(path.read_text(encoding="utf-8")) for path, name in names.items()}


def test_compiled_code_of_a_room_stands_in_its_files_of_kernels():
    ways_to_compile = {"codend.compiled", "catch_models.kernel_cache"}
    compiled = {name for name, tree in parsed_sources().items() if has_kernels(tree)} - ways_to_compile
    assert {"codend.solvers.kernels", "codend.mechanics.bars", "catch_models.filling"} <= compiled
    assert not {name for name in compiled if not may_hold_kernels(name)}


def test_files_of_kernels_outside_the_kernel_room_import_only_kernels_and_what_those_stand_on():
    for name, tree in parsed_sources().items():
        if may_hold_kernels(name) and not name.startswith(KERNEL_ROOM):
            others = imported_by(tree) - BELOW_KERNELS
            assert not {other for other in others if not may_hold_kernels(other)}, name
