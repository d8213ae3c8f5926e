"""One warp with a gear, shot straight astern, beside MoorDyn-C. ``python -m validation.moordyn_comparison [BARS]``.

100 m of 12 mm, 0.5 kg/m, with 200 kg, 1500 N wet, drag area 0.5 m2 at its end, in water at rest; the vessel comes to
1.8 m/s in two seconds. MoorDyn lays its lines as catenaries: both start from the nodes it laid. Needs the optional
group ``moordyn``; the warp stretches (EA 1e6 N), for MoorDyn knows no other, with half of critical damping there.
"""

import os
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from codend.net.net import Floats
from codend.scenes.build import build
from codend.scenes.scene import scene_from_dict
from codend.solvers.motion import Motion

LENGTH, DIAMETER, MASS, EA, NORMAL, TANGENTIAL = 100.0, 0.012, 0.5, 1e6, 1.36, 0.07
GEAR_KG, GEAR_N, GEAR_M2, SPEED, RAMP, WATER, G = 200.0, 1500.0, 0.5, 1.8, 2.0, 1025.0, 9.80665
EVERY_S, FROM_S, END_S = 1.0, 10.0, 60.0
MOORDYN_STEP, OWN_STEP = 5e-4, 0.01


def gone(t: float) -> float:
    """Way of the vessel, m."""
    if t < RAMP:
        return 0.5 * SPEED * (t - np.sin(np.pi * t / RAMP) * RAMP / np.pi)
    return SPEED * (t - 0.5 * RAMP)


def _speed(t: float) -> float:
    return 0.5 * SPEED * (1.0 - np.cos(np.pi * t / RAMP)) if t < RAMP else SPEED


def _moordyn_input(bars: int) -> str:
    volume = (GEAR_KG - GEAR_N / G) / WATER
    # its friction acts on the whole surface of the rope, pi d, and ours on d
    friction = TANGENTIAL * NORMAL / np.pi
    return f"""---------------------- LINE TYPES ----------
TypeName Diam Mass/m EA BA/-zeta EI Cd Ca CdAx CaAx
(name) (m) (kg/m) (N) (N-s/-) (N-m^2) (-) (-) (-) (-)
warp {DIAMETER} {MASS} {EA} -0.5 0 {NORMAL} 1.0 {friction} 0.0
---------------------- POINTS ----------
ID Type X Y Z Mass Volume CdA Ca
(#) (-) (m) (m) (m) (kg) (m^3) (m^2) (-)
1 Coupled 0 0 0 0 0 0 0
2 Free {LENGTH} 0 0 {GEAR_KG} {volume} {GEAR_M2} 0
---------------------- LINES ----------
ID LineType AttachA AttachB UnstrLen NumSegs Outputs
(#) (name) (#) (#) (m) (-) (-)
1 warp 1 2 {LENGTH} {bars} -
---------------------- OPTIONS ----------
0 writeLog
{MOORDYN_STEP} dtM
rk4 tScheme
{G} g
{WATER} rhoW
500 WtrDpth
0 currents
0.1 dtIC
0.0 TmaxIC
--------------------- need this line ------------------
"""


def by_moordyn(bars: int, end_s: float) -> Iterator[tuple[Floats, Floats]]:
    """The nodes at first, then every ``EVERY_S``: time, distance and height of the gear, pull at the vessel."""
    import moordyn

    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "line.txt")
        with open(path, "w") as stream:
            stream.write(_moordyn_input(bars))
        system = moordyn.Create(path)
        try:
            moordyn.Init(system, [0.0, 0.0, 0.0], [0.0, 0.0, 0.0])
            line, gear = moordyn.GetLine(system, 1), moordyn.GetPoint(system, 2)
            towing_point = moordyn.GetPoint(system, 1)
            nodes = np.array([moordyn.GetLineNodePos(line, node) for node in range(bars + 1)])
            outputs, t, step = round(end_s / EVERY_S), 0.0, 0.05
            for output in range(outputs):
                for _ in range(round(EVERY_S / step)):
                    moordyn.Step(system, [-gone(t), 0.0, 0.0], [-_speed(t), 0.0, 0.0], t, step)
                    t += step
                place = moordyn.GetPointPos(gear)
                pull = float(np.linalg.norm(moordyn.GetPointForce(towing_point)))
                yield nodes, np.array([EVERY_S * (output + 1), place[0] + gone(t), place[2], pull])
        finally:
            moordyn.Close(system)


def by_codend(bars: int, nodes: Floats, end_s: float, step: float = OWN_STEP, stiffness_n: float | None = EA) -> Floats:
    """The same, (outputs, 4); with bars that do not stretch where the stiffness is None."""
    rope = {"from": "vessel", "to": "gear", "length_m": LENGTH, "diameter_mm": 1e3 * DIAMETER, "mass_kg_m": MASS}
    law = {"axial_stiffness_n": stiffness_n, "normal": NORMAL, "tangential": TANGENTIAL, "bars": bars}
    gear = {"name": "gear", "mass_kg": GEAR_KG, "wet_weight_n": GEAR_N, "area_m2": GEAR_M2, "drag": 1.0}
    built = build(scene_from_dict({"title": "warp", "vessel": {}, "rope": [{**rope, **law}], "point": [gear]}))
    start = np.empty_like(built.problem.net.positions)
    start[built.rope_nodes[0]] = nodes
    path = lambda t: np.array([-gone(t), 0.0, 0.0])  # noqa: E731
    motion = Motion(built.problem, start, added_mass=built.added_mass, towed=built.towed, path=path)
    found, per_output = [], round(EVERY_S / step)
    for number in range(round(end_s / EVERY_S) * per_output + 1):
        place = motion.position[1] - motion.position[0]
        motion.step(step)
        if number and number % per_output == 0:
            found.append([step * number, place[0], place[2], float(np.linalg.norm(motion.support[0]))])
    return np.array(found)


@contextmanager
def _silent() -> Iterator[None]:
    """Keep what MoorDyn prints itself from standard output."""
    sys.stdout.flush()
    kept = os.dup(1)
    with open(os.devnull, "w") as nothing:
        os.dup2(nothing.fileno(), 1)
        try:
            yield
        finally:
            os.dup2(kept, 1)
            os.close(kept)


def compare(bars: int, end_s: float) -> tuple[Floats, Floats]:
    """Both, (outputs, 4) each."""
    with _silent():
        rows = list(by_moordyn(bars, end_s))
    return np.array([row for _, row in rows]), by_codend(bars, rows[0][0], end_s)


def main() -> None:
    """Print both and the largest differences from ``FROM_S`` on."""
    other, own = compare(int(sys.argv[1]) if len(sys.argv) > 1 else 20, END_S)
    print("\n  time s   depth m MoorDyn    codend    pull N MoorDyn    codend")
    for theirs, ours in zip(other, own, strict=True):
        if theirs[0] % 5.0 == 0.0 or theirs[0] <= 5.0:
            print(f"{theirs[0]:8.1f} {-theirs[2]:17.4f} {-ours[2]:9.4f} {theirs[3]:17.2f} {ours[3]:9.2f}")
    late = other[:, 0] >= FROM_S
    off = np.abs(own[late] / other[late] - 1.0).max(axis=0)
    print(f"largest difference from {FROM_S:g} s on: depth {100 * off[2]:.3f} %, pull {100 * off[3]:.3f} %")


if __name__ == "__main__":
    main()
