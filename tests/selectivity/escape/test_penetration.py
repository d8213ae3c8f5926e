from itertools import pairwise

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog

from catch_models.fish import FishSection
from codend.bag.measures import opening_force
from codend.selectivity.escape.penetration import Holes, hole_corners, hole_sides, longest_fish, longest_through_rhombus

OPENINGS = np.linspace(1.0, 179.0, 90)
HOLES = {
    "rhombus": Holes.of("diamond", 0.05, 50.0),
    "hexagon with knots along": Holes.of("diamond", 0.045, 62.0, knot_m=0.012),
    "hexagon with knots across": Holes.of("t90", 0.045, 35.0, knot_m=0.012),
    "square": Holes.of("square", 0.05, 90.0),
}
SECTIONS = {"ellipse": FishSection(0.1, 0.07), "superellipse": FishSection(0.09, 0.05, 3.4)}


# --- closed form -----------------------------------------------------------------------------------------------------


@given(
    height=st.floats(0.02, 0.4),
    width=st.floats(0.02, 0.4),
    opening=st.floats(0.5, 179.5),
    bar=st.floats(0.005, 0.3),
)
@settings(max_examples=200, deadline=None)
def test_closed_form_and_convex_test_agree_on_ellipses_in_rhombi(height, width, opening, bar):
    closed = longest_through_rhombus(2.0 * bar, opening, height, width)
    # a knot far too short to matter sends the search through the general path
    general = longest_fish(Holes.of("diamond", bar, opening, knot_m=1e-15), FishSection(height / 2, width / 2))
    np.testing.assert_allclose(general, closed, rtol=1e-9)
    np.testing.assert_allclose(
        longest_fish(Holes.of("diamond", bar, opening), FishSection(height / 2, width / 2)), closed
    )


def test_round_fish_fills_the_inscribed_circle():
    diameter = 0.17
    for opening in (10.0, 60.0, 90.0, 130.0):
        inscribed = 0.05 * np.sin(np.radians(opening))
        found = longest_fish(Holes.of("diamond", 0.05, opening), FishSection(diameter / 2, diameter / 2))
        np.testing.assert_allclose(found, inscribed / diameter, rtol=1e-12)


@pytest.mark.parametrize(("height", "width"), [(0.2, 0.14), (0.14, 0.2), (0.3, 0.06)])
def test_best_opening_has_the_tangent_squared_of_its_half_equal_to_width_over_height(height, width):
    fine = np.linspace(1.0, 179.0, 178_001)
    longest = longest_through_rhombus(0.1, fine, height, width)
    best = 2.0 * np.degrees(np.arctan(np.sqrt(width / height)))
    # with the other orientation there are two equally good openings, b and 180 - b
    assert min(abs(fine[np.argmax(longest)] - best), abs(fine[np.argmax(longest)] - 180.0 + best)) < 2e-3
    np.testing.assert_allclose(longest.max(), 0.1 / (height + width), rtol=1e-9)


def test_longest_fish_is_proportional_to_the_mesh_and_nothing_passes_a_closed_one():
    section = SECTIONS["ellipse"]
    small, large = (longest_fish(Holes.of("diamond", bar, OPENINGS), section) for bar in (0.03, 0.09))
    np.testing.assert_allclose(large, 3.0 * small, rtol=1e-12)
    assert longest_fish(Holes.of("diamond", 0.05, 0.0), section).item() == 0.0
    assert longest_fish(Holes.of("diamond", 0.05, 0.0, knot_m=0.01), section).item() == 0.0


# --- the general test against independent ones -----------------------------------------------------------------------


@pytest.mark.parametrize("section", SECTIONS.values(), ids=SECTIONS)
@pytest.mark.parametrize("holes", HOLES.values(), ids=HOLES)
@pytest.mark.parametrize("rotation_deg", [0.0, 23.0, 61.0])
def test_a_linear_programme_that_may_also_move_the_fish_aside_finds_no_longer_fish(holes, section, rotation_deg):
    corners = hole_corners(holes, 0)
    edges = np.roll(corners, -1, axis=0) - corners
    normals = np.stack([edges[:, 1], -edges[:, 0]], axis=1)  # outward: corners run anticlockwise
    offset = np.einsum("ij,ij->i", normals, corners)
    assert (offset > 0.0).all()
    turn = np.radians(rotation_deg)
    outline = section.outline(40_001) @ np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    reach = (normals @ outline.T).max(axis=1)
    # largest L with L * reach + normal . t <= offset for some shift t
    found = linprog(
        [-1.0, 0.0, 0.0], np.column_stack([reach, normals]), offset, bounds=[(0, None)] + 2 * [(None, None)]
    )
    np.testing.assert_allclose(longest_fish(holes, section, rotation_deg=rotation_deg), found.x[0], rtol=1e-6)


@pytest.mark.parametrize("section", SECTIONS.values(), ids=SECTIONS)
@pytest.mark.parametrize("holes", HOLES.values(), ids=HOLES)
def test_fish_dropped_at_random_pass_up_to_the_longest_and_never_beyond(holes, section):
    """Monte-Carlo drop test: outlines with random rotation and shift, every point tested against the corners."""
    rng = np.random.default_rng(3)
    longest = longest_fish(holes, section).item()
    corners = hole_corners(holes, 0)
    after = np.roll(corners, -1, axis=0)
    outline = section.outline(181)

    def passes(length: float, spread: float, drops: int, turns: np.ndarray) -> np.ndarray:
        turn = np.resize(turns, drops)
        shift = rng.normal(0.0, spread * longest, (drops, 2))
        cosine, sine = np.cos(turn), np.sin(turn)
        x = length * (outline[:, 0] * cosine[:, None] - outline[:, 1] * sine[:, None]) + shift[:, :1]
        y = length * (outline[:, 0] * sine[:, None] + outline[:, 1] * cosine[:, None]) + shift[:, 1:]
        inside = np.ones(drops, dtype=bool)
        for (ax, ay), (bx, by) in zip(corners, after, strict=True):
            inside &= ((bx - ax) * (y - ay) - (by - ay) * (x - ax) >= 0.0).all(axis=1)
        return inside

    anywhere = rng.uniform(0.0, np.pi, 4000)
    assert not passes(1.002 * longest, 0.01, 4000, anywhere).any()
    assert passes(0.985 * longest, 0.001, 4000, anywhere).any()


@given(
    kind=st.sampled_from(["diamond", "t90", "square"]),
    knot=st.floats(0.0, 0.04),
    opening=st.floats(5.0, 150.0),
    ratio=st.floats(0.2, 5.0),
    exponent=st.floats(1.3, 8.0),
)
@example(kind="t90", knot=0.03125, opening=5.0, ratio=0.25, exponent=1.5)
@example(kind="t90", knot=0.03125, opening=52.0, ratio=2.375, exponent=3.125)
@example(kind="diamond", knot=6.103515625e-05, opening=5.0, ratio=4.0, exponent=1.375)
@settings(max_examples=150, deadline=None)
def test_no_rotation_beats_the_one_found(kind, knot, opening, ratio, exponent):
    section = FishSection(0.1 * np.sqrt(ratio), 0.1 / np.sqrt(ratio), exponent)
    holes = Holes.of(kind, 0.05, opening, knot_m=0.0 if kind == "square" else knot)
    normal, distance = hole_sides(holes, 0)
    turns = np.radians(np.linspace(0.0, 180.0, 7201))
    supports = section.support(normal[:, None] - turns)
    dense = (distance[:, None] / supports).min(axis=0).max()
    assert longest_fish(holes, section).item() >= dense * (1.0 - 1e-9)


def test_sides_and_corners_describe_the_same_hole():
    for holes in HOLES.values():
        normal, distance = hole_sides(holes, 0)
        used = np.isfinite(distance)
        corners = hole_corners(holes, 0)
        reach = np.abs(np.stack([np.cos(normal), np.sin(normal)], axis=1)[used] @ corners.T).max(axis=1)
        np.testing.assert_allclose(reach, distance[used], rtol=1e-12)


def test_ellipse_is_the_superellipse_of_exponent_two():
    holes = HOLES["hexagon with knots along"]
    found = longest_fish(holes, FishSection(0.1, 0.07, 2.0 + 1e-12), rotation_deg=17.0)
    np.testing.assert_allclose(found, longest_fish(holes, FishSection(0.1, 0.07), rotation_deg=17.0), rtol=1e-9)


# --- yielding meshes -------------------------------------------------------------------------------------------------


def test_a_push_opens_a_mesh_as_far_as_the_opening_force_of_the_mechanics_says():
    tension, opening, wanted = 7.0, 20.0, 41.0
    force = float(opening_force(np.array(tension), np.array(opening), wanted))
    load = 2.0 * tension * np.cos(np.radians(opening) / 2.0)
    section = FishSection(0.1, 0.09)  # best at 87 degrees: it wants the mesh as wide as it can be had
    pushed = longest_fish(Holes.of("diamond", 0.05, opening, load_n=load), section, push_force_n=force)
    rigid = longest_fish(Holes.of("diamond", 0.05, wanted), section)
    np.testing.assert_allclose(pushed, rigid, rtol=1e-7)


def test_a_push_never_hinders_and_slack_netting_takes_the_best_shape():
    section = FishSection(0.1, 0.07)
    for kind, knot in (("diamond", 0.0), ("diamond", 0.01), ("t90", 0.01)):
        taut = Holes.of(kind, 0.05, OPENINGS, knot_m=knot, load_n=5.0)
        lengths = [longest_fish(taut, section, push_force_n=force) for force in (0.0, 0.1, 1.0, 10.0)]
        assert all((more >= less * (1.0 - 1e-12)).all() for less, more in pairwise(lengths))
    slack = Holes.of("diamond", 0.05, OPENINGS, load_n=0.0)
    np.testing.assert_allclose(longest_fish(slack, section, push_force_n=1e-9), 0.1 / 0.34, rtol=1e-6)


@pytest.mark.parametrize("kind", ["diamond", "t90"])
@pytest.mark.parametrize("knot_m", [0.0, 0.012])
@pytest.mark.parametrize("exponent", [1.6, 2.0, 3.0])
def test_a_push_finds_the_best_of_all_openings_within_its_reach(kind, knot_m, exponent):
    section, bar, load = FishSection(0.11, 0.06, exponent), 0.05, 4.0
    for opening, push in ((15.0, 0.5), (60.0, 3.0), (110.0, 8.0), (30.0, 100.0)):
        across = load * np.tan(np.radians(opening) / 2.0)
        reach = np.arctan2([across, across + push], [load + push, load])
        tried = np.degrees(2.0 * np.linspace(*reach, 400))
        brute = longest_fish(Holes.of(kind, bar, tried, knot_m=knot_m), section).max()
        holes = Holes.of(kind, bar, opening, knot_m=knot_m, load_n=load)
        found = longest_fish(holes, section, push_force_n=push).item()
        assert brute * (1.0 - 1e-9) <= found < brute * 1.005


def test_square_mesh_does_not_yield():
    holes, section = Holes.of("square", 0.05, 90.0, load_n=1.0), FishSection(0.1, 0.07)
    assert longest_fish(holes, section, push_force_n=100.0) == longest_fish(holes, section)
