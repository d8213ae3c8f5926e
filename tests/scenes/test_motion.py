"""Nets in motion: closed forms, balances, orders, stops and starts."""

import numpy as np
import pytest
from scipy.special import jn_zeros

from codend.errors import InputError
from codend.mechanics.drag_laws import drag
from codend.mechanics.problem import Problem
from codend.mechanics.water import uniform_flow
from codend.mechanics.weight import GRAVITY_M_S2
from codend.net.net import Net, with_point
from codend.scenes.build import build
from codend.scenes.follow import follow, heave, largest_jump, motion_rows, path_of
from codend.scenes.measures import lies_in_zigzag, solve_scene
from codend.scenes.scene import scene_from_dict
from codend.solvers.motion import Motion
from tests.scenes.test_scene import GEAR, WARP, tow

STEEL, WATER = 7850.0, 1025.0


def line(nodes, held, diameter=0.01, density=STEEL, law=("le-bris-1999", 0.0, 0.0), stiffness=np.inf, length=None):
    nodes = np.asarray(nodes, dtype=float)
    ends = np.stack([np.arange(len(nodes) - 1), np.arange(1, len(nodes))], axis=1)
    return Net.from_bars(
        nodes, ends, held, diameter_m=diameter, density_kg_m3=density, drag=drag(*law), stiffness_n=stiffness,
        length_m=length, is_rope=True,
    )  # fmt: skip


def in_water(net, flow=(0.0, 0.0, 0.0)):
    return Problem.of(net, water=uniform_flow(WATER, np.array(flow)))


def swing_period(bars, length=1.0, swing=1e-4):
    """Of a hanging chain let go in the shape of its slowest swing."""
    s = np.linspace(0.0, length, bars + 1)
    first = jn_zeros(0, 1)[0]
    from scipy.special import j0

    nodes = np.stack([swing * j0(first * np.sqrt(1.0 - s / length)), 0.0 * s, -s], axis=1)
    motion = Motion(in_water(line(nodes, s == 0.0, length=length / bars)), nodes)
    times, ends = [], []
    dt = 0.004
    while motion.time < 1.6:
        times.append(motion.time)
        ends.append(motion.position[-1, 0])
        motion.step(dt)
    ends = np.array(ends)
    down = np.flatnonzero((ends[:-1] > 0.0) & (ends[1:] <= 0.0))[0]
    return 4.0 * (times[down] + dt * ends[down] / (ends[down] - ends[down + 1]))


def test_a_hanging_chain_swings_in_its_own_time_to_the_second_order_in_the_bars():
    # in water g gives way to w / (m + m_a)
    g = GRAVITY_M_S2 * (STEEL - WATER) / (STEEL + WATER)
    right = 2.0 * np.pi / (0.5 * jn_zeros(0, 1)[0] * np.sqrt(g))
    coarse, fine = (abs(swing_period(bars) / right - 1.0) for bars in (10, 40))
    assert fine < 3e-4
    assert coarse > 10.0 * fine


def test_a_level_cable_sinks_as_the_hyperbolic_tangent_to_the_second_order_in_the_step():
    # V = Vt tanh(t / tau), tau = (m + m_a) Vt / w
    diameter, normal = 0.012, 1.36
    area = np.pi * diameter**2 / 4.0
    weight, mass = (STEEL - WATER) * area * GRAVITY_M_S2, (STEEL + WATER) * area
    fastest = np.sqrt(weight / (0.5 * WATER * diameter * normal))
    tau = mass * fastest / weight

    def error(dt):
        x = np.linspace(0.0, 1.0, 3)
        nodes = np.stack([x, 0 * x, 0 * x], axis=1)
        motion = Motion(in_water(line(nodes, x > 2.0, diameter, law=("le-bris-1999", normal, 0.0))), nodes)
        for _ in range(round(1.0 / dt)):
            motion.step(dt)
        depth = fastest * tau * np.log(np.cosh(motion.time / tau))
        return abs(-motion.position[1, 2] / depth - 1.0)

    fine, coarse = error(0.01), error(0.04)
    assert fine < 2e-4
    assert coarse > 12.0 * fine


@pytest.mark.parametrize("acceleration", [0.0, 2.0, -3.0])
def test_a_line_heaved_with_a_mass_carries_weight_less_mass_times_acceleration(acceleration):
    # T = Ww + w L - (M + m L) a, a downward; the line moves along itself, so it has no added mass
    s = np.linspace(0.0, 10.0, 11)
    nodes = np.stack([0 * s, 0 * s, -s], axis=1)
    net = with_point(line(nodes, s == 0.0), 10, mass_kg=20.0, wet_weight_n=150.0)
    path = lambda t: np.array([0.0, 0.0, -0.5 * acceleration * t * t])  # noqa: E731
    motion = Motion(in_water(net), nodes, towed=s == 0.0, path=path)
    for _ in range(5):
        motion.step(0.01)
    mass = STEEL * np.pi * 0.01**2 / 4.0 * 10.0
    weight = (STEEL - WATER) / STEEL * mass * GRAVITY_M_S2
    assert motion.support[0, 2] == pytest.approx(150.0 + weight - (20.0 + mass) * acceleration, rel=1e-6)


def test_a_line_dropped_faster_than_it_falls_goes_slack_and_is_caught():
    s = np.linspace(0.0, 10.0, 11)
    nodes = np.stack([0 * s, 0 * s, -s], axis=1)
    net = with_point(line(nodes, s == 0.0, stiffness=1e6, length=1.0), 10, mass_kg=20.0, wet_weight_n=60.0)
    path = lambda t: np.array([0.0, 0.0, -min(4.0 * t * t, 4.0)])  # noqa: E731
    motion = Motion(in_water(net), nodes, towed=s == 0.0, path=path)
    tensions = []
    for _ in range(160):
        motion.step(0.005)
        tensions.append(motion.tension.copy())
    # meanwhile the mass, with half of the last bar, falls freely
    half = 0.5 * np.pi * 0.01**2 / 4.0
    fall = (60.0 + half * (STEEL - WATER) * GRAVITY_M_S2) / (20.0 + half * STEEL)
    assert motion.position[-1, 2] == pytest.approx(-10.0 - 0.5 * fall * 0.8**2, rel=1e-4)
    assert np.all(np.array(tensions)[20:, -1] < 0.01)
    for _ in range(160):
        motion.step(0.005)
        tensions.append(motion.tension.copy())
    assert np.min(tensions) >= 0.0
    assert np.max(tensions) > 10.0 * 60.0


def towed_warp(**rope):
    return build(tow(rope))


@pytest.mark.parametrize("stiffness", [None, 1e6])
@pytest.mark.parametrize("law", ["le-bris-1999", "bessonneau-1997", "choo-casarella-1971"])
def test_momentum_and_loads_balance_what_the_vessel_pulls_in_every_step(law, stiffness):
    rope = {"law": law, "bars": 12, **({} if stiffness is None else {"axial_stiffness_n": stiffness})}
    if law != "le-bris-1999":
        rope |= {"normal": 1.0, "tangential": 0.1}
    built = towed_warp(**rope)
    motion = Motion(built.problem, built.problem.net.positions, added_mass=built.added_mass, towed=built.towed)
    for _ in range(100):
        motion.step(0.02)
        # what is left over at nodes that nothing holds: rate of momentum less loads and tensions
        scale = np.abs(motion.support[0]).max()
        assert np.abs(motion.support[~built.towed]).max() < 1e-8 * scale


def pushed(dt):
    """Places after 30 s of a gear on thin light twine that was pushed at 0.5 m/s, less those at rest."""
    built = build(tow({"diameter_mm": 1.0, "mass_kg_m": 8.1e-4, "bars": 20}))
    rest = solve_scene(built).solution.positions
    velocity = np.where(built.towed[:, None], 0.0, np.full(3, 0.5))
    motion = Motion(built.problem, rest, velocity, added_mass=built.added_mass, towed=built.towed)
    for _ in range(round(30.0 / dt)):
        motion.step(dt)
    assert motion.unsettled == 0
    return motion.position - rest


def test_no_step_is_too_long_for_thin_light_twine():
    # its drag answers within milliseconds, and it swings across itself 60 times a second
    assert np.abs(pushed(0.02)).max() < 0.1
    assert np.abs(pushed(0.1)).max() < 0.1
    assert np.abs(pushed(0.5)).max() < 0.2


def potential(motion):
    """Of weight and stretch, J."""
    net = motion.problem.net
    over = np.maximum(np.linalg.norm(np.diff(motion.position, axis=0), axis=1) / net.bar_length - 1.0, 0.0)
    stiffness = np.divide(1.0, net.bar_flexibility, out=np.zeros_like(over), where=net.bar_flexibility > 0.0)
    weight = float(motion.loading.dead[:, 2] @ motion.position[:, 2])
    return float(np.sum(0.5 * stiffness * net.bar_length * over**2)) - weight


@pytest.mark.parametrize(("law", "normal"), [("le-bris-1999", 1.2), ("bessonneau-1997", 1.2)])
@pytest.mark.parametrize("stiffness", [np.inf, 1e5])
def test_energy_never_grows_without_work(law, normal, stiffness):
    s = np.linspace(0.0, 2.0, 21)
    nodes = np.stack([s, 0 * s, 0 * s], axis=1)
    net = line(nodes, s == 0.0, law=(law, normal, 0.1), stiffness=stiffness, length=0.1)
    motion = Motion(in_water(net), nodes)
    found = []
    for _ in range(1500):
        before = potential(motion)
        motion.step(0.004)
        # velocities stand in the middle between the places before and after
        found.append(motion.kinetic_energy_j + 0.5 * (before + potential(motion)))
    scale = abs(found[0] - found[-1])
    assert np.diff(found).max() < 1e-3 * scale
    assert found[-1] < found[0]


def hung_up(bars, mass_kg=0.0, speed=2.0, stiffness=1e6, end_s=0.03, dt=1e-4, mass_kg_m=0.5):
    """A level rope under a steady pull, towed on while its far end is held fast: tension in time, and the pull."""
    length, pull = 100.0, 3000.0
    s = np.linspace(0.0, length * (1.0 + pull / stiffness), bars + 1)
    nodes = np.stack([s, 0 * s, 0 * s], axis=1)
    density = mass_kg_m / (np.pi * 0.012**2 / 4.0)
    net = line(nodes, s == s[-1], 0.012, density, stiffness=stiffness, length=length / bars)
    held = (s == s[-1]) | ((s == 0.0) & (mass_kg == 0.0))
    net = line(nodes, held, 0.012, density, stiffness=stiffness, length=length / bars)
    if mass_kg > 0.0:
        net = with_point(net, 0, mass_kg=mass_kg)
    problem = Problem.of(net, weight=False)
    velocity = np.zeros_like(nodes)
    velocity[:-1, 0] = -speed
    path = (lambda t: np.array([-speed * t, 0.0, 0.0])) if mass_kg == 0.0 else None
    motion = Motion(problem, nodes, velocity, towed=s == 0.0, path=path, added_mass=0.0)
    found = []
    while motion.time < end_s:
        motion.step(dt)
        found.append(motion.tension.copy())
    return np.array(found), pull


def test_a_stretched_warp_that_hangs_up_gives_the_waves_peak():
    # T0 + V sqrt(EA m) at the stop, until the wave returns from the vessel
    tensions, pull = hung_up(200)
    right = pull + 2.0 * np.sqrt(1e6 * 0.5)
    assert tensions[150:250, -1].mean() == pytest.approx(right, rel=5e-3)
    assert tensions[-1, 0] == pytest.approx(pull, rel=5e-3)


def test_a_mass_on_a_light_warp_that_hangs_up_gives_its_own_peak():
    # V sqrt(EA M / L) above none before
    tensions, pull = hung_up(20, 2000.0, end_s=1.5, dt=2e-3, mass_kg_m=0.002)
    stretch_m, rate = 100.0 * pull / 1e6, np.sqrt(1e6 / (100.0 * 2000.0))
    right = 1e6 / 100.0 * np.hypot(stretch_m, 2.0 / rate)
    assert tensions.max() == pytest.approx(right, rel=1e-2)


def test_a_gear_that_hangs_up_stays_on_the_ground_while_the_vessel_goes_on():
    # as dense as the water it lies along the flow, and is not moved across itself; what drag it loses would add to it
    mass_kg_m = WATER * np.pi * 0.012**2 / 4.0
    rope = {**WARP, "axial_stiffness_n": 1e6, "mass_kg_m": mass_kg_m, "bars": 100, "normal": 0.0}
    time = {"end_s": 0.36, "output_s": 0.002, "step_s": 2e-4}
    data = {"title": "h", "vessel": {"speed_m_s": 1.8}, "rope": [rope], "time": time}
    built = build(scene_from_dict({**data, "point": [{**GEAR, "wet_weight_n": 0.0, "held_from_s": 0.3}]}))
    start = solve_scene(built).solution.positions
    frames = list(follow(built, start))
    gear = built.node_of["gear"]
    # as seen from the vessel the ground goes aft
    assert frames[-1].positions[gear] - start[gear] == pytest.approx([1.8 * 0.06, 0.0, 0.0], abs=1e-9)
    tension = np.array([frame.bar_tension[-1] for frame in frames])
    before, after = tension[100], tension[155:170].mean()
    # V sqrt(EA m) on top of what it carried, until the wave returns
    assert after - before == pytest.approx(1.8 * np.sqrt(1e6 * mass_kg_m), rel=0.02)
    assert frames[-1].peaks[0, 0] >= after


def test_the_equilibrium_is_what_the_motion_comes_to():
    built = towed_warp(bars=20)
    rest = solve_scene(built)
    motion = Motion(built.problem, built.problem.net.positions, added_mass=built.added_mass, towed=built.towed)
    for _ in range(6000):
        motion.step(0.1)
    gear = built.node_of["gear"]
    assert motion.position[gear] == pytest.approx(rest.solution.positions[gear], rel=1e-4)
    assert motion.tension == pytest.approx(rest.solution.bar_tension, rel=1e-4)


def test_half_a_gear_with_its_plane_of_symmetry_is_the_whole_gear():
    bridle = {**WARP, "length_m": 20.0, "bars": 10, "from": "knot"}
    door = {"area_m2": 0.75, "drag": 0.5, "lift": 1.0, "mass_kg": 170.0, "wet_weight_n": 900.0}
    doors = [
        {"name": f"door {side}", "at": [119.0, sign * 3.0, 0.0], "lift_towards": [0, sign, 0.2], **door}
        for side, sign in (("a", 1.0), ("b", -1.0))
    ]
    warp = {**WARP, "to": "knot", "bars": 10}
    half_warp = {**warp, "mass_kg_m": 0.25, "normal": 0.68, "diameter_mm": 12.0}
    knot = {"name": "knot", "at": [100.0, 0.0, 0.0]}
    data = {"title": "doors", "vessel": {"speed_m_s": 1.8}}
    ropes = [{**bridle, "to": doors[0]["name"]}, {**bridle, "to": doors[1]["name"]}]
    whole = scene_from_dict({**data, "rope": [warp, *ropes], "point": [knot, *doors]})
    # half the warp's mass and drag; its volume is told apart by the wet weight of the knot below
    buoyant = 0.5 * WATER * np.pi * 0.012**2 / 4.0 * GRAVITY_M_S2
    half_warp |= {"length_m": 100.0, "added_mass": 0.5, "mass_kg_m": 0.25 + buoyant / GRAVITY_M_S2}
    half = scene_from_dict(
        {**data, "rope": [half_warp, ropes[0]], "point": [{**knot, "held": "symmetry"}, doors[0]]}
    )  # fmt: skip
    full, part = solve_scene(build(whole)), solve_scene(build(half))
    assert full.converged
    assert part.converged
    found = [r.solution.positions[r.built.node_of["door a"]] for r in (full, part)]
    assert found[1] == pytest.approx(found[0], rel=1e-6)
    pull = [r.support[r.built.towed].sum(axis=0) for r in (full, part)]
    assert 2.0 * pull[1][0] == pytest.approx(pull[0][0], rel=1e-6)


def shot(**time):
    data = {"title": "w", "vessel": {"speed_m_s": 1.8}, "rope": [{**WARP, "bars": 8}], "point": [GEAR]}
    return build(scene_from_dict({**data, "time": {"end_s": 3.0, "output_s": 0.5, "start": "placed", **time}}))


def test_a_motion_goes_on_from_any_output_as_if_it_had_never_stopped():
    built = shot()
    start = built.problem.net.positions
    frames = list(follow(built, start))
    again = list(follow(built, start, frames[3].state))
    assert [frame.number for frame in again] == [3, 4, 5, 6]
    for ours, theirs in zip(frames[3:], again, strict=True):
        assert motion_rows(built, ours)[1:] == motion_rows(built, theirs)[1:]
        assert np.array_equal(ours.positions, theirs.positions)
        assert np.array_equal(ours.peaks, theirs.peaks)


def test_a_vessel_that_heaves_moves_its_points_by_its_amplitude():
    data = {"title": "w", "vessel": {"speed_m_s": 1.8, "heave_m": 1.5, "period_s": 6.0}, "rope": [WARP]}
    built = build(scene_from_dict({**data, "point": [GEAR], "time": {"end_s": 18.0, "output_s": 0.5, "step_s": 0.05}}))
    frames = list(follow(built, solve_scene(built).solution.positions))
    heights = np.array([frame.positions[0, 2] for frame in frames])
    assert heights.max() == pytest.approx(1.5, rel=1e-9)
    pulls = np.array([np.linalg.norm(frame.support[0]) for frame in frames])
    assert pulls[12:].max() > 1.1 * pulls[0] > 1.1 * pulls[12:].min()


def test_a_vessel_that_follows_a_table_is_where_the_table_says(tmp_path):
    (tmp_path / "vessel.csv").write_text("time_s,x_m,y_m,z_m\n0,5,0,0\n4,-3,1,0\n")
    data = {"title": "w", "vessel": {"motion": "vessel.csv"}, "rope": [{**WARP, "bars": 6}], "point": [GEAR]}
    time = {"end_s": 3.0, "output_s": 1.0, "start": "placed"}
    built = build(scene_from_dict({**data, "time": time}, tmp_path / "scene.toml"))
    frames = list(follow(built, built.problem.net.positions))
    assert np.array([frame.positions[0] for frame in frames]) == pytest.approx(
        np.array([[-2.0 * t, 0.25 * t, 0.0] for t in range(4)]), abs=1e-9
    )


def test_a_table_of_motion_starts_where_the_vessel_is_at_time_0_and_goes_on_beyond_its_end():
    table = np.array([[-0.5, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.3], [10.0, -20.0, 0.0, 0.3]])
    path = path_of(None, table)
    np.testing.assert_allclose(path(0.0), 0.0)
    np.testing.assert_allclose(path(5.0), [-10.0, 0.0, 0.0])
    np.testing.assert_allclose(path(10.5), [-21.0, 0.0, 0.0])


def test_a_table_of_ten_rows_a_period_heaves_as_the_heave_it_was_taken_from():
    t, period, h = np.delete(np.linspace(0.0, 30.0, 51), [46, 47]), 6.0, 0.01  # two rows were lost
    table = np.stack([t, 0.0 * t, 0.0 * t, [1.5 * heave(at, period) for at in t]], axis=1)
    path = path_of(None, table)
    for at in np.linspace(6.6, 26.0, 60):
        wanted = np.array([1.5 * heave(at + k * h, period) for k in (-1, 0, 1)])
        found = np.array([path(at + k * h)[2] for k in (-1, 0, 1)])
        assert found == pytest.approx(wanted, abs=0.002)
        assert np.diff(found, 2) / h**2 == pytest.approx(np.diff(wanted, 2) / h**2, abs=0.04 * 1.5 * (np.pi / 3.0) ** 2)


def test_few_or_uneven_rows_are_straight_and_their_largest_jump_in_speed_is_known():
    table = np.array([[0, 0, 0, 0], [10, -20, 0, 0], [11, -21, 0, 0], [60, -21, 0, 0]], dtype=float)
    path = path_of(None, table)
    for at, x in ((5.0, -10.0), (10.5, -20.5), (11.0, -21.0), (35.0, -21.0), (61.0, -21.0)):
        assert path(at) == pytest.approx([x, 0.0, 0.0], abs=1e-12)
    assert largest_jump(table, 60.0) == pytest.approx((2.0, 0.0))
    assert largest_jump(np.array([[0.0, 0, 0, 0], [4, 0, 0, 0], [9, 0, 5, 0]]), 9.0) == pytest.approx((1.0, 4.0))


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        ("", "time_s has 0; allowed: two rows or more"),
        ("0,0,0,0\n", "time_s has 1; allowed: two rows or more"),
        ("0,0,0,0\n3,-3,0,0\n2,-2,0,0\n", "time_s = 2.0 .* rise from row to row"),
        ("0,0,0,0\n2,,0,0\n4,0,0,0\n", r'x_m = "\(empty\)" in line 3'),
        ("0,0,0,0\n2,nan,0,0\n4,0,0,0\n", 'x_m = "nan" in line 3'),
        ("0,0,0,0\n2,slow,0,0\n4,0,0,0\n", 'x_m = "slow" in line 3'),
        ("0,0,0,0\n2,-2,0,0\n2.001,-80,0,0\n4,-80,0,0\n", "go at 7.8e.04 m/s from 2 s on; allowed: at most 20 m/s"),
        ("1,0,0,0\n4,0,0,0\n", "does not run over the whole motion"),
    ],
)
def test_a_ragged_table_of_motion_is_one_line(tmp_path, rows, message):
    (tmp_path / "vessel.csv").write_text("time_s,x_m,y_m,z_m\n" + rows)
    data = {"title": "w", "vessel": {"motion": "vessel.csv"}, "rope": [WARP], "point": [GEAR]}
    with pytest.raises(InputError, match=message):
        scene_from_dict({**data, "time": {"end_s": 3.0, "output_s": 1.0}}, tmp_path / "scene.toml")


def test_the_peak_and_the_tension_of_an_output_are_told_by_one_rule():
    built = shot()
    frames = list(follow(built, built.problem.net.positions))
    rows = [next(row for row in motion_rows(built, frame) if row["name"] == "rope 1") for frame in frames]
    # what an output shows was noted in the step that starts there
    assert all(frame.peaks[0, 0] >= row["tension_n"] for frame, row in zip(frames, rows, strict=True))
    assert any(frame.peaks[0, 0] == row["tension_n"] for frame, row in zip(frames, rows, strict=True))


@pytest.mark.parametrize(("step_s", "told"), [(0.02, False), (0.1, False), (0.5, True), (1.0, True)])
@pytest.mark.parametrize("stiffness", [None, 1e6])
def test_steps_too_long_for_the_bars_are_seen_by_their_zigzag(step_s, told, stiffness):
    rope = {**WARP, "bars": 40, "axial_stiffness_n": stiffness}
    data = {"title": "w", "vessel": {"speed_m_s": 1.8}, "rope": [rope], "point": [GEAR]}
    time = {"end_s": 10.0, "output_s": 10.0, "step_s": step_s, "start": "placed"}
    built = build(scene_from_dict({**data, "time": time}))
    *_, last = follow(built, built.problem.net.positions)
    assert lies_in_zigzag(last.positions[built.rope_nodes[0]], last.bar_tension[built.rope_bars[0]]) == told


def test_a_rope_without_tension_may_lie_in_a_zigzag():
    nodes = np.array([[k, 0.2 * (k % 2), 0.0] for k in range(8)])
    assert lies_in_zigzag(nodes, np.ones(7))
    assert not lies_in_zigzag(nodes, np.zeros(7))
    assert not lies_in_zigzag(nodes[::2], np.ones(3))
