"""Random frames afloat on moorings in a current: how many are found, and whether any is wrong.

``python -m validation.random_frames [FRAMES] [FOLLOWED]``: 60, of which the first 4 are followed in time from where
they are placed, for 100 s, to see whether they come to the same place, or to another rest near by. Floats, weights,
moorings (2 to 4, half of them elastic), a seabed, the current up to 1.5 m/s and for some a wall of netting are drawn;
an answer is wrong if loads and supports leave over more than 1e-8 of their sizes, on the frame or in all.
"""

import sys
from typing import Any

import numpy as np

from codend.mechanics.body import pose_of, shortest_period
from codend.net.net import Floats
from codend.scenes.build import build
from codend.scenes.follow import follow
from codend.scenes.frame_measures import frame_rows
from codend.scenes.measures import SceneResult, balance_error, settled, solve_scene
from codend.scenes.scene import scene_from_dict

Tables = list[dict[str, Any]]
WATER = 1025.0
WRONG = 1e-8
FOLLOWED_S, FAR_M = 100.0, 0.05


def random_frame(seed: int) -> dict[str, Any]:
    """A scene drawn from a seed."""
    rng = np.random.default_rng(seed)
    reach, height = rng.uniform(1.0, 5.0), float(rng.uniform(0.4, 1.0))
    floats, volume = [], 0.0
    count = int(rng.integers(3, 7))
    for number in range(count):
        x, y = reach * _towards(2.0 * np.pi * (number + rng.uniform(0.0, 0.3)) / count)
        one: dict[str, Any] = {"name": f"float {number}", "at": [x, y, -0.5 * height], "height_m": height}
        if rng.random() < 0.5:
            one["diameter_m"] = float(rng.uniform(0.3, 0.8))
            volume += 0.25 * np.pi * one["diameter_m"] ** 2 * height
        else:
            one |= {"length_m": float(rng.uniform(0.3, 1.0)), "width_m": float(rng.uniform(0.3, 1.0))}
            volume += one["length_m"] * one["width_m"] * height
        floats.append(one)
    mass, depth = float(rng.uniform(0.2, 0.6) * volume * WATER), float(rng.uniform(5.0, 15.0))
    points, ropes = _moorings(rng, reach, depth)
    middle = [*map(float, 0.3 * rng.normal(size=2)), -0.3]
    points += [{"name": "drag", "at": middle, "held": "frame", "area_m2": float(rng.uniform(0.5, 4.0)), "drag": 1.0}]
    vx, vy = rng.uniform(0.0, 1.5) * _towards(rng.uniform(0.0, 2.0 * np.pi))
    centre = [*map(float, 0.1 * reach * rng.normal(size=2)), float(rng.uniform(-0.3, 0.3))]
    data = {"title": f"frame {seed}", "water": {"density_kg_m3": WATER, "flow_m_s": [vx, vy, 0.0]}, "float": floats}
    data |= {"frame": {"hold": "floating", "mass_kg": mass, "centre": centre, "inertia_kg_m2": [mass] * 3}}
    data |= {"point": points, "rope": ropes, "seabed": {"depth_m": depth}}
    return data | (_wall(points) if rng.random() < 0.4 else {})


def _towards(angle: float) -> list[float] | Any:
    return np.array([float(np.cos(angle)), float(np.sin(angle))])


def _moorings(rng: np.random.Generator, reach: float, depth: float) -> tuple[Tables, Tables]:
    points, ropes, first = [], [], rng.uniform(0.0, 6.0)
    count = int(rng.integers(2, 5))
    for number in range(count):
        way, apart = _towards(first + 2.0 * np.pi * number / count), rng.uniform(1.5, 3.0) * depth
        points.append({"name": f"p{number}", "at": [*map(float, reach * way), 0.0], "held": "frame"})
        points.append({"name": f"A{number}", "at": [*map(float, (reach + apart) * way), -depth], "held": "ground"})
        rope = {"name": f"mooring {number}", "from": f"p{number}", "to": f"A{number}", "bars": 15}
        rope["length_m"] = float(np.hypot(apart, depth) * rng.uniform(1.02, 1.15))
        rope |= {"diameter_mm": float(rng.uniform(10.0, 40.0)), "mass_kg_m": float(rng.uniform(0.8, 4.0))}
        if rng.random() < 0.5:
            rope["axial_stiffness_n"] = float(10.0 ** rng.uniform(4.5, 6.5))
        ropes.append(rope)
    return points, ropes


def _wall(points: list[dict[str, Any]]) -> dict[str, Any]:
    """Netting between the first two moorings' ends on the frame, with a weight at each of its lower corners."""
    ends = [points[0]["at"], points[2]["at"]]
    weight = {"mass_kg": 10.0, "wet_weight_n": 80.0}
    points += [{"name": f"foot {n}", "at": [*at[:2], -2.0], **weight} for n, at in enumerate(ends)]
    bar = float(np.linalg.norm(np.subtract(*ends))) / 16
    wall = {"name": "wall", "mesh": "square", "bar_mm": 1020.0 * bar, "twine_mm": 3.0, "axial_stiffness_n": 2e4}
    wall |= {"meshes_across": 16, "meshes_long": max(int(2.0 / bar), 2), "corners": ["p0", "p1", "foot 1", "foot 0"]}
    return {"netting": [wall]}


def left_over(result: SceneResult) -> float:
    """Of loads and supports, in all and on the frame, over their sizes."""
    row = frame_rows(result.built, result.solution.positions, result.support)[0]
    on_frame = max(abs(row[key]) for key in row if key.startswith(("force", "holding"))) / row["weight_n"]
    return max(on_frame, balance_error(result))


def followed(seed: int) -> tuple[Floats, Floats]:
    """Where the frame's origin is after ``FOLLOWED_S``, and where it rests that is found from there, (3,) each, m."""
    body = build(scene_from_dict(random_frame(seed))).frame
    assert body is not None
    step = 1.0 / np.ceil(1.0 / min(0.01, 0.1 * shortest_period(body)))
    time = {"end_s": FOLLOWED_S, "output_s": FOLLOWED_S, "step_s": float(step), "start": "placed"}
    built = build(scene_from_dict({**random_frame(seed), "time": time}))
    *_, last = follow(built, built.problem.net.positions)
    rest = settled(built, last.positions, last.bar_tension)
    return pose_of(body, last.positions).origin, pose_of(body, rest.solution.positions).origin


def main() -> None:
    """Print the share that is found, the worst balance, and how far those followed in time are from theirs."""
    frames, in_time = (int(sys.argv[n]) if len(sys.argv) > n else default for n, default in ((1, 60), (2, 4)))
    found, worst = 0, 0.0
    for seed in range(frames):
        result = solve_scene(build(scene_from_dict(random_frame(seed))))
        if not result.converged:
            print(f"frame {seed}: {result.solution.report.outcome.value}")
            continue
        found, worst = found + 1, max(worst, left_over(result))
        if seed < in_time:
            body = result.built.frame
            assert body is not None
            rest = pose_of(body, result.solution.positions).origin
            end, near = followed(seed)
            off, from_near = (float(np.abs(end - place).max()) for place in (rest, near))
            other = "" if off < FAR_M else f", within {from_near:.1e} m of another rest at {near.round(3)}"
            print(f"frame {seed}: rests at {rest.round(3)} m; after {FOLLOWED_S:g} s in time {off:.1e} m off{other}")
    print(f"{found} of {frames} found, the worst balance {worst:.1e} ({WRONG:g} allowed)")


if __name__ == "__main__":
    main()
