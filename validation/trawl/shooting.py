"""The trawl shot astern from a line at the surface: shock, sinking, opening, and the pace of the reckoning.

``python -m validation.trawl.shooting --out DIR`` follows it for 600 s (``--end``) and prints what the paper describes;
``DIR/shooting.csv`` has a row a second, ``DIR/shape.npz`` the shapes. ``--scene FILE`` writes the scene for
``codend scene`` in place of that.
"""

import argparse
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
import pandas as pd

from codend.net.net import Floats
from codend.scenes.build import BuiltScene, build
from codend.scenes.follow import follow
from codend.scenes.scene import scene_from_dict
from validation.trawl.gear import SPEED_M_S, half_trawl, rounded

LAST_S = 60.0
"""Over which the drift of the opening is taken."""


def shot(merged: int, end_s: float, step_s: float, output_s: float = 1.0, **more: Any) -> BuiltScene:
    """The half gear in a line astern, to be followed."""
    time = {"end_s": end_s, "output_s": output_s, "step_s": step_s, "start": "placed"}
    return build(scene_from_dict(half_trawl(merged, time=time, **more)))


def followed(built: BuiltScene, out: Path | None = None) -> tuple[pd.DataFrame, Floats, Floats]:
    """What is told of every output, and the last shape and tensions."""
    node, rows, shapes, began = built.node_of, [], [], process_time()
    for frame in follow(built, built.problem.net.positions):
        at = frame.positions
        rows.append(
            {
                "time_s": frame.time_s,
                "pull_n": float(np.linalg.norm(frame.support[node["vessel"]])),
                "pull_ahead_n": float(-frame.support[node["vessel"]][0]),
                "peak_pull_n": float(frame.since[0]),
                "door_depth_m": float(-at[node["door"], 2]),
                "door_aside_m": float(at[node["door"], 1]),
                "weight_depth_m": float(-at[node["lower wing end"], 2]),
                "opening_m": float(at[node["upper centre"], 2] - at[node["lower centre"], 2]),
                "wing_height_m": float(at[node["upper wing end"], 2] - at[node["lower wing end"], 2]),
                "wing_aside_m": float(at[node["upper wing end"], 1]),
                "off_lengths": float(frame.state["clock"][3]),
                "unsettled": int(frame.state["clock"][2]),
                "passages": int(frame.passages[0]),
                "processor_s": process_time() - began,
            }
        )
        shapes.append(at.astype(np.float32))
        if out is not None and len(rows) % 10 == 1:
            pd.DataFrame(rows).to_csv(out / "shooting.csv", index=False, float_format="%.6g")
    return pd.DataFrame(rows), np.array(shapes), frame.bar_tension


def told(table: pd.DataFrame, built: BuiltScene) -> str:
    """What the paper describes, in lines."""
    last, bars = table.iloc[-1], len(built.problem.net.bars)
    shock = table.iloc[int(table["peak_pull_n"][table["time_s"] <= 30.0].argmax())]
    steady = table[table["time_s"] >= last["time_s"] - LAST_S]
    drift = np.polyfit(steady["time_s"], steady["opening_m"], 1)[0] * 60.0
    sinking = np.gradient(table["weight_depth_m"], table["time_s"])
    fast, slow = sinking[table["time_s"] <= 10.0].max(), sinking[table["time_s"] >= last["time_s"] - LAST_S].mean()
    pace = last["time_s"] / last["processor_s"]
    settled = table[table["time_s"] >= min(60.0, 0.5 * last["time_s"])]
    later = np.ptp(settled["time_s"]) / np.ptp(settled["processor_s"])
    return "\n".join(
        [
            f"half a trawl of {bars} bars, {built.scene.speed_m_s:.3f} m/s, {last['time_s']:g} s",
            f"first shock: {2.0 * shock['peak_pull_n']:.0f} N on both warps at {shock['time_s']:g} s; "
            f"at the end {2.0 * last['pull_n']:.0f} N",
            f"weights: sink at {fast:.2f} m/s at most in the first 10 s, at {slow:.4f} m/s in the last {LAST_S:g} s; "
            f"{last['weight_depth_m']:.1f} m deep",
            f"opening at the centre {last['opening_m']:.2f} m, at the wings {last['wing_height_m']:.2f} m, "
            f"drift {drift:+.4f} m a minute; doors {2.0 * last['door_aside_m']:.1f} m apart",
            f"bars off their lengths by {100.0 * last['off_lengths']:.2g} % at most in a step, "
            f"{last['unsettled']:.0f} steps unsettled, {last['passages']:.0f} outputs with netting through itself",
            f"pace: {pace:.2f} s of sea in a second of one core, {later:.2f} once the shock is over",
        ]
    )


def main() -> None:
    """Follow the shooting and print what is seen."""
    asked = argparse.ArgumentParser(description=__doc__)
    asked.add_argument("--out", type=Path, default=Path("trawl"))
    asked.add_argument("--merged", type=int, default=24)
    asked.add_argument("--end", type=float, default=600.0)
    asked.add_argument("--step", type=float, default=0.025)
    asked.add_argument("--speed", type=float, default=SPEED_M_S)
    asked.add_argument("--scene", type=Path)
    given = asked.parse_args()
    if given.scene is not None:
        write_scene(given.scene, given.merged)
        return
    given.out.mkdir(parents=True, exist_ok=True)
    built = shot(given.merged, given.end, given.step, speed_m_s=given.speed)
    table, shapes, tension = followed(built, given.out)
    table.to_csv(given.out / "shooting.csv", index=False, float_format="%.6g")
    np.savez_compressed(given.out / "shape.npz", shapes=shapes, tension=tension)
    print(f"counts of meshes rounded to multiples of {given.merged}: twine of a section changed by at most "
          f"{100.0 * rounded(given.merged):.0f} %")  # fmt: skip
    print(told(table, built))


def write_scene(path: Path, merged: int) -> None:
    """Write the scene as a file."""
    time = {"end_s": 600.0, "output_s": 5.0, "step_s": 0.025, "start": "placed"}
    tables = half_trawl(merged, time=time)
    lines = [
        "# Half of a pelagic trawl, written by `python -m validation.trawl.shooting --scene FILE`, see",
        "# validation/trawl/gear.py for what is from the published plan, from the paper, and assumed.",
        f'title = "{tables["title"]}"',
    ]
    for name, value in tables.items():
        for one in value if isinstance(value, list) else [value] if isinstance(value, dict) else []:
            lines += ["", f"[[{name}]]" if isinstance(value, list) else f"[{name}]"]
            lines += [f"{key} = {_toml(entry)}" for key, entry in one.items()]
    path.write_text("\n".join(lines) + "\n")


def _toml(value: Any) -> str:
    if isinstance(value, str):
        return f'"{value}"'
    if isinstance(value, list):
        return f"[{', '.join(_toml(one) for one in value)}]"
    return repr(float(f"{value:.8g}")) if isinstance(value, float) else str(value)


if __name__ == "__main__":
    main()
