"""What random plans gave before the rooms were moved and the net was taken apart, they give still.

``numbers_kept.csv`` was written by ``python -m validation.same_numbers`` then, at a tolerance of 1e-8. Two rows are
younger: plan 10 swings on its hoop (408.675 N where it is the same all round) and is followed now, and
the square mesh of plan 12 is modelled whole for its weight.
"""

from pathlib import Path

import pandas as pd
import pytest

from codend import solve
from validation.same_numbers import differences, random_plan

KEPT = pd.read_csv(Path(__file__).with_name("numbers_kept.csv")).set_index("number")


@pytest.mark.parametrize("number", KEPT.index)
def test_a_random_plan_gives_what_it_gave(number):
    table = solve(random_plan(0, number)).table
    expected = KEPT.loc[number].dropna()
    assert table[expected.index].iloc[0].to_dict() == pytest.approx(expected.to_dict(), rel=1e-6)


def test_a_value_that_moved_is_told_with_how_far():
    old = pd.DataFrame({"solved": ["a", "a"], "line": ["0", "0"], "column": ["drag_n", "kind"], "value": ["2.0", "x"]})
    new = old.assign(value=["2.1", "y"])
    assert differences(old, new).relative.tolist() == pytest.approx([0.1 / 2.1, float("inf")])
