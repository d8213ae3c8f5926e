"""Time steps too long for a motion are told, by steps half as long."""

import numpy as np
import pytest

from codend.scenes.build import build
from codend.scenes.follow import follow, motion_rows
from codend.scenes.scene import scene_from_dict
from codend.scenes.step_check import TOLD, by_half_steps, largest_difference, worth_a_check


def warp(step_s, bars):
    """A gear on 100 m of warp, shot astern at 1.8 m/s."""
    rope = {"from": "vessel", "to": "gear", "length_m": 100.0, "diameter_mm": 12.0, "mass_kg_m": 0.5, "bars": bars}
    gear = {"name": "gear", "mass_kg": 200.0, "wet_weight_n": 1500.0, "area_m2": 0.5, "drag": 1.0}
    time = {"end_s": 20.0, "output_s": 1.0, "step_s": step_s, "start": "placed"}
    data = {"title": "warp", "vessel": {"speed_m_s": 1.8}, "rope": [rope], "point": [gear], "time": time}
    return build(scene_from_dict(data))


def told(built):
    """The largest difference to steps half as long."""
    start = built.problem.net.positions
    rows = [row for frame in follow(built, start) for row in motion_rows(built, frame)]
    return largest_difference(rows, by_half_steps(built, start))


@pytest.mark.parametrize("bars", [2, 5])
def test_steps_of_a_second_with_few_bars_are_told_as_off_by_more_than_a_tenth(bars):
    built = warp(1.0, bars)
    assert worth_a_check(built)
    assert told(built)[0] > 0.1


def test_steps_of_a_fifth_of_a_second_pass():
    built = warp(0.2, 5)
    assert worth_a_check(built)
    assert told(built)[0] < TOLD


def test_short_steps_are_not_checked():
    assert not worth_a_check(warp(0.05, 5))


def test_a_difference_is_told_over_the_largest_value_and_by_name():
    rows = [{"name": "gear", "z_m": z, "tension_n": np.nan} for z in (-10.0, -20.0)]
    others = [{**row, "z_m": row["z_m"] + 2.0} for row in rows]
    assert largest_difference(rows, others) == (pytest.approx(2.0 / 18.0), "height of gear")
