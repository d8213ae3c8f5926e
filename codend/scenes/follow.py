"""A scene in time: one frame an output, and whatever is needed to go on from any of them."""

from collections.abc import Iterator
from dataclasses import dataclass
from math import ceil, pi, sin

import numpy as np
from scipy.interpolate import CubicSpline, make_interp_spline

from codend.errors import InputError
from codend.mechanics.body import attitude_deg, pose_of
from codend.mechanics.problem import Problem
from codend.net.net import Floats, Ints
from codend.scenes.build import BuiltScene
from codend.scenes.equilibrium import apart, contact_law
from codend.scenes.frame_measures import float_rows
from codend.scenes.frame_tables import FRAME
from codend.scenes.measures import most_tension
from codend.scenes.tables import TimeTable, VesselTable
from codend.solvers.motion import Motion, Path
from codend.solvers.refusal import passage

State = dict[str, Floats | Ints]
ATTITUDE = ("heel_deg", "trim_deg", "yaw_deg")
RECORD_ROWS, UNEVEN = 8, 3.5
"""Rows from which on a table of motion is a record, if the longest time between two is no more times the shortest."""
_EARLY = 1e-9
"""Seconds by which a step may begin before what happens at its start."""


@dataclass(frozen=True)
class Frame:
    """A scene at one output."""

    number: int
    """From 0, at the start."""
    time_s: float
    positions: Floats
    """(n, 3), m."""
    velocities: Floats
    """Half a step before, (n, 3), m/s."""
    bar_tension: Floats
    """(m,), N."""
    support: Floats
    """What holds the nodes, (n, 3), N."""
    held: frozenset[int]
    """Nodes held then."""
    peaks: Floats
    """Of every rope the largest tension so far, when it was and how far from the rope's first end: N, s, m, (r, 3)."""
    since: Floats
    """Largest tension of every rope since the last output, N, (r,)."""
    passages: Floats
    """At how many outputs so far netting had passed through itself or a rope, and at what time first, s, (2,)."""
    state: State
    """What ``follow`` goes on from, with this frame as the first."""


def outputs(time: TimeTable) -> int:
    """Number of frames, the start's among them."""
    return int(time.end_s / time.output_s + 1e-9) + 1


def path_of(vessel: VesselTable | None, table: Floats | None) -> Path | None:
    """How far the vessel has gone from where it was at first; heave sets in over its first period."""
    if table is not None:
        return _path_through(table)
    if vessel is None or vessel.heave_m == 0.0 or vessel.period_s is None:
        return None
    height, period = vessel.heave_m, vessel.period_s
    return lambda t: np.array([0.0, 0.0, height * heave(t, period)])


def is_record(table: Floats) -> bool:
    """Whether rows of ``time_s, x_m, y_m, z_m`` are many and even enough to run smoothly through."""
    steps = np.diff(table[:, 0])
    return len(table) >= RECORD_ROWS and bool(steps.max() <= UNEVEN * steps.min())


def _path_through(table: Floats) -> Path:
    """Path through the rows of ``time_s, x_m, y_m, z_m``, from where it is at time 0, and straight on beyond the last.

    A record is followed by a cubic spline, for a rope that does not stretch answers a jump in speed by a pull as large
    as the step is short; between few or uneven rows the path is straight, and ``largest_jump`` tells.
    """
    time, places = table[:, 0], table[:, 1:]
    place = CubicSpline(time, places) if is_record(table) else make_interp_spline(time, places, k=1)
    onward = place(time[-1], 1)

    def at(time_s: float) -> Floats:
        # the tension of the last output is that of the step from there on
        return np.asarray(place(min(time_s, time[-1])) + max(time_s - time[-1], 0.0) * onward)

    start = at(0.0)
    return lambda time_s: at(time_s) - start


def largest_jump(table: Floats, end_s: float) -> tuple[float, float]:
    """Largest jump of a path's speed, from rest at time 0 and at rows, m/s, and when it is, s."""
    path = _path_through(table)
    jumps = [(float(np.linalg.norm(path(_EARLY)) / _EARLY), 0.0)]
    if not is_record(table):
        slopes = np.diff(table[:, 1:], axis=0) / np.diff(table[:, 0])[:, None]
        change = np.linalg.norm(np.diff(slopes, axis=0), axis=1)
        inside = (table[1:-1, 0] > 0.0) & (table[1:-1, 0] < end_s)
        jumps += zip(change[inside].tolist(), table[1:-1, 0][inside].tolist(), strict=True)
    return max(jumps)


def heave(time_s: float, period_s: float) -> float:
    """Heave over its amplitude: a sine that sets in over the first period, without a jump in velocity."""
    ramp = sin(0.5 * pi * time_s / period_s) ** 2 if time_s < period_s else 1.0
    return ramp * sin(2.0 * pi * time_s / period_s)


def follow(built: BuiltScene, start: Floats, state: State | None = None) -> Iterator[Frame]:
    """Frames of a scene's motion from rest, or from the state of one of its frames.

    Args:
        built: the scene; it must have a table [time].
        start: where its nodes are at first, (n, 3), m.
        state: that of a frame, which comes first then.

    Raises:
        ArithmeticError: the motion cannot be followed.
        InputError: netting passes through itself at the start of a motion under contact.
    """
    scene, time = built.scene, built.scene.time
    if time is None:
        raise ValueError("a scene without a table [time] has no motion")
    path = path_of(scene.vessel, scene.vessel_path())
    problem = _under_contact(built, start) if scene.model.contact and not scene.afloat else built.problem
    motion = Motion(
        problem,
        start,
        added_mass=built.added_mass,
        towed=built.towed,
        path=path,
        length_error=scene.length_error,
    )
    hangs = sorted((p.held_from_s, built.node_of[p.name]) for p in scene.point if p.held_from_s is not None)
    ropes = len(built.rope_bars)
    peaks, since, first = np.full((ropes, 3), -1.0), np.zeros(ropes), 0
    passages = np.array([0.0, np.nan])
    if state is not None:
        motion.set_state(state)
        peaks[:], since[:], first = state["peaks"], state["since"], int(state["number"][0])
        passages[:] = state["passages"]
    steps = ceil(time.output_s / time.step_s - 1e-9)
    dt = time.output_s / steps
    for number in range(first, outputs(time)):
        now = {"peaks": peaks.copy(), "since": since.copy(), "number": np.array([float(number)])}
        before = {**motion.state(), **now, "passages": passages.copy()}
        if passage(problem, motion.position) is not None:
            passages[0] += 1.0
            passages[1] = np.fmin(passages[1], number * time.output_s)
        for step in range(steps):
            while hangs and motion.time >= hangs[0][0] - _EARLY:
                motion.hold(hangs.pop(0)[1], (scene.speed_m_s, 0.0, 0.0))  # seen from the vessel
            time_s, held = motion.time, frozenset(np.flatnonzero((motion.structure.free == 0.0).all(axis=1)).tolist())
            positions, velocities = motion.position.copy(), motion.velocity.copy()
            motion.step(dt)
            _note(built, motion.tension, time_s, peaks, since)
            if step == 0:
                yield Frame(
                    number,
                    number * time.output_s,
                    positions,
                    velocities,
                    motion.tension.copy(),
                    motion.support.copy(),
                    held,
                    peaks.copy(),
                    since.copy(),
                    passages.copy(),
                    before,
                )
                since[:] = 0.0
                if number == outputs(time) - 1:
                    return


def _under_contact(built: BuiltScene, start: Floats) -> Problem:
    """The scene's problem with what may not pass through what."""
    if len(built.problem.net.facets) == 0:
        return built.problem
    touching = built.problem.touching_by(contact_law(built.problem))
    if not apart(touching, start):
        allowed = "left out, or a start in which nothing touches or passes through anything"
        raise InputError(built.scene.source, "model.contact", True, allowed, "is not possible from the start as it is")
    return touching


def _note(built: BuiltScene, tension: Floats, time_s: float, peaks: Floats, since: Floats) -> None:
    for rope, bars in enumerate(built.rope_bars):
        along = tension[bars]
        highest, value = int(np.argmax(along)), most_tension(along)
        since[rope] = max(since[rope], value)
        if value > peaks[rope, 0]:
            length = built.scene.rope[rope].length_m
            place = {0: 0.0, len(along) - 1: 1.0}.get(highest, (highest + 0.5) / len(along))
            peaks[rope] = value, time_s, length * (place if value > along[highest] else (highest + 0.5) / len(along))


def motion_rows(built: BuiltScene, frame: Frame) -> list[dict[str, float | str]]:
    """Rows of ``motion.csv``: points, whose tension is what holds them, then ropes at their middle, with the largest.

    Then netting at the mean place of its knots, with the largest tension of a real bar, and the floats of a frame at
    the middles of their feet. Where a frame floats, its own row has how it is turned. Of a rope ``max_tension_n`` is
    the largest in any of its bars since the output before.
    """
    rows: list[dict[str, float | str]] = []
    body = built.problem.body

    def add(name: str, place: Floats, tension: float, most: float) -> None:
        x, y, z = map(float, place)
        at = {"x_m": x, "y_m": y, "z_m": z, "tension_n": tension, "max_tension_n": most}
        turned = {} if body is None else dict.fromkeys(ATTITUDE, np.nan)
        rows.append({"time_s": frame.time_s, "name": name, **at, **turned})

    for name, node in built.node_of.items():
        pull = float(np.linalg.norm(frame.support[node])) if node in frame.held else np.nan
        add(name, frame.positions[node], pull, np.nan)
    for rope, (name, nodes, bars) in enumerate(
        zip(built.scene.rope_names, built.rope_nodes, built.rope_bars, strict=True)
    ):
        along = frame.bar_tension[bars]
        most = most_tension(along)
        middle = 0.5 * (frame.positions[nodes[(len(nodes) - 1) // 2]] + frame.positions[nodes[len(nodes) // 2]])
        add(name, middle, most, float(frame.since[rope]))
    for number, (table, nodes) in enumerate(zip(built.scene.netting, built.sheet_nodes, strict=True)):
        own = built.bar_sheet == number
        most = float((frame.bar_tension[own] / built.bar_lines[own]).max())
        add(table.name, frame.positions[nodes].mean(axis=0), most, np.nan)
    if body is not None:
        attitude = attitude_deg(pose_of(body, frame.positions).turn)
        next(row for row in rows if row["name"] == FRAME).update(zip(ATTITUDE, attitude, strict=True))
        for one in float_rows(built, frame.positions):
            add(one["name"], np.array([one["x_m"], one["y_m"], one["z_m"]]), np.nan, np.nan)
    return rows
