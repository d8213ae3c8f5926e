"""Whether a release installs and runs: ``python -m validation.release --python python3.12 ... [--lowest python3.11]``.

Builds the wheel, installs it in an empty environment of each Python outside the repository, with the newest libraries
that its bounds allow and, where asked, with the lowest, and runs a small plan there. Prints what was found.
"""

import re
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Iterator
from pathlib import Path

import click

ROOT = Path(__file__).resolve().parents[1]
PLAN = ROOT / "validation" / "cases" / "flume_150x140.toml"
SHOWN = ("numpy", "scipy", "numba", "pandas", "matplotlib", "pydantic")


def lowest() -> Iterator[str]:
    """Every dependency at its lower bound, as pip's constraints."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    for requirement in project["dependencies"]:
        name, bound = re.match(r"([\w-]+)>=([\d.]+)", requirement).groups()
        yield f"{name}=={bound}.*"


def run(*words: object, cwd: Path) -> str:
    """What a command prints.

    Raises:
        CalledProcessError: it failed.
    """
    return subprocess.run([str(w) for w in words], cwd=cwd, check=True, capture_output=True, text=True).stdout


def tried(python: str, wheel: Path, at_lowest: bool) -> str:
    """What a wheel does in an empty environment: versions and drag, or how it failed."""
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        try:
            run(python, "-m", "venv", "env", cwd=place)
            bounds = place / "bounds.txt"
            bounds.write_text("\n".join(lowest()) if at_lowest else "", encoding="utf-8")
            run("env/bin/pip", "install", "-q", "-c", bounds, wheel, cwd=place)
            run("env/bin/codend", "run", PLAN, "--set", "catch.filled_meshes=[20]", "--out", "out", cwd=place)
            listed = run("env/bin/pip", "list", "--format=freeze", cwd=place)
            versions = dict(line.split("==") for line in listed.splitlines() if "==" in line)
            table = (place / "out" / "results.csv").read_text(encoding="utf-8").splitlines()
            row = dict(zip(table[0].split(","), table[1].split(","), strict=False))
        except subprocess.CalledProcessError as error:
            return f"FAILED: {' '.join(error.cmd[:3])}: {error.stderr.strip().splitlines()[-1:]}"
        return f"drag {float(row['drag_n']):.6f} N with " + ", ".join(f"{name} {versions[name]}" for name in SHOWN)


@click.command()
@click.option("--python", "pythons", multiple=True, default=(sys.executable,), help="Of an environment; repeated.")
@click.option("--lowest", "lowests", multiple=True, help="Of one with the lowest libraries that are allowed; repeated.")
def main(pythons: tuple[str, ...], lowests: tuple[str, ...]) -> None:
    """Build the wheel and try it."""
    failed = False
    with tempfile.TemporaryDirectory() as folder:
        run(sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", folder, cwd=ROOT)
        (wheel,) = Path(folder).glob("*.whl")
        for which, names in (("newest", pythons), ("lowest", lowests)):
            for python in names:
                version = run(python, "--version", cwd=ROOT).strip()
                found = tried(python, wheel, which == "lowest")
                failed |= found.startswith("FAILED")
                print(f"{wheel.name}, {version}, {which} libraries: {found}", flush=True)
    sys.exit(failed)


if __name__ == "__main__":
    main()
