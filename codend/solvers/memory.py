"""How much memory a net's factors take, and how much there is."""

import sys
from pathlib import Path

FACTORS_BYTES, EXPONENT = 550.0, 1.25
"""Bytes of the factors of a wide net over its unknowns to that power. SuperLU's factors of full nets of 2 800 to 60 000
unknowns, of every kind of netting, had 11 to 16 n^1.25 entries, at up to 25 bytes each with what it allots to grow. One
of 86 000 took 0.95 GB at most, where its stability is asked with factors of its own beside those."""
RESERVED, PROGRAM_BYTES = 2.0, 0.7e9
"""Addresses that SuperLU reserves, at the least, over what it fills, and those that the program takes besides once a
case is solved: of a process limited to 1.1 GB of them a small net was solved, of 1.0 GB its tables were not written.
That net was solved within 3.2 GB, sometimes within 2.6, and not within 2.2."""
NET_BYTES = 2000.0
"""Bytes of a net and its tangent an unknown, likewise."""


def needed_bytes(knots: int) -> float:
    """Memory that Newton's method on a wide net of so many knots takes, roughly."""
    unknowns = 3.0 * knots
    return FACTORS_BYTES * unknowns**EXPONENT + NET_BYTES * unknowns


def free_bytes() -> float:
    """Memory that may still be taken: of the machine, of the group of processes and by this process's own limit.

    Infinite where the system does not tell. The last limits the addresses that are reserved.
    """
    return min(_of_the_machine(), _of_the_group(), _of_this_process())


def _of_the_machine() -> float:
    try:
        lines = Path("/proc/meminfo").read_text(encoding="ascii").splitlines()
        return 1024.0 * next(int(line.split()[1]) for line in lines if line.startswith("MemAvailable"))
    except (OSError, StopIteration, ValueError):
        return float("inf")


def _of_the_group() -> float:
    group = Path("/sys/fs/cgroup")
    try:
        most, taken = ((group / name).read_text(encoding="ascii") for name in ("memory.max", "memory.current"))
        return float(most) - float(taken)  # "max" where there is no limit
    except (OSError, ValueError):
        return float("inf")


def _of_this_process() -> float:
    if sys.platform == "win32":
        return float("inf")
    import resource

    most, _ = resource.getrlimit(resource.RLIMIT_AS)
    if most == resource.RLIM_INFINITY:
        return float("inf")
    try:
        pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
    except (OSError, ValueError):
        pages = 0
    return max(float(most) - pages * resource.getpagesize() - PROGRAM_BYTES, 0.0) / RESERVED
