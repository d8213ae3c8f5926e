"""The judges of the contact section: the closed form of a chain on a floor, and what is found of it."""

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.colors import to_hex

from codend.solvers import gentle, interior_point
from validation.contact import PULL_N, WEIGHT_N_M, carried_n, on_a_floor
from validation.stability.drawing import COLOURS, picture_of
from validation.stability.judge import Finding, Judgement
from validation.stability.maps import Axis, Cell, Panel, StabilityMap


@pytest.mark.parametrize("z", [0.5, 2.0, 3.0])
def test_jointed_bars_carry_what_their_catenary_does_as_they_get_shorter(z):
    catenary = WEIGHT_N_M * np.sqrt(z**2 + 2.0 * PULL_N / WEIGHT_N_M * z)
    off = [abs(carried_n(bars, z) / catenary - 1.0) for bars in (50, 5000)]
    assert off[1] < 1e-6
    assert off[1] < 0.01 * off[0] + 1e-7


@pytest.mark.parametrize("by", [interior_point.solve, gentle.solve])
@pytest.mark.parametrize("gap", [1e-5, 0.02])
def test_a_chain_laid_on_a_floor_carries_what_the_closed_form_does(by, gap):
    assert on_a_floor(50, 2.0, gap, 10.0, by)[1].finding is Finding.RIGHT


def test_a_chain_that_carries_more_than_the_closed_form_is_found_out():
    def wrong(problem, tolerance):
        found = interior_point.solve(problem, tolerance)
        lower = np.where(np.arange(len(found.positions)) <= 50, 3e-6, 0.0)
        return replace(found, positions=found.positions - lower[:, None] * [0.0, 0.0, 1.0])

    assert on_a_floor(50, 2.0, 1e-5, 10.0, wrong)[1].finding is Finding.WRONG


def test_every_finding_is_drawn_in_its_own_colour():
    one = Axis("one", (1.0,), ("one",))
    cells = [(Cell("p", 1.0, 1.0, Judgement(kind, 0.0, 0.0, 0.0, ""), "", 0, 0.0, ""),) for kind in Finding]
    rows = Axis("kind", tuple(range(1, len(cells) + 1)), tuple(kind.name for kind in Finding))
    figure = picture_of(StabilityMap("map", "map", "", (Panel("p", one, rows, tuple(cells)),))).figure
    (drawn,) = figure.axes[0].collections
    figure.canvas.draw()
    assert [to_hex(colour) for colour in drawn.get_facecolors()] == [COLOURS[kind] for kind in Finding]
