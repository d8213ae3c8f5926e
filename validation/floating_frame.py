"""A floating frame beside closed forms and its own balances. ``python -m validation.floating_frame``.

The frame of every check is assumed: two beams 4 m apart that carry 150 kg, on two moorings or none.
"""

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from codend.mechanics.body import MARKER_M, Body, attitude_deg, pose_of
from codend.mechanics.problem import Problem
from codend.mechanics.weight import GRAVITY_M_S2
from codend.net.net import Floats, Net
from codend.scenes.build import BuiltScene, build
from codend.scenes.frame_measures import float_rows, frame_rows
from codend.scenes.measures import SceneResult, balance_error, point_rows, solve_scene
from codend.scenes.netting_measures import drag_of
from codend.scenes.scene import scene_from_dict
from codend.solvers.body_system import BodySystem, out_of_balance
from codend.solvers.motion import Motion
from codend.solvers.prepared import prepare

WATER, AREA_M2, APART_M = 1025.0, 0.3 * 4.0, 4.0
INERTIA = (60.0, 80.0, 90.0)
BEAM = {"height_m": 0.6, "length_m": 0.3, "width_m": 4.0, "mass_kg": 25.0}
FRAME = {"hold": "floating", "mass_kg": 100.0, "centre": [0.0, 0.0, -0.05], "inertia_kg_m2": INERTIA}
WEIGHT_KG = 150.0


class Check(NamedTuple):
    """What was found beside what is right."""

    name: str
    found: float
    right: float
    allowed: float
    """Difference, over ``right`` unless that is 0."""

    @property
    def off(self) -> float:
        """The difference as ``allowed`` has it."""
        return abs(self.found - self.right) / (abs(self.right) or 1.0)


def beams(draft_m: float = 0.1, **tables: Any) -> dict[str, Any]:
    """A frame on two beams that lie ``draft_m`` deep as placed, with a thin line across it that weighs nothing."""
    ends = [{"name": name, "at": [0.0, y, 0.0], "held": "frame"} for name, y in (("port", -1.0), ("starboard", 1.0))]
    line = {"name": "line", "from": "port", "to": "starboard", "length_m": 2.001, "diameter_mm": 1.0, "bars": 1}
    line |= {"mass_kg_m": WATER * 0.25e-6 * np.pi, "normal": 0.0, "tangential": 0.0}
    floats = [
        {"name": name, "at": [x, 0.0, -draft_m], **BEAM}
        for name, x in (("front", -0.5 * APART_M), ("rear", 0.5 * APART_M))
    ]
    points, ropes = ends + tables.pop("point", []), [line, *tables.pop("rope", [])]
    data = {"title": "Two beams", "water": {"density_kg_m3": WATER}, "frame": FRAME, "float": floats}
    return {**data, "point": points, "rope": ropes, **tables}


def moored(speed_m_s: float, **tables: Any) -> dict[str, Any]:
    """The same on two moorings that spread to its sides, with something that the current pulls at."""
    place = {"a": (-2.0, 1.5, 0.0), "b": (-2.0, -1.5, 0.0)}
    points: list[dict[str, Any]] = [{"name": name, "at": list(at), "held": "frame"} for name, at in place.items()]
    points += [{"name": "drag", "at": [0.0, 0.0, -0.3], "held": "frame", "area_m2": 2.0, "drag": 1.0}]
    points += [
        {"name": name.upper(), "at": [-20.0, 4.0 * np.sign(at[1]), -10.0], "held": "ground"}
        for name, at in place.items()
    ]
    mooring = {"length_m": 22.0, "diameter_mm": 20.0, "mass_kg_m": 1.0, "bars": 12}
    ropes = [{"name": f"mooring {name}", "from": name, "to": name.upper(), **mooring} for name in place]
    water = {"density_kg_m3": WATER, "flow_m_s": [speed_m_s, 0.0, 0.0]}
    return beams(point=points, rope=ropes, water=water, **tables)


def hung(speed_m_s: float, hold: str = "floating") -> dict[str, Any]:
    """The moored frame with a wall of netting under its front beam and a weight at each of the wall's lower corners."""
    data = moored(speed_m_s)
    corners = [[-2.0, -1.0, 0.0], [-2.0, 1.0, 0.0]]
    weight = {"mass_kg": 5.0, "wet_weight_n": 40.0}
    data["point"] += [{"name": f"foot {y:g}", "at": [x, y, -1.0], **weight} for x, y, _ in corners]
    wall = {"name": "wall", "mesh": "square", "bar_mm": 100.0, "twine_mm": 3.0, "meshes_across": 20, "meshes_long": 10}
    wall |= {"corners": [*corners, "foot 1", "foot -1"], "fore": "frame", "axial_stiffness_n": 2e4}
    return data | {"netting": [wall], "frame": {**FRAME, "hold": hold}}


def solved(data: dict[str, Any]) -> SceneResult:
    """Its equilibrium.

    Raises:
        ArithmeticError: none was found.
    """
    result = solve_scene(build(scene_from_dict(data)))
    if not result.converged:
        raise ArithmeticError("; ".join(result.solution.report.attempts))
    return result


def drafts() -> Iterator[Check]:
    """Of two beams, the front one pulled straight down: (Wn / 2 + Vm) / (rho g Aw) and (Wn / 2) / (rho g Aw)."""
    for down_n in (0.0, 40.0, 200.0):
        weight = {"name": "weight", "at": [-0.5 * APART_M, 0.0, 0.0], "held": "frame", "wet_weight_n": down_n}
        rows = float_rows((result := solved(beams(point=[weight]))).built, result.solution.positions)
        for row, pull in zip(rows, (down_n, 0.0), strict=True):
            right = (0.5 * WEIGHT_KG * GRAVITY_M_S2 + pull) / (WATER * GRAVITY_M_S2 * AREA_M2)
            # of weight and buoyancy at other heights, and of the beams' own tilt
            tilt = np.radians(frame_rows(result.built, result.solution.positions, result.support)[0]["trim_deg"])
            yield Check(f"draft of {row['name']}, {down_n:g} N down", row["draft_m"], right, 1e-9 + 0.02 * abs(tilt))


def periods() -> Iterator[Check]:
    """Heave 2 pi sqrt(M / (2 rho g Aw)), pitch 2 pi sqrt(I / (rho g V GM)) of small swings."""
    draft = WEIGHT_KG / (WATER * 2.0 * AREA_M2)
    yield Check("heave period, s", _period(0.005, 0.0), 2.0 * np.pi * np.sqrt(WEIGHT_KG / _spring()), 5e-4)
    middle = np.array([-0.05, *2 * [-draft + 0.5 * BEAM["height_m"]]]) @ np.array([100.0, 25.0, 25.0]) / WEIGHT_KG
    waterplane = 2.0 * AREA_M2 * (APART_M**2 / 4.0 + BEAM["length_m"] ** 2 / 12.0)
    righting = WATER * GRAVITY_M_S2 * (waterplane + 2.0 * AREA_M2 * draft * (-0.5 * draft - middle))
    beam = 25.0 * ((BEAM["length_m"] ** 2 + BEAM["height_m"] ** 2) / 12.0 + APART_M**2 / 4.0)
    heights = np.array([-0.05, *2 * [-draft + 0.5 * BEAM["height_m"]]]) - middle
    inertia = INERTIA[1] + 2.0 * beam + np.array([100.0, 25.0, 25.0]) @ heights**2
    yield Check("pitch period, s", _period(0.0, 0.005), 2.0 * np.pi * np.sqrt(inertia / righting), 5e-4)


def _spring() -> float:
    return 2.0 * WATER * GRAVITY_M_S2 * AREA_M2


def _period(up_m: float, tilt: float, dt: float = 0.005, swings: int = 4) -> float:
    """Of a frame let go that far from its rest, s."""
    built = build(scene_from_dict(beams(WEIGHT_KG / (WATER * 2.0 * AREA_M2))))
    assert built.frame is not None
    turn = np.array([[np.cos(tilt), 0.0, np.sin(tilt)], [0.0, 1.0, 0.0], [-np.sin(tilt), 0.0, np.cos(tilt)]])
    start = built.problem.net.positions.copy()
    start[built.frame.nodes] = [0.0, 0.0, up_m] + built.frame.arms @ turn.T
    motion, downs, last = Motion(built.problem, start), [], 1.0
    assert motion.body is not None
    while len(downs) < swings:
        now = motion.body.pose.origin[2] / up_m if up_m else -motion.body.pose.turn[2, 0] / tilt
        if last > 0.0 >= now:
            downs.append(motion.time - dt * now / (now - last))
        last = now
        motion.step(dt)
    return (downs[-1] - downs[0]) / (swings - 1)


def spinning(dt: float, end_s: float = 2.0) -> tuple[float, float, float]:
    """A body that spins freely about no axis of its own: what is off after ``end_s``, relative.

    Returns:
        its momentum as kept; its moment of momentum by its attitude and the mean of the velocities before and after;
        its energy, likewise.
    """
    arms = np.array([[0.0, 0.0, 0.0], [MARKER_M, 0.0, 0.0], [0.0, MARKER_M, 0.0], [1.0, 0.0, 0.0]])
    net = Net.from_bars(
        np.concatenate([arms, [[2.0, 0.0, 0.0]]]), [[3, 4]], [True] * 4 + [False], length_m=9.0, diameter_m=1e-9,
        density_kg_m3=WATER,
    )  # fmt: skip
    none = np.zeros(3)
    inertia = np.array([1.0, 2.0, 2.5])
    columns = np.zeros((0, 3)), np.zeros(0), np.zeros(0)
    body = Body(np.arange(4, dtype=np.int32), arms, 10.0, none, np.diag(inertia), none, none, *columns, WATER)
    motion = Motion(Problem.of(net, body=body), net.positions)
    assert motion.body is not None
    moment = np.array([1.0, 3.0, 0.5])
    motion.body.momentum[3:], motion.body.twist[3:] = moment, moment / inertia

    def by_attitude() -> tuple[Floats, float]:
        pose, before = motion.body.pose, motion.body.twist[3:].copy()
        motion.step(dt)
        spin = pose.turn.T @ (0.5 * (before + motion.body.twist[3:]))
        return pose.turn @ (inertia * spin), float(spin @ (inertia * spin))

    _, energy = by_attitude()
    while motion.time < end_s - 0.5 * dt:
        found, now = by_attitude()
    kept = np.linalg.norm(motion.body.momentum[3:] - moment) / np.linalg.norm(moment)
    return float(kept), float(np.linalg.norm(found - moment) / np.linalg.norm(moment)), abs(now / energy - 1.0)


def spins() -> Iterator[Check]:
    """The moment of momentum of a free spin: kept whole, and by attitude and velocity to the first order and better."""
    coarse, fine = spinning(0.02), spinning(0.01)
    yield Check("free spin: momentum kept", coarse[0], 0.0, 1e-9)
    yield Check("free spin: moment by attitude, dt 0.02", coarse[1], 0.0, 0.02)
    yield Check("the same, dt 0.01", fine[1], 0.0, 0.01)
    yield Check("order in dt, at least 1", min(float(np.log2(coarse[1] / fine[1])), 1.0), 1.0, 0.05)


def balances() -> Iterator[Check]:
    """Moorings against drag, yaw under symmetry, and all loads against all supports."""
    for name, data in (("moored, 0.5 m/s", moored(0.5)), ("moored, 1.5 m/s", moored(1.5)), ("with a wall", hung(0.5))):
        result = solved(data)
        built, found = result.built, result.solution
        anchors = sum(row["force_x_n"] for row in point_rows(result) if row["name"] in ("A", "B"))
        drag = float(drag_of(built, found.positions, np.ones(len(found.bar_tension), dtype=bool))[0])
        drag += 0.5 * WATER * 2.0 * data["water"]["flow_m_s"][0] ** 2
        yield Check(f"{name}: pull of the moorings, N", -anchors, drag, 1e-8)
        assert built.frame is not None
        yield Check(f"{name}: yaw, degrees", attitude_deg(pose_of(built.frame, found.positions).turn)[2], 0.0, 1e-8)
        yield Check(f"{name}: sums of loads and supports", balance_error(result), 0.0, 1e-8)
        row = frame_rows(built, found.positions, result.support)[0]
        left = max(abs(row[key]) for key in row if key.startswith(("force", "holding")))
        yield Check(f"{name}: what is left over on the frame, over its weight", left / row["weight_n"], 0.0, 1e-8)


def tangents(seed: int = 0) -> Iterator[Check]:
    """The tangent of net and body: differences of all loads along a step are what it was asked to undo."""
    data = hung(0.5)
    for rope in data["rope"]:
        rope["axial_stiffness_n"] = 1e5
    built = build(scene_from_dict(data))
    found = solve_scene(built).solution
    problem, body = built.problem, built.frame
    assert body is not None
    rng = np.random.default_rng(seed)
    system = BodySystem(problem, prepare(problem.structure, problem.bands))
    yield Check("tangent against differences", step_error(problem, found.positions, system, rng), 0.0, 3e-6)


def step_error(problem: Problem, positions: Floats, system: BodySystem, rng: np.random.Generator) -> float:
    """By how much central differences of all loads along a step miss what the step is for, relative."""
    from codend.mechanics import body as rigid
    from codend.mechanics import newton_step
    from codend.mechanics.newton_state import empty_state, measure

    body, structure, loading = problem.body, problem.structure, problem.loading
    assert body is not None
    state, tension = empty_state(structure, problem.bands), 10.0

    def state_at(position: Floats, density: Floats) -> Floats:
        state.position[:], state.density[:] = position, density
        measure(structure, loading, tension, 1.0, 0.0, state)
        return state.force.copy()

    pose = pose_of(body, positions)
    length = np.linalg.norm(np.subtract(*(positions[n] for n in (structure.second, structure.first))), axis=1)
    gives = structure.flexibility > 0.0

    def density_at(position: Floats) -> Floats:
        now = np.linalg.norm(position[structure.second] - position[structure.first], axis=1)
        law = (1.0 / structure.length - 1.0 / now) / np.where(gives, structure.flexibility, 1.0)
        return np.where(gives, np.maximum(law, 0.0), 0.0)

    force = state_at(positions, density_at(positions))
    newton_step.linearise(structure, loading, system.prepared.pattern, tension, 0.0, state, system.prepared.step)
    if system.factorise(system.prepared.step.blocks, pose, force) != 0:
        raise ArithmeticError("the tangent is singular")
    right = rng.normal(size=(1, len(positions), 3))
    solution = system.solve(right, pose)[0]
    twist = system.twist.copy()
    free = ~problem.net.fixed
    asked = right[0][free], np.einsum("nij,ni->j", system._jacobian, right[0]) + rigid.load(body, pose)

    def left(size: float) -> tuple[Floats, Floats]:
        position, there = positions + size * solution, rigid.moved(pose, size * twist)
        rigid.place(body, there, position)
        force = state_at(position, density_at(position))
        return force[free], out_of_balance(body, there, force)

    # of the fourth order, for bars are so stiff that small steps are lost in round-off
    size = 5e-4 * float(length.mean()) / float(np.abs(solution).max())
    places = [left(share * size) for share in (-2.0, -1.0, 1.0, 2.0)]
    slopes = [(a - 8.0 * b + 8.0 * c - d) / (12.0 * size) for a, b, c, d in zip(*places, strict=True)]
    parts = [-slope - c for slope, c in zip(slopes, asked, strict=True)]
    return max(float(np.abs(part).max() / np.abs(c).max()) for part, c in zip(parts, asked, strict=True))


def settles(end_s: float = 20.0) -> Iterator[Check]:
    """The way to the equilibrium in time ends in the one that is found directly."""
    tables = {"time": {"end_s": end_s, "output_s": end_s, "step_s": 0.0125, "start": "placed"}}
    rest, built = solved(moored(1.0)), build(scene_from_dict(moored(1.0, **tables)))
    end = _followed(built)
    assert built.frame is not None
    for name, own, direct in zip(
        "xz", end[[0, 2]], pose_of(built.frame, rest.solution.positions).origin[[0, 2]], strict=True
    ):
        yield Check(f"after {end_s:g} s in time, {name} of the frame, m", own, direct, 0.01)
    yield Check("the same, y", end[1], 0.0, 1e-9)


def _followed(built: BuiltScene) -> Floats:
    from codend.scenes.follow import follow

    *_, last = follow(built, built.problem.net.positions)
    assert built.frame is not None
    return pose_of(built.frame, last.positions).origin


CHECKS = (drafts, periods, spins, balances, tangents, settles)


def main() -> None:
    """Print all checks."""
    print(f"{'':66s}{'found':>16s}{'right':>16s}{'off':>10s}{'allowed':>10s}")
    for group in CHECKS:
        for one in group():
            mark = "" if one.off <= one.allowed else "  FAILS"
            print(f"{one.name:66s}{one.found:16.9g}{one.right:16.9g}{one.off:10.1e}{one.allowed:10.1e}{mark}")


if __name__ == "__main__":
    main()
