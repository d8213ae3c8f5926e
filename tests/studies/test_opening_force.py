"""The force that opens a mesh in the net, against other solvers, symmetry, and what must follow from it."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner

from codend.bag.bag import mesh_corners
from codend.bag.build import build_bag
from codend.bag.loads import problem_of
from codend.bag.measures import mesh_openings
from codend.cli.main import main
from codend.equilibrium import solve as equilibrium
from codend.equilibrium.bag_model import model_of
from codend.equilibrium.start_shapes import START, all_round_start
from codend.errors import InputError
from codend.solvers import dynamic_relaxation, interior_point, newton
from codend.solvers.interior_point import InteriorPointSettings
from codend.solvers.outcome import Outcome, Solution
from codend.studies import opening_force as pulling
from codend.studies.opening_force import pull_mesh
from tests.cli.test_cli import TINY_PLAN
from tests.plans import joined_plan, make_plan
from validation.plain_nets import plain_net, plain_problem

SOFT = {"axial_stiffness_n": 300.0}
PLANS = {
    "diamond": {},
    "soft diamond": {"netting": SOFT},
    "knotted": {"netting": {"knot_mm": 5.0, **SOFT}},
    "t90": {"mesh": "t90", "netting": {"knot_mm": 5.0, **SOFT}},
}


def hooked_problem(plan, pulled_m):
    """A full net with one mesh between hooks: its bag, its loads, where it starts from, and the mesh."""
    case = plan.cases()[0]
    sector = model_of(plan, 1, 1)
    _, solution = equilibrium.solve(sector, case, (), None)
    sectors = sector.bag.net.order
    start = all_round_start(sector.bag, solution.positions, solution.bar_tension, sectors)
    bag = build_bag(plan, sectors=sectors)
    bag = replace(bag, net=replace(bag.net, positions=start.positions))
    mesh = pulling._middle_mesh(bag, 10)
    right, left = bag.mesh_sides[mesh, 0, 1:], bag.mesh_sides[mesh, 2, 1:]
    abeam = start.positions[right[0]] - start.positions[left[0]]
    hooked = pulling._with_hooks(bag, right, left, abeam / np.linalg.norm(abeam), 0.3, pulled_m)
    tension = np.append(start.bar_tension, [0.0, 0.0])
    start = replace(start, positions=hooked.net.positions, bar_tension=tension)
    return hooked, problem_of(hooked, plan, case), start, mesh


@pytest.mark.parametrize("name", PLANS)
def test_the_interior_point_finds_the_equilibrium_that_newton_finds_where_no_bar_goes_slack(name):
    plan = make_plan(24, 20, filled=8.0, **PLANS[name])
    case = plan.cases()[0]
    model = model_of(plan, 1, 1)
    problem, expected = equilibrium.solve(model, case, (), None)
    start = replace(expected, bar_tension=np.full_like(expected.bar_tension, expected.bar_tension.mean()))
    found = interior_point.solve(problem, 1e-9, start, prepared=newton.prepare(problem.structure, problem.bands))
    assert found.report.outcome is Outcome.CONVERGED
    np.testing.assert_allclose(found.positions, expected.positions, atol=1e-6)
    np.testing.assert_allclose(found.bar_tension, expected.bar_tension, atol=1e-4 * expected.bar_tension.max())


def test_square_mesh_is_not_pulled_open():
    square, behind = ("square", 12, 8, 40.0, {}), ("diamond", 12, 8, 40.0, {})
    plan = joined_plan(square, behind, entry=0.06)
    with pytest.raises(InputError, match="a place in diamond or T90 netting"):
        pull_mesh(plan, plan.cases()[0], 4.0)
    with pytest.raises(InputError, match="diamond or T90 netting somewhere"):
        pull_mesh(joined_plan(square, entry=0.06), plan.cases()[0])


def test_a_pulled_net_with_slack_bars_is_the_one_that_relaxation_finds():
    plan = make_plan(12, 12, filled=4.0, netting={"axial_stiffness_n": 3000.0})
    bag, problem, start, mesh = hooked_problem(plan, 8e-3)
    found = interior_point.solve(problem, 1e-9, start, prepared=newton.prepare(problem.structure, problem.bands))
    relaxed = dynamic_relaxation.solve(problem, 2e-10, start)
    assert found.report.outcome is relaxed.report.outcome is Outcome.CONVERGED
    assert np.any(found.bar_tension == 0.0)
    assert found.bar_tension[-2:] == pytest.approx(relaxed.bar_tension[-2:], rel=1e-5)
    openings = [mesh_openings(bag, mesh_corners(bag, s.positions))[0][mesh] for s in (found, relaxed)]
    assert openings[0] == pytest.approx(openings[1], abs=1e-4)
    assert found.bar_tension[-1] == pytest.approx(found.bar_tension[-2], rel=1e-6), "the mesh is pulled evenly"


def test_a_mesh_alone_between_hooks_takes_the_force_of_its_closed_form():
    """2 T cos(a/2) = P and 2 T sin(a/2) = F at the knots of a rhombus with opening a: F = P tan(a/2)."""
    side, load, opening, hook = 0.04, 7.0, np.radians(30.0), 0.5
    half = side * np.sin(opening / 2.0)
    positions = np.array(
        [[0, 0, 0], [side, 1e-3, 0], [side, -1e-3, 0], [2 * side, 0, 0], [side, hook, 0], [side, -hook, 0]]
    )
    fixed = np.array([[1, 1, 1], [0, 0, 1], [0, 0, 1], [0, 1, 1], [0, 1, 1], [0, 1, 1]], dtype=bool)
    bars = np.array([[0, 1], [1, 3], [0, 2], [2, 3], [1, 4], [2, 5]])
    lengths = np.array([side] * 4 + [hook - half] * 2)
    problem = plain_problem(plain_net(positions, fixed, bars, lengths), np.array([0, 1, 1, 2, 1, 1]))
    problem.loading.dead[3, 0] = load
    start = Solution(positions, np.full(6, load), np.zeros(problem.bands), START)
    found = interior_point.solve(problem, 1e-9, start, prepared=newton.prepare(problem.structure, problem.bands))
    assert found.report.outcome is Outcome.CONVERGED
    assert found.bar_tension[-2:] == pytest.approx(load * np.tan(opening / 2.0), rel=1e-7)


def test_neighbours_make_a_mesh_harder_to_open_and_the_more_the_wider():
    plan = make_plan(24, 20, filled=5.0, netting=SOFT)
    case = plan.cases()[0]
    pulls = [pull_mesh(plan, case, 8.0, wanted) for wanted in (20.0, 30.0)]
    for pull in pulls:
        assert pull.converged
        assert pull.meshes_from_entry == 8.0
        assert pull.opening_deg < pull.wanted_opening_deg
        assert pull.opening_force_in_net_n > pull.opening_force_alone_n > 0.0
        assert pull.sectors == 24
        assert 0.0 <= pull.opening_force_in_net_error_n < 0.01 * pull.opening_force_in_net_n
    assert pulls[1].opening_force_in_net_n > pulls[0].opening_force_in_net_n


@pytest.mark.parametrize("netting", [{}, {"axial_stiffness_n": 20_000.0}])
def test_the_error_covers_what_sectors_left_out_change(netting, monkeypatch):
    plan = make_plan(60, 20, filled=4.0, bar_mm=30.0, netting=netting)
    case = plan.cases()[0]
    whole = pull_mesh(plan, case, 8.0)
    monkeypatch.setattr(pulling, "WHOLE", 1)
    monkeypatch.setattr(pulling, "ENOUGH", 0.5)
    narrow = pull_mesh(plan, case, 8.0)
    assert narrow.sectors < whole.sectors == 60
    off = abs(narrow.opening_force_in_net_n - whole.opening_force_in_net_n)
    assert off <= narrow.opening_force_in_net_error_n


def test_a_mesh_that_is_open_already_needs_no_pull():
    plan = make_plan(24, 20, filled=8.0)
    pull = pull_mesh(plan, plan.cases()[0], 11.5, 10.0)
    assert pull.converged
    assert pull.opening_deg > 10.0
    assert pull.opening_force_in_net_n == 0.0 > pull.opening_force_alone_n


def test_by_default_the_mesh_ahead_of_the_catch_that_needs_most_is_pulled():
    plan = make_plan(24, 20, filled=5.0, netting=SOFT)
    case = plan.cases()[0]
    chosen = pull_mesh(plan, case)
    assert 0.0 < chosen.meshes_from_entry <= 15.0
    for place in (2.0, 8.0, 14.0):
        assert pull_mesh(plan, case, place).opening_force_alone_n <= chosen.opening_force_alone_n


def test_a_pull_that_fails_has_no_number_and_tells_what_it_tried(monkeypatch):
    monkeypatch.setattr(pulling, "PULL", InteriorPointSettings(steps_allowed=2))
    plan = make_plan(24, 20, filled=5.0, netting=SOFT)
    pull = pull_mesh(plan, plan.cases()[0], 8.0)
    assert not pull.converged
    assert np.isnan(pull.opening_force_in_net_n)
    assert any("interior point" in line for line in pull.attempts)


@pytest.mark.parametrize("closing_deg", [0.0, 0.1])
def test_a_pull_that_the_mesh_does_not_follow_has_failed_and_says_so(closing_deg, monkeypatch):
    plan = make_plan(24, 20, filled=5.0, netting=SOFT)
    case = plan.cases()[0]
    before = pull_mesh(plan, case, 8.0, 1.0).opening_deg
    measured = pulling.mesh_openings

    def unmoved(bag, corners):
        return np.full(len(corners), before - closing_deg), measured(bag, corners)[1]

    monkeypatch.setattr(pulling, "mesh_openings", unmoved)
    pull = pull_mesh(plan, case, 8.0)
    assert not pull.converged
    assert np.isnan(pull.opening_force_in_net_n)
    assert pull.opening_deg == before
    pulls = [line for line in pull.attempts if "pulled by" in line]
    assert len(pulls) == pulling.MOST_PULLS
    assert all("did not follow" in line for line in pulls)


@pytest.mark.parametrize("place", [0.0, 20.0, -1.0, float("nan")])
def test_a_place_outside_the_codend_is_refused(place):
    plan = make_plan(24, 20)
    with pytest.raises(InputError, match=r"--at = .* above 0 and below 20"):
        pull_mesh(plan, plan.cases()[0], place)


def test_the_command_writes_its_table_and_says_what_twine_without_stretch_does(tmp_path):
    (tmp_path / "plan.toml").write_text(TINY_PLAN)
    arguments = [
        "opening-force",
        str(tmp_path / "plan.toml"),
        "--out",
        str(tmp_path / "out"),
        "--at",
        "8",
        "--opening",
        "20",
    ]
    result = CliRunner().invoke(
        main, [*arguments, "--set", "netting.0.axial_stiffness_n=300", "catch.filled_meshes=[4,5]"]
    )
    assert result.exit_code == 0, result.output
    assert "does not stretch" not in result.output
    table = pd.read_csv(tmp_path / "out" / "opening_force.csv")
    assert list(table["filled_meshes"]) == [4.0, 5.0]
    assert (table["opening_force_in_net_n"] > table["opening_force_alone_n"]).all()
    assert "does not stretch" in CliRunner().invoke(main, [*arguments, "--opening", "4"]).output


@pytest.mark.parametrize("name", ["diamond", "knotted", "t90"])
def test_half_of_a_mirrored_net_carries_the_force_of_the_whole(name, monkeypatch):
    plan = make_plan(24, 20, filled=5.0, **PLANS[name])
    case = plan.cases()[0]
    half = pull_mesh(plan, case, 8.0)
    assert any("one half" in line for line in half.attempts)
    monkeypatch.setattr(pulling, "_mirrored", lambda bag, mesh, problem: (bag, None))
    whole = pull_mesh(plan, case, 8.0)
    assert not any("one half" in line for line in whole.attempts)
    assert half.opening_force_in_net_n == pytest.approx(whole.opening_force_in_net_n, rel=1e-7)
    assert half.slack_bars == whole.slack_bars
