"""Motion by time step and bars: what a cell is called, and the quick map."""

import numpy as np
import pytest

from validation.motion_map import section


@pytest.fixture(scope="module")
def quick():
    return section(quick=True)


def test_the_quick_map_passes_its_checks(quick):
    assert len(quick.verdicts) == 3
    for verdict in quick.verdicts:
        assert verdict.passed, f"{verdict.claim} {verdict.found}"


def test_every_run_has_its_cell_and_what_it_is_called_is_what_its_errors_say(quick):
    cells = quick.data["motion_map"]
    assert len(cells) == 12
    worst = cells[["depth_error", "pull_error"]].max(axis=1, skipna=False)
    assert ((cells["kind"] == "WRONG") == (worst > 0.1)).all()
    assert ((cells["kind"] == "refused") == worst.isna()).all()
    assert (cells["work"] > 0.0).all()


def test_the_error_falls_with_the_step(quick):
    for _, own in quick.data["motion_map"].groupby(["law", "bars"]):
        assert np.all(np.diff(own.sort_values("step_s")["depth_error"]) > 0.0)


def test_both_pictures_are_drawn_from_it(quick):
    assert [picture.name for picture in quick.pictures] == ["motion_map", "motion_work_precision"]
    assert f"![{quick.pictures[0].name}]" in quick.text
