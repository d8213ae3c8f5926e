"""Netting that lies in folds on the catch: told, and told apart from netting that lies smooth."""

import numpy as np
import pytest
from click.testing import CliRunner

from codend.bag.build import build_bag
from codend.bag.loads import problem_of
from codend.cli.main import main
from codend.mechanics.possible import inward_share
from codend.solvers import newton
from codend.solvers.outcome import Outcome
from codend.studies.study import solve
from tests.plans import joined_plan, make_plan

KINDS = [
    ("diamond", {}),
    ("diamond", {"knot_mm": 8.0}),
    ("t90", {"knot_mm": 8.0}),
    ("square", {}),
]
STIFF_AT_THE_CODLINE = """title = "Stiff T90 twine"
tow = {speed_m_s = 1.9, water_density_kg_m3 = 1026.0}
entry = {radius_m = 0.187}
catch = {filled_meshes = 3.5}
model = {fidelity = "sector"}

[[netting]]
mesh = "t90"
meshes_round = 48
meshes_long = 12
bar_mm = 54.0
knot_mm = 12.0
twine_mm = 2.7
bending_stiffness_n_m2 = 4.5e-4
rest_opening_deg = 63.0
"""
WIDE_BEHIND_NARROW = """title = "More squares than diamonds"
tow = {speed_m_s = 1.0, water_density_kg_m3 = 1000.0}
entry = {radius_m = 0.45}
catch = {filled_meshes = 10}

[[netting]]
mesh = "diamond"
meshes_round = 60
meshes_long = 30
bar_mm = 42.0
knot_mm = 8.0
twine_mm = 4.0

[[netting]]
mesh = "square"
meshes_round = 80
meshes_long = 40
bar_mm = 50.0
twine_mm = 4.0
"""


@pytest.mark.parametrize(("mesh", "netting"), KINDS)
@pytest.mark.parametrize("sectors", [1, 2, None])
def test_two_knots_of_a_ring_that_change_places_lay_their_meshes_in_folds(mesh, netting, sectors):
    plan = make_plan(24, 20, mesh=mesh, netting=netting)
    bag = build_bag(plan, sectors=sectors)
    problem = problem_of(bag, plan, plan.cases()[0])
    solution = newton.solve(problem, 1e-8)

    def folded(positions):
        return inward_share(positions, problem.structure, problem.loading.catch, solution.share)

    assert folded(solution.positions) == 0.0
    for row in (bag.bands - 2, 2):
        ring = np.flatnonzero(bag.node_row == row)
        y, z = solution.positions[ring, 1], solution.positions[ring, 2]
        first, second = ring[np.argsort(np.arctan2(z, y))[[0, -1]]]
        swapped = solution.positions.copy()
        swapped[[first, second]] = swapped[[second, first]]
        in_catch = row > 2 and len(ring) > 1
        assert (folded(swapped) > 0.0) == in_catch


@pytest.mark.parametrize("model", ["sector", "full"])
def test_a_net_that_sags_is_in_no_folds_for_that(model):
    plan = make_plan(12, 10, filled=4.0, netting={"twine_density_kg_m3": 1400.0}, speed=0.5, model={"fidelity": model})
    assert solve(plan).cases[0].measures.folded_share == 0.0


def test_the_command_names_cases_whose_netting_lies_in_folds(tmp_path):
    (tmp_path / "plan.toml").write_text(STIFF_AT_THE_CODLINE)
    told = CliRunner().invoke(main, ["run", str(tmp_path / "plan.toml"), "--out", str(tmp_path / "out")])
    assert told.exit_code == 0
    assert "Netting on the catch lies in folds" in told.output
    assert "Netting on the catch lies in folds" in (tmp_path / "out" / "report.html").read_text()
    limp = solve(joined_plan(("diamond", 18, 10, 40.0, {}), ("diamond", 12, 10, 40.0, {}))).table
    assert limp["folded_share"].item() == 0.0


def test_folds_that_pass_through_one_another_are_refused(tmp_path):
    (tmp_path / "plan.toml").write_text(WIDE_BEHIND_NARROW)
    told = CliRunner().invoke(main, ["run", str(tmp_path / "plan.toml"), "--out", str(tmp_path / "out")])
    assert told.exit_code == 3
    assert Outcome.PASSED_THROUGH.value[:40] in told.output
