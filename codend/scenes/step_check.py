"""What a motion in steps half as long tells of one: how far its depths and pulls are from right, about."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import ceil
from typing import Any

import numpy as np

from codend.net.net import Floats
from codend.scenes.build import BuiltScene
from codend.scenes.follow import follow, motion_rows, outputs

LONG_S, MOST_BAR_STEPS = 0.2, 100_000
"""Steps from which on a motion is followed once more, and bars times steps up to which it is: some seconds. Of warps
towed in steps below that none was off by 10 % (``validation.motion_map``)."""
TOLD = 0.05
"""Difference that is told: the error of a method of the second order is a third larger."""


def worth_a_check(built: BuiltScene) -> bool:
    """Whether a motion's steps are long, and few enough to follow it once more."""
    time = built.scene.time
    assert time is not None
    steps = (outputs(time) - 1) * ceil(time.output_s / time.step_s - 1e-9)
    return time.step_s >= LONG_S and steps * len(built.problem.net.bars) <= MOST_BAR_STEPS


def by_half_steps(built: BuiltScene, start: Floats) -> list[dict[str, Any]]:
    """Rows of ``motion.csv`` of the motion in steps half as long.

    Raises:
        ArithmeticError: the motion cannot be followed.
    """
    time = built.scene.time
    assert time is not None
    shorter = time.model_copy(update={"step_s": 0.5 * time.step_s})
    halved = replace(built, scene=built.scene.model_copy(update={"time": shorter}))
    return [row for frame in follow(halved, start) for row in motion_rows(halved, frame)]


def largest_difference(rows: Sequence[Mapping[Any, Any]], others: Sequence[Mapping[Any, Any]]) -> tuple[float, str]:
    """Largest difference of a height or a pull of the same time, over its largest value, and of which point or rope."""
    worst, of = 0.0, ""
    for name in dict.fromkeys(row["name"] for row in rows):
        for column in ("z_m", "tension_n"):
            one, two = (np.array([row[column] for row in table if row["name"] == name]) for table in (rows, others))
            size = np.abs(two).max(initial=0.0)
            off = float(np.nanmax(np.abs(one - two), initial=0.0) / size) if np.isfinite(size) and size > 0.0 else 0.0
            if off > worst:
                worst, of = off, f"{'height' if column == 'z_m' else 'pull'} of {name}"
    return worst, of
