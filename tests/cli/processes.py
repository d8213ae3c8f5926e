"""The program run as a user runs it: in a process of its own, with an environment and a folder of its own."""

import json
import os
import re
import subprocess
import sys
from collections.abc import Mapping, Sequence
from hashlib import sha256
from pathlib import Path
from typing import Any

import pandas as pd

from tests import ROOT

COMMAND = (sys.executable, "-c", "from codend.cli.main import main; main(prog_name='codend')")

WITH_WORKERS = (sys.executable, "-c", f"from codend.studies import workers; workers.WAITED_FOR_S = 600; {COMMAND[-1]}")
"""The same, its workers at work before it begins itself."""


def environment(changes: Mapping[str, str | None] | None = None, package: Path = ROOT) -> dict[str, str]:
    """That of this process with changes, None for a variable that is to be missing."""
    changed = {**os.environ, "PYTHONPATH": str(package), **(changes or {})}
    return {name: value for name, value in changed.items() if value is not None}


def start(
    *words: object, env: Mapping[str, str] | None = None, command: Sequence[str] = COMMAND, **options: Any
) -> subprocess.Popen[bytes]:
    """Start ``codend WORDS``."""
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "cwd": "/"} | options
    return subprocess.Popen([*command, *(os.fsencode(str(word)) for word in words)], env=env or environment(), **pipes)


def run(*words: object, **options: Any) -> subprocess.CompletedProcess[str]:
    """Run ``codend WORDS`` to its end."""
    process = start(*words, **options)
    out, err = (text.decode(errors="replace") if text else "" for text in process.communicate())
    return subprocess.CompletedProcess(process.args, process.returncode, out, err)


def words(done: subprocess.CompletedProcess[str]) -> str:
    """What was said beside the results, but for how far it was: that is told where a machine is slow."""
    lines = done.stderr.splitlines(keepends=True)
    return "".join(line for line in lines if not re.match(r"\d+ of \d+ done ", line))


def numbers(table: Path) -> pd.DataFrame:
    """A table of a run without the one column that no two runs share."""
    return pd.read_csv(table).drop(columns="solve_ms", errors="ignore")


def assert_page_is_of_its_tables(folder: Path) -> None:
    """A page is there only with the record it names and the tables that this is of, and no half-written file."""
    page = folder / "report.html"
    if not page.exists():
        return
    record = json.loads((folder / "run.json").read_bytes())
    assert f"run {record['run']}," in page.read_text(encoding="utf-8")
    for name, digest in record["tables"].items():
        assert sha256((folder / name).read_bytes()).hexdigest() == digest
