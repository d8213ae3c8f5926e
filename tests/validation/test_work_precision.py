"""Work against precision: the front is a front, references are confirmed, and the charts say what they should."""

import numpy as np
import pandas as pd
import pytest

from codend.studies.speed_accuracy.contenders import FULL, KINETIC, MERGED, NEWTON, SECTOR
from codend.studies.speed_accuracy.front import fastest, pareto_front
from validation.work_precision import section
from validation.work_precision.orders import growth, orders


def test_no_answer_on_the_front_is_beaten_and_every_other_one_is():
    rng = np.random.default_rng(1)
    time, error = rng.uniform(size=50), rng.uniform(size=50)
    front = pareto_front(time, error)
    assert np.all(np.diff(time[front]) > 0.0)
    assert np.all(np.diff(error[front]) < 0.0)
    for place in range(50):
        beaten = np.any((time < time[place]) & (error < error[place]))
        assert beaten == (place not in front)


def test_of_equal_answers_the_faster_is_on_the_front_and_a_failed_one_never_is():
    assert pareto_front(np.array([3.0, 1.0, 2.0]), np.array([0.1, np.nan, 0.1])).tolist() == [2]
    assert pareto_front(np.array([1.0, 1.0]), np.array([0.2, 0.1])).tolist() == [1]


def test_fastest_is_the_least_time_among_the_exact_enough():
    points = pd.DataFrame({"drag_error": [0.5, 0.01, 1e-3, np.nan], "solve_ms": [1.0, 5.0, 4.0, 0.1]})
    assert fastest(points, 0.01)["solve_ms"] == 4.0
    assert fastest(points, 1.0)["solve_ms"] == 1.0
    assert fastest(points, 1e-9) is None


def test_order_and_growth_are_those_of_made_up_powers():
    g = np.array([10.0, 5.0, 2.0])
    error = 1e-4 * (g**2 - 1.0)
    merged = pd.DataFrame({"model": MERGED, "method": NEWTON, "globalisation": g, "knots": 1e4 / g**2})
    merged["solve_ms"] = merged["knots"] ** 1.3
    for short in ("drag", "opening", "volume"):
        merged[f"{short}_error"] = error
    assert orders(merged)[["drag", "opening", "volume"]].to_numpy() == pytest.approx(2.0)
    relaxed = merged.assign(method=KINETIC, model=FULL)
    assert growth(pd.concat([merged, relaxed]))[NEWTON] == pytest.approx(1.3)


@pytest.fixture(scope="module")
def quick():
    return section(quick=True)


def test_every_verdict_of_the_quick_section_passes(quick):
    assert len(quick.verdicts) == 3
    for verdict in quick.verdicts:
        assert verdict.passed, f"{verdict.claim} {verdict.found}"


def test_newton_at_its_tightest_tolerance_is_the_reference_to_round_off_and_never_less_exact_than_at_its_loosest(quick):
    points = quick.data["work_precision"]
    newton = points[(points["model"] == SECTOR) & (points["method"] == NEWTON) & (points["tolerance"] != 1e-6)]
    assert newton["scene"].nunique() == 3
    for _, of_scene in newton.groupby("scene"):
        tight, loose = of_scene.sort_values("tolerance")["drag_error"]
        assert tight < 1e-9
        assert tight <= loose


def test_fewer_merged_meshes_are_more_exact_and_the_full_net_is_the_sector(quick):
    points = quick.data["work_precision"]
    nets = points[points["model"].isin([MERGED, FULL]) & (points["method"] == NEWTON)]
    for _, of_scene in nets.groupby("scene"):
        for short in ("drag", "opening", "volume"):
            assert of_scene.sort_values("globalisation")[f"{short}_error"].is_monotonic_increasing
        assert of_scene.loc[of_scene["model"] == FULL, "drag_error"].max() < 1e-5


def test_a_sector_leaves_less_out_than_merged_meshes_do_where_twine_has_weight(quick):
    points = quick.data["work_precision"]
    weighed = points[points["scene"] == "slow tow of heavy twine"]
    sector = weighed.loc[weighed["model"] == SECTOR, "drag_error"].max()
    assert 0.0 < sector < 0.1 * weighed.loc[weighed["model"] == MERGED, "drag_error"].min()


def test_charts_and_words_cover_every_quantity_and_scene(quick):
    assert [picture.name for picture in quick.pictures] == [
        f"work_precision_{short}" for short in ("drag", "opening", "volume")
    ]
    for scene in quick.data["work_precision"]["scene"].unique():
        assert scene in quick.text
    assert "nan" not in quick.text
