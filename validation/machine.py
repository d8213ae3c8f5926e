"""The machine and the versions that a report was computed with."""

import os
import platform
import subprocess
from pathlib import Path

from codend.cli.doctor import FAST, REQUIRED, version_of


def machine() -> list[tuple[str, str]]:
    """Cores, processor, system, Python, packages and commit, each named; what is not known is left out."""
    facts = [
        ("cores", str(os.cpu_count())),
        ("processor", _processor()),
        ("system", f"{platform.system()} {platform.machine()}"),
        ("Python", platform.python_version()),
        ("packages", ", ".join(f"{name} {found}" for name in (*REQUIRED, *FAST) if (found := version_of(name)))),
        ("commit", _commit()),
    ]
    return [(name, found) for name, found in facts if found]


def _processor() -> str:
    """Model of the processor as Linux tells it, elsewhere what Python knows."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    models = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return models[0] if models else platform.processor()


def _commit() -> str:
    """Commit of the source, marked where files differ from it; empty if git does not tell."""
    command = ["git", "describe", "--always", "--dirty=, with changes", "--abbrev=10", "--exclude=*"]
    try:
        return subprocess.run(
            command, cwd=Path(__file__).parent, capture_output=True, text=True, check=True, timeout=30
        ).stdout.strip()
    except (OSError, subprocess.SubprocessError):
        return ""
