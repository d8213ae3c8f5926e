"""What a user has from Python."""

import numpy as np
import pytest

import codend
from codend.errors import InputError
from codend.net.net import with_point
from codend.selectivity.escape.species import example_species_path
from tests.plans import make_plan

TABLES = make_plan().to_dict()


@pytest.fixture(scope="module")
def study():
    return codend.solve(TABLES)


def test_a_plan_is_made_of_tables_and_changed_by_a_table():
    plan = codend.Plan.from_dict(TABLES, {"tow.speed_m_s": 1.25})
    assert plan.tow.speed_m_s == (1.25,)
    assert len(repr(plan)) < 120
    with pytest.raises(InputError, match=r"tow\.speed_m_s = -1 .*allowed"):
        codend.Plan.from_dict(TABLES, {"tow.speed_m_s": -1})


def test_changes_to_a_plan_are_those_of_its_tables(tmp_path):
    plain = {name: table for name, table in TABLES.items() if name != "drag"} | {"tow": {"speed_m_s": 1.0}}
    change = {"drag.law": "bessonneau-1997"}
    of_plan = codend.solve(codend.Plan.from_dict(plain), change).plan
    assert of_plan.to_dict() == codend.solve(plain, change).plan.to_dict()
    assert of_plan.drag.coefficients == (1.2, 0.1)
    assert of_plan.water_is_assumed
    assert codend.Plan.from_dict(plain).with_pressure(lambda theta: 1.4).water_is_assumed


def test_a_study_plots_and_writes_itself(study, tmp_path):
    assert study.plot("drag").axes
    assert {"report.html", "results.csv"} <= {path.name for path in study.write(tmp_path)}
    with pytest.raises(InputError, match="opening_force"):
        study.plot("everything")


def test_a_study_is_told_shortly(study):
    assert "1 of 1 cases solved" in repr(study)
    assert "drag_n" in study._repr_html_()


def test_a_law_of_pressure_of_ones_own_is_read_as_it_is(study, tmp_path):
    uniform = codend.solve(TABLES, {"catch.pressure": "uniform"})
    own = codend.Plan.from_dict(TABLES).with_pressure(lambda theta: 1.4 + 0.0 * np.asarray(theta))
    assert codend.solve(own).table["drag_n"].to_numpy() == pytest.approx(uniform.table["drag_n"].to_numpy(), rel=1e-9)
    codend.solve(own).write(tmp_path)
    assert codend.load_plan(tmp_path / "plan.toml").to_dict() == own.to_dict()


def test_a_curve_of_pressure_that_does_not_run_over_the_sphere_is_refused():
    with pytest.raises(InputError, match=r"catch\.sphere_cp"):
        codend.Plan.from_dict(TABLES, {"catch.sphere_cp": [[0, 1], [90, -1.2]]})


def test_fish_and_hauls_are_asked_by_one_call(study):
    table = codend.selectivity(study, example_species_path())
    assert list(table["case"]) == ["1", "haul"]
    assert callable(codend.fit)
    assert codend.selectivity.predicted is not None


def test_a_net_of_ones_own_is_solved_measured_and_drawn():
    nodes = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]])
    net = codend.Net.from_bars(nodes, [[0, 1], [1, 2]], [True, False, True], length_m=1.2, stiffness_n=1e5)
    problem = codend.Problem.of(with_point(net, 1, wet_weight_n=10.0))
    found = codend.find_equilibrium(problem)
    load, support = codend.loads_and_supports(problem, found)
    assert support[[0, 2]].sum(axis=0) == pytest.approx(-load.sum(axis=0), abs=1e-6)
    assert support[0, 2] == pytest.approx(5.0)
    assert len(codend.draw(problem, found).axes) == 4
