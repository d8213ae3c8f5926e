"""The papers' trawl as a scene: what is rounded, and the first moments of its shooting."""

import pytest

from validation.trawl.gear import PLAN, half_trawl, rounded
from validation.trawl.shooting import followed, shot


def test_the_plan_is_rounded_by_what_it_says():
    assert rounded(16) < 0.1
    assert rounded(24) < 0.25
    # four equal panels of two wings and a bosom: 1436 meshes round
    assert 8 * (PLAN["wing"].aft + 49.5) == pytest.approx(1436)
    names = [sheet["name"] for sheet in half_trawl()["netting"]]
    assert len(names) == len(set(names)) == 29


def test_the_shot_trawl_jerks_at_its_warps_and_its_weights_sink_first():
    table, _, _ = followed(shot(24, 1.5, 0.025, output_s=0.5))
    last = table.iloc[-1]
    assert last["peak_pull_n"] > 4.0 * table["pull_n"].iloc[0]
    assert last["weight_depth_m"] > last["door_depth_m"] + 1.0
    assert last["opening_m"] > table["opening_m"].iloc[0]
    assert last["off_lengths"] < 0.05
