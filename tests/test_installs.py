"""What is installed: wheel and sdist are whole, and no folder named codend stands in the way of any kind of install."""

import subprocess
import sys
import tarfile
import tomllib
import zipfile
from pathlib import Path

import pytest

from tests import ROOT

DATA = (
    "codend/guide/codend.png",
    "codend/guide/columns.toml",
    "codend/guide/glossary.md",
    "codend/guide/plan-keys.md",
    "codend/py.typed",
    "codend/report/report.html",
    "catch_models/py.typed",
    "catch_models/data/species_example.toml",
    "catch_models/data/species_red_mullet.toml",
    "catch_models/data/sphere_cp_subcritical.csv",
)
WHERE = "import site, sys; site.addsitedir(sys.argv[1]); import codend; print(codend.__file__)"


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("built")
    for target in ("wheel:standard", "sdist", "wheel:editable"):
        words = [sys.executable, "-m", "hatchling", "build", "-t", target, "-d", folder / target.replace(":", "-")]
        subprocess.run(words, cwd=ROOT, check=True, capture_output=True)
    return folder


def unpacked(folder: Path, into: Path) -> Path:
    (wheel,) = folder.glob("*.whl")
    zipfile.ZipFile(wheel).extractall(into)
    return into


def test_wheel_and_sdist_hold_all_files_of_both_packages(built: Path):
    (wheel,) = (built / "wheel-standard").glob("*.whl")
    (sdist,) = (built / "sdist").glob("*.tar.gz")
    in_wheel = set(zipfile.ZipFile(wheel).namelist())
    with tarfile.open(sdist) as archive:
        in_sdist = {name.partition("/")[2] for name in archive.getnames()}
    modules = {
        str(path.relative_to(ROOT)) for room in ("codend", "catch_models") for path in (ROOT / room).rglob("*.py")
    }
    assert {*modules, *DATA} <= in_wheel
    assert {*modules, *DATA, "tests/test_installs.py", "pyproject.toml", "README.md", "LICENSE"} <= in_sdist
    version = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["version"]
    assert {name.split("/")[0] for name in in_wheel} == {"codend", "catch_models", f"codend-{version}.dist-info"}


@pytest.mark.parametrize("kind", ["wheel-standard", "wheel-editable"])
def test_a_script_beside_a_clone_named_codend_imports_what_is_installed(kind: str, built: Path, tmp_path: Path):
    site = unpacked(built / kind, tmp_path / "site")
    (tmp_path / "codend" / "codend").mkdir(parents=True)
    (tmp_path / "codend" / "codend" / "__init__.py").touch()
    script = tmp_path / "script.py"
    script.write_text(WHERE, encoding="utf-8")
    # -S: nothing that is installed for these tests is in reach
    words = [sys.executable, "-S", script, site]
    found = subprocess.run(words, cwd=tmp_path, check=True, capture_output=True, text=True).stdout.strip()
    assert Path(found) == (ROOT if kind == "wheel-editable" else site) / "codend" / "__init__.py"
