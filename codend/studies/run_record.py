"""What a run is of: digests of the program, the plan, the files it names, and the tables that came of them.

``run.json`` comes after the tables and before the page, which bears the same name of the run: a folder with a page
holds the tables that it is of, and tables without ``run.json`` are of a run that did not end.
"""

import json
import re
from collections.abc import Iterable, Mapping
from functools import cache
from hashlib import sha256
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Final

from codend.io.files import COMPARISON_FILES, SELECTIVITY_TABLES, TRIAL_TABLES, whole_file
from codend.io.names import as_text
from codend.io.spreadsheet import spreadsheets_in
from codend.plan.copy import plan_toml
from codend.plan.plan import Plan

RECORD: Final = "run.json"
TABLES: Final = ("results.csv", "profile.csv", "meshes.csv", "ropes.csv", "layers.csv")
"""Of a run; the last one for nets without symmetry."""
_NAME_DIGITS: Final = 12


def inputs_of(plan: Plan) -> dict[str, str]:
    """Digests of all that decides the numbers of a run: the program, the plan, and the files the plan names.

    Raises:
        OSError: one of those files cannot be read.
    """
    named = [] if plan.sphere_cp_path is None else [plan.sphere_cp_path]
    files = {as_text(Path(path.name)): _digest(path.read_bytes()) for path in named}
    return {"program": program(), "plan.toml": _digest(plan_toml(plan).encode(errors="replace")), **files}


def write_record(folder: Path, inputs: Mapping[str, str]) -> str:
    """Write ``run.json`` beside the tables of a run; the name it gives the run."""
    tables = {name: _digest((folder / name).read_bytes()) for name in TABLES if (folder / name).exists()}
    content = {"inputs": dict(inputs), "tables": tables}
    name = _digest(json.dumps(content, sort_keys=True).encode())[:_NAME_DIGITS]
    with whole_file(folder / RECORD) as temporary:
        temporary.write_text(json.dumps({"run": name, **content}, indent=1) + "\n", encoding="utf-8")
    return name


def why_not_done(folder: Path, inputs: Mapping[str, str]) -> str | None:
    """Why the run in a folder is not one of these inputs, whole as it was written; None where it is."""
    record = _read_record(folder)
    if record is None:
        return f"{RECORD} cannot be read" if (folder / RECORD).exists() else "it did not end"
    before, tables = record["inputs"], record["tables"]
    for name in (*inputs, *before):
        if before.get(name) != inputs.get(name):
            return f"the {name} has changed" if name == "program" else f"{name} has changed"
    for name in TABLES:
        path = folder / name
        found = _digest(path.read_bytes()) if path.is_file() else None
        if found != tables.get(name):
            return f"{name} is missing" if found is None else f"{name} is not as it was written"
    return None if (folder / "plan.toml").is_file() else "plan.toml is missing"


def unfinished(folder: Path) -> str | None:
    """How many cases a folder holds of a run that did not end, in words; None where it holds no such run."""
    table = folder / "results.csv"
    if (folder / RECORD).exists() or (folder / "report.html").exists() or not table.is_file():
        return None
    count = table.read_bytes().count(b"\n") - 1
    return "1 case" if count == 1 else f"{count} cases"


def remove_run(folder: Path, but_tables_of: str | None = None) -> None:
    """Remove an earlier run, its page first and its tables last, and what other commands made of it.

    Args:
        folder: where it is.
        but_tables_of: a plan's copy; the tables stay where it is the one beside them.
    """
    nets = [path for path in folder.glob("net_*.vtu") if re.fullmatch(r"net_\d+\.vtu", path.name)]
    derived = [folder / name for name in (*SELECTIVITY_TABLES, *TRIAL_TABLES, *COMPARISON_FILES)]
    plots = folder / "plots"
    nets += [folder / SERIES, folder / "net.html"]
    pictures = [plots / f"{name}.png" for name in PLOT_NAMES]
    derived += spreadsheets_in(folder)
    _remove([folder / "report.html", folder / RECORD, *derived, *nets, *pictures, *plots.glob("selectivity_*.png")])
    if plots.is_dir() and not any(plots.iterdir()):
        plots.rmdir()
    copy = folder / "plan.toml"
    if but_tables_of is None or not copy.is_file() or copy.read_bytes() != but_tables_of.encode(errors="replace"):
        _remove([folder / name for name in (*TABLES, "plan.toml")])


SERIES: Final = "net.pvd"
"""Of the file that strings the nets of all cases together for ParaView."""
PLOT_NAMES: Final = ("net", "profiles", "opening", "opening_force", "tension", "drag", "layers")
"""Of the plots in a run's ``plots``."""


@cache
def program() -> str:
    """The program's version, and a digest of its files: an update in place changes no version."""
    digest = sha256()
    for package in ("catch_models", "codend"):
        spec = find_spec(package)
        assert spec is not None
        assert spec.origin is not None
        home = Path(spec.origin).parent
        for path in sorted(home.rglob("*")):
            if path.is_file() and "__pycache__" not in path.parts:
                digest.update(f"{path.relative_to(home)} {_digest(path.read_bytes())}\n".encode())
    try:
        number = version("codend")
    except PackageNotFoundError:
        number = "not installed"
    return f"codend {number}, {digest.hexdigest()[:_NAME_DIGITS]}"


def _read_record(folder: Path) -> dict[str, Any] | None:
    try:
        record = json.loads((folder / RECORD).read_bytes())
        whole = all(isinstance(record[part], dict) for part in ("inputs", "tables"))
    except (OSError, ValueError, TypeError, KeyError):
        return None
    return record if whole else None


def _remove(paths: Iterable[Path]) -> None:
    for path in paths:
        if path.is_file():
            path.unlink()


def _digest(content: bytes) -> str:
    return sha256(content).hexdigest()
