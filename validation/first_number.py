"""How long a user waits for a first number: ``python -m validation.first_number``.

Runs ``codend run`` on the flume case with nothing compiled, and again, and prints when the first row of ``results.csv``
stood there and when the command was done.
"""

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
COMMAND = (sys.executable, "-c", "from codend.cli.main import main; main(prog_name='codend')")
PLAN = ROOT / "validation" / "cases" / "flume_150x140.toml"


def waited(out: Path, cache: Path) -> tuple[float, float]:
    """Seconds to the first row of the results, and to the end."""
    words = [*COMMAND, "run", PLAN, "--out", out]
    begun, first = time.monotonic(), None
    process = subprocess.Popen(
        words,
        env={**os.environ, "NUMBA_CACHE_DIR": str(cache), "PYTHONPATH": str(ROOT)},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    while process.poll() is None:
        if first is None and (out / "results.csv").exists():
            first = time.monotonic() - begun
        time.sleep(0.01)
    end = time.monotonic() - begun
    return end if first is None else first, end


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        for name in ("cold", "warm"):
            found = waited(Path(folder) / name, Path(folder) / "cache")
            print(f"{name}: first number after {found[0]:.1f} s, done after {found[1]:.1f} s", flush=True)
