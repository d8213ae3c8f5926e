"""Pulsing codends: slow heave follows the equilibria, a sector is the whole net, and what is refused."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner

import codend
from codend.bag.loads import problem_of
from codend.cli.main import main
from codend.errors import InputError
from codend.mechanics.loads import add_moving_force
from codend.mechanics.problem import no_catch
from codend.solvers import dynamic_relaxation
from codend.solvers.motion import Motion
from codend.solvers.pulsing import BagWater, PulsingBag
from codend.studies.pulse import first_steps, in_steps, pulse, surge

NETTING = {"mesh": "diamond", "meshes_round": 24, "meshes_long": 12, "bar_mm": 60.0, "twine_mm": 4.0}
PLAN = {
    "title": "A small codend",
    "tow": {"speed_m_s": 1.5},
    "entry": {"radius_m": 0.2},
    "netting": [{**NETTING, "axial_stiffness_n": 2000.0}],
    "catch": {"filled_meshes": 4.0},
    "model": {"fidelity": "sector"},
}


SMALL = (
    'title = "p"\n[tow]\nspeed_m_s = 1.5\n[entry]\nradius_m = 0.2\n[catch]\nfilled_meshes = 4.0\n'
    '[model]\nfidelity = "sector"\n[vessel]\nheave_m = 0.2\nperiod_s = [4.0, 6.0]\n'
    "[time]\nperiods = 3\noutputs_a_period = 8\nstep_s = 0.02\n[[netting]]\n"
    'mesh = "diamond"\nmeshes_round = 24\nmeshes_long = 12\nbar_mm = 60.0\ntwine_mm = 4.0\n'
)


def heaved(period_s, heave_m, **more):
    tables = {"vessel": {"heave_m": heave_m, "period_s": period_s}, "time": {"periods": 3, "step_s": 0.02}}
    return codend.Plan.from_dict({**PLAN, **tables, **more})


def in_first_steps(plan, period_s):
    result = codend.solve(plan).cases[0]
    return in_steps(plan, result, period_s, first_steps(plan, period_s)).table


def off_the_equilibria(period_s, **more):
    """Largest departure of drag from that of equilibria at the speed of the moment, for the same swing of speed."""
    plan = heaved(period_s, 0.2 * period_s / (2.0 * np.pi), **more)
    table = in_first_steps(plan, period_s)
    last = table[table["time_s"] >= 2.0 * period_s]
    speeds = np.linspace(1.25, 1.75, 11)
    still = codend.solve(codend.Plan.from_dict({**PLAN, **more, "tow": {"speed_m_s": speeds.tolist()}})).table
    # drag goes nearly as the square
    share = np.interp(last["entry_speed_m_s"], speeds, still["drag_n"] / speeds**2)
    return np.abs(last["drag_n"] / (share * last["entry_speed_m_s"] ** 2) - 1.0).max()


STIFF = {**NETTING, "knot_mm": 10.0, "bending_stiffness_n_m2": 2e-4, "rest_opening_deg": 30.0}
KINDS = {
    "twine that stretches": {},
    "stiff T0": {"netting": [STIFF]},
    "stiff T90": {"netting": [{**STIFF, "mesh": "t90"}]},
    "a snug layer": {"layer": [{**NETTING, "meshes_round": 12, "bar_mm": 110.0, "meshes_from_codline": [0, 8]}]},
}


@pytest.mark.parametrize("more", KINDS.values(), ids=KINDS)
def test_a_codend_heaved_ever_more_slowly_follows_the_equilibria_to_the_first_order(more):
    fast, slow = off_the_equilibria(8.0, **more), off_the_equilibria(32.0, **more)
    assert slow < 0.01
    assert fast / slow == pytest.approx(4.0, rel=0.2)


@pytest.mark.parametrize("more", list(KINDS.values())[1:], ids=list(KINDS)[1:])
def test_pulses_of_stiff_twine_and_under_layers_stand_when_the_step_is_halved(more):
    plan = heaved(4.0, 0.2, time={"periods": 3, "outputs_a_period": 16}, **more)
    result = codend.solve(plan).cases[0]
    found = pulse(plan, result, 4.0)
    assert found.settled
    finer = in_steps(plan, result, 4.0, round(4.0 / 16 / found.step_s) * 4)
    assert finer.changes_from(found)["opening_ahead_deg"] < 0.1
    assert finer.changes_from(found)["opening_ahead_deg"] <= found.off["opening_ahead_deg"]


def test_netting_is_moved_as_by_the_scheme_of_ropes():
    """Two methods, no catch: the tow point's pull while it surges, of a net that is drawn out by its drag."""
    plan = heaved(4.0, 0.2, netting=[NETTING])
    result = codend.solve(plan).cases[0]
    loaded = problem_of(result.bag, plan, result.case)
    problem = replace(loaded, loading=loaded.loading._replace(catch=no_catch(loaded.net)))
    start = dynamic_relaxation.solve(problem, 1e-9, result.solution)
    assert start.report.outcome.converged
    heave, little = (lambda t: np.array([0.1 * surge(t, 2.0), 0.0, 0.0])), BagWater(np.full(len(start.positions), 1e-9))
    held = problem.net.fixed.all(axis=1)
    still = Motion(problem, start.positions, towed=held, path=heave)
    implicit = PulsingBag(problem, start, 1.5, little, heave)
    pulls: list[list[float]] = [[], []]
    for _ in range(300):
        still.step(4e-3)
        pulls[0].append(float(still.support[held, 0].sum()))
        implicit.step(4e-3)
        pulls[1].append(float(implicit.support[held, 0].sum()))
    by_ropes, found = np.array(pulls[0][1:]), np.array(pulls[1][:-1])
    assert np.abs(found - by_ropes).max() < 0.01 * np.ptp(by_ropes)


def test_a_bag_is_held_by_its_loads_and_the_change_of_its_momentum():
    plan = heaved(4.0, 0.3)
    result = codend.solve(plan).cases[0]
    problem, solution = problem_of(result.bag, plan, result.case), result.solution
    bag = BagWater.of(problem, solution.positions, solution.share, result.measures.catch_volume_m3, 1025.0)
    motion = PulsingBag(problem, solution, 1.5, bag, lambda t: np.array([0.3 * surge(t, 4.0), 0.0, 0.0]))
    for _ in range(60):
        motion.step(0.02)
    held = motion.towed
    free = motion.problem.structure.free > 0.0
    assert np.abs(motion.support[free]).max() < 1e-8 * np.abs(motion.support[held]).max()
    # the water and the catch alone are nearly all that has mass
    before = motion.now.velocity
    motion.step(0.02)
    change = float(bag.mass @ (motion.now.velocity - before)[:, 0]) / 0.02
    load = np.zeros_like(before)
    add_moving_force(
        motion.now.solution.positions, motion.now.velocity, problem.structure, motion.loading,
        motion.now.solution.share, load,
    )  # fmt: skip
    assert -motion.support[held, 0].sum() == pytest.approx(load[:, 0].sum() - change, rel=0.02)


def test_a_pulsing_sector_is_the_pulsing_net():
    found = []
    for fidelity in ("sector", "full"):
        plan = heaved(4.0, 0.3, model={"fidelity": fidelity}, time={"periods": 3, "outputs_a_period": 8})
        found.append(in_first_steps(plan, 4.0))
    for column in ("drag_n", "opening_ahead_deg", "speed_m_s"):
        # a full net has no axis to hold its codline to: round-off grows
        assert found[1][column].to_numpy() == pytest.approx(found[0][column].to_numpy(), rel=1e-6)


def test_a_pulsing_sector_between_real_ropes_is_the_pulsing_net():
    rope = {"number": 2, "shortening": 0.1, "diameter_mm": 24.0}
    found = []
    for fidelity in ("sector", "full"):
        plan = heaved(2.0, 0.1, model={"fidelity": fidelity}, rope=[rope], time={"periods": 3, "outputs_a_period": 8})
        result = codend.solve(plan).cases[0]
        assert result.net.order == (2 if fidelity == "sector" else 1)
        found.append(in_steps(plan, result, 2.0, 32).table)
    for column in ("drag_n", "opening_ahead_deg", "speed_m_s"):
        assert found[1][column].to_numpy() == pytest.approx(found[0][column].to_numpy(), rel=1e-9)


def test_netting_that_presses_on_itself_is_not_followed_as_if_it_did_not():
    plan = heaved(4.0, 0.2)
    result = codend.solve(plan).cases[0]
    pressed = replace(result, followed=replace(result.followed, contact_share=0.1))
    with pytest.raises(ArithmeticError, match="its netting lies on itself"):
        pulse(plan, pressed, 4.0)


def test_a_stiff_codend_that_swings_by_itself_is_told_not_to_have_come_to_a_period():
    """Its swings grow as much in steps of any length: twice in 4 s, of 2 mm of heave."""
    stiff = [{**STIFF, "bending_stiffness_n_m2": 1e-3}]
    plan = heaved(4.0, 0.002, netting=stiff, time={"periods": 8, "outputs_a_period": 20})
    result = codend.solve(plan).cases[0]
    long, short = in_steps(plan, result, 4.0, 5), in_steps(plan, result, 4.0, 10)
    assert result.converged
    assert not result.unstable
    for found in (long, short):
        swing = [np.ptp(found.table["opening_ahead_deg"].to_numpy()[20 * i : 20 * i + 21]) for i in (4, 5, 6, 7)]
        assert np.divide(swing[1:], swing[:-1]).min() > 1.3
        assert found.unlike_before_deg > 0.05
    assert short.unlike_before_deg == pytest.approx(long.unlike_before_deg, rel=0.5)
    still = heaved(4.0, 0.2, time={"periods": 6, "outputs_a_period": 20})
    assert in_steps(still, codend.solve(still).cases[0], 4.0, 8).unlike_before_deg < 0.05


def test_a_pulse_without_an_answer_says_where_and_in_what_steps_each_run_ended(monkeypatch):
    import codend.studies.pulse as pulses

    plan = heaved(4.0, 0.2, time={"periods": 3, "outputs_a_period": 8, "step_s": 0.1})
    result = codend.solve(plan).cases[0]

    def long_steps_only(plan, result, period_s, steps, progress=None):
        if steps > 5:
            raise ArithmeticError(f"no balance was found after {steps} s")
        return in_steps(plan, result, period_s, steps)

    monkeypatch.setattr(pulses, "in_steps", long_steps_only)
    monkeypatch.setattr(pulses, "RUNS", 3)
    expected = (
        "in steps of 50 ms no balance was found after 10 s; in steps of 25 ms no balance was found after 20 s; "
        "steps of 100 ms led to its end, their error not known"
    )
    with pytest.raises(ArithmeticError) as raised:
        pulse(plan, result, 4.0)
    assert str(raised.value) == expected


def test_cases_that_are_not_followed_are_told_beside_those_that_are(tmp_path, monkeypatch):
    import codend.studies.pulse as pulses

    def second_fails(plan, result, period_s, progress=None):
        if result.case.number == 2:
            raise ArithmeticError("it cannot be followed")
        return pulse(plan, result, period_s, progress)

    monkeypatch.setattr(pulses, "pulse", second_fails)
    file, out = tmp_path / "plan.toml", tmp_path / "out"
    file.write_text(SMALL.replace("filled_meshes = 4.0", "filled_meshes = [4.0, 5.0]").replace("[4.0, 6.0]", "[4.0]"))
    done = CliRunner().invoke(main, ["scene", str(file), "--out", str(out)])
    assert done.exit_code == 3, done.output
    assert "Not followed: case 2, period 4 s: it cannot be followed." in done.output
    assert pd.read_csv(out / "pulse_range.csv")["case"].tolist() == [1]


def test_steps_are_halved_until_ranges_stand_and_what_they_change_is_what_is_told():
    plan = heaved(4.0, 0.4, netting=[NETTING], time={"periods": 3, "outputs_a_period": 16, "step_s": 0.1})
    result = codend.solve(plan).cases[0]
    found = pulse(plan, result, 4.0)
    steps = round(4.0 / 16 / found.step_s)
    assert found.settled
    off: dict[str, float] = {"drag_n": 0.0, "opening_ahead_deg": 0.0}
    tried = first_steps(plan, 4.0)
    last = in_steps(plan, result, 4.0, tried)
    while tried < steps:
        tried *= 2
        now = in_steps(plan, result, 4.0, tried)
        off = {name: max(change, 0.25 * off[name]) for name, change in now.changes_from(last).items()}
        last = now
    assert found.off == pytest.approx(off)
    # of the second order: what is left is a third of that
    finer = in_steps(plan, result, 4.0, 2 * steps)
    assert finer.changes_from(found)["opening_ahead_deg"] < 0.6 * found.off["opening_ahead_deg"]


def test_a_strap_without_a_diameter_moves_with_the_knots_it_runs_through():
    strap = {"meshes_from_codline": 6, "circumference_share": 0.3}
    plan = heaved(4.0, 0.2, strap=[strap], time={"periods": 3, "outputs_a_period": 8})
    table = in_first_steps(plan, 4.0)
    result = codend.solve(plan).cases[0]
    assert result.measures.opening_ahead_deg == pytest.approx(table["opening_ahead_deg"].iloc[0], rel=1e-6)
    assert table["drag_n"].iloc[-1] == pytest.approx(table["drag_n"].iloc[-9], rel=0.05)


def test_a_pulse_starts_in_the_equilibrium_and_ends_in_its_period():
    plan = heaved(5.0, 0.3)
    result = codend.solve(plan).cases[0]
    found = pulse(plan, result, 5.0)
    table = found.table
    assert table["drag_n"].iloc[0] == pytest.approx(result.measures.drag_n, rel=1e-3)
    assert table["opening_ahead_deg"].iloc[0] == pytest.approx(result.measures.opening_ahead_deg, rel=1e-6)
    second, third = (table["drag_n"].to_numpy()[i : i + 40] for i in (40, 80))
    assert third == pytest.approx(second, rel=0.05)
    pressure = 0.5 * 1025.0 * table["speed_m_s"] * table["speed_m_s"].abs()
    assert table["stagnation_pressure_pa"].to_numpy() == pytest.approx(pressure.to_numpy())
    assert found.least.measures.opening_ahead_deg < result.measures.opening_ahead_deg
    assert found.most.measures.opening_ahead_deg > result.measures.opening_ahead_deg


@pytest.mark.parametrize(
    ("tables", "message"),
    [
        ({"vessel": {"heave_m": 1.0, "period_s": 4.0}}, r"vessel\.heave_m = 1\.0 .* never stops"),
        ({"vessel": {"heave_m": 0.2, "period_s": 4.0}, "model": {"fidelity": "meridian"}}, r"pulses as a net of bars"),
        ({"time": {"periods": 4}}, r"vessel is missing"),
        ({"vessel": {"period_s": 4.0}}, r"vessel\.heave_m is missing"),
    ],
)
def test_heave_that_makes_no_sense_is_refused(tables, message):
    with pytest.raises(InputError, match=message):
        codend.Plan.from_dict({**PLAN, **tables})


def test_the_command_writes_the_pulse_and_its_ranges(tmp_path):
    file, out = tmp_path / "plan.toml", tmp_path / "out"
    file.write_text(SMALL)
    done = CliRunner().invoke(main, ["scene", str(file), "--out", str(out)])
    assert done.exit_code == 0, done.output
    assert {path.name for path in out.iterdir()} == {"pulse.csv", "pulse_range.csv", "pulse.png", "results.csv"}
    found = pd.read_csv(out / "pulse_range.csv")
    assert found["period_s"].tolist() == [4.0, 6.0]
    swing = found["most_opening_ahead_deg"] - found["least_opening_ahead_deg"]
    assert swing[0] > swing[1] > 0.0
