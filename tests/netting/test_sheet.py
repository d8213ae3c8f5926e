"""Sheets of netting cut from a lattice: counts of bars, meshes and edges, and how panels are cut."""

import numpy as np
import pytest

from codend.netting.sheet import diamond_sheet, square_sheet


@pytest.mark.parametrize(("across", "long"), [(1, 1), (6, 4), (30, 50)])
def test_a_sheet_has_the_bars_of_its_meshes(across, long):
    # a diamond mesh has four bars, each shared by two; half meshes at the sides have as many as the fore edge lacks
    assert len(diamond_sheet(across, across, long).bars) == 4 * across * long
    assert len(square_sheet(across, long).bars) == 2 * across * long + across + long
    assert len(square_sheet(across, long).meshes) == across * long
    assert square_sheet(across, long).outermost.sum() == 2 * (across + long)


@pytest.mark.parametrize("taper", ["both", "left", "right"])
@pytest.mark.parametrize(("across", "aft", "long"), [(20, 8, 30), (8, 20, 30), (40, 3, 20), (0, 12, 12), (31, 2, 7)])
def test_a_tapered_sheet_is_cut_by_whole_steps_to_the_meshes_of_both_edges(across, aft, long, taper):
    sheet = diamond_sheet(across, aft, long, taper)
    edges = sheet.edges
    assert len(edges["fore"].knots) == across + 1
    assert len(edges["aft"].knots) == aft + 1
    for side, first, last in (("left", 0, 0), ("right", -1, -1)):
        knots, place = edges[side].knots, edges[side].place
        assert knots[0] == edges["fore"].knots[first]
        assert knots[-1] == edges["aft"].knots[last]
        assert place[0] == 0.0
        assert place[-1] == 1.0
        assert np.all(np.diff(place) > 0.0)
    # every knot hangs together with all others, by two bars at least but at corners
    ends = np.bincount(sheet.bars.ravel(), minlength=len(sheet.share))
    assert ends.min() >= 1
    assert (ends == 4).sum() >= len(sheet.meshes) // 2
    assert np.all((sheet.share >= 0.0) & (sheet.share <= 1.0))


def test_an_all_bars_cut_runs_along_bars():
    sheet = diamond_sheet(20, 0, 10)
    left = sheet.edges["left"].knots
    bars = {tuple(sorted(bar)) for bar in sheet.bars.tolist()}
    assert all(tuple(sorted(pair)) in bars for pair in zip(left[:-1].tolist(), left[1:].tolist(), strict=True))


def test_facets_cover_whole_meshes_once():
    sheet = diamond_sheet(6, 6, 4)
    flat = np.stack([sheet.share[:, 0] * 6, sheet.share[:, 1] * 4], axis=1)
    a, b, c = (flat[sheet.facets[:, i]] for i in range(3))
    area = 0.5 * np.abs(_cross(b - a, c - a))
    # the half meshes at the edges are covered too, by the two thirds of rhombs drawn in their rows' shares
    assert (area * sheet.facet_weight).sum() == pytest.approx(24.0, rel=0.05)


def _cross(u, v):
    return u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
