"""What acts on a net in a case of a plan: the current, the catch (by its law in ``catch_models``) and wet weight."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from catch_models.pressure import PressureLaw, sphere_law, sphere_law_through, uniform_law
from codend.bag.bag import Bag
from codend.errors import InputError
from codend.io.input_table import read_table
from codend.mechanics.pressure import FILLED_MESHES, FRONT_FROM_CODLINE, VOLUME, Catch
from codend.mechanics.problem import Problem
from codend.mechanics.water import uniform_flow
from codend.mechanics.weight import GRAVITY_M_S2
from codend.plan.plan import Case, Plan


def problem_of(bag: Bag, plan: Plan, case: Case) -> Problem:
    """The net of a bag under the loads of one of the cases of its plan.

    Wet weight, of twine and straps whose density the plan gives and of a catch that is not as dense as the water, acts
    on full nets only: it has no place in a sector.
    """
    water = uniform_flow(plan.tow.water_density_kg_m3, np.array([case.speed_m_s, 0.0, 0.0]))
    return Problem.of(bag.net, water=water, weight=bag.net.order == 1, catch=catch_of(bag, plan, case))


def in_case(problem: Problem, bag: Bag, plan: Plan, case: Case) -> Problem:
    """The same net under the loads of another case of the plan, without anything that touches."""
    flow = uniform_flow(plan.tow.water_density_kg_m3, np.array([case.speed_m_s, 0.0, 0.0]))
    return replace(problem, loading=problem.loading._replace(water=flow, catch=catch_of(bag, plan, case)))


def catch_of(bag: Bag, plan: Plan, case: Case) -> Catch:
    """The catch of a case in the rows and bands of a bag."""
    pressure_law = pressure_law_of(plan)
    kind, size = {
        "filled_meshes": (FILLED_MESHES, case.catch_value),
        "front_from_codline_m": (FRONT_FROM_CODLINE, case.catch_value),
        "volume_m3": (VOLUME, case.catch_value),
        "mass_kg": (VOLUME, case.catch_value / plan.catch_density_kg_m3),
    }[case.catch_kind]
    return Catch(
        bar_band=bag.bar_band,
        facet_band=bag.facet_band,
        band_meshes=bag.band_meshes,
        node_row=bag.node_row,
        row_size=bag.ring_size,
        kind=kind,
        size=float(size),
        stagnation_pressure=0.5 * plan.tow.water_density_kg_m3 * case.speed_m_s**2,
        angles=np.ascontiguousarray(pressure_law.angles_rad),
        coefficients=np.ascontiguousarray(pressure_law.coefficients),
        weight_density=catch_weight_density(plan) if bag.net.order == 1 else 0.0,
    )


def catch_weight_density(plan: Plan) -> float:
    """Weight in water of a cubic metre of the catch, N/m3; below 0 where it floats."""
    return GRAVITY_M_S2 * (plan.catch_density_kg_m3 - plan.tow.water_density_kg_m3)


def pressure_law_of(plan: Plan) -> PressureLaw:
    """Pressure law of the plan's catch.

    Raises:
        InputError: the plan's own Cp curve cannot be used.
    """
    if plan.catch.pressure == "uniform":
        return uniform_law(plan.catch.coefficient)
    if plan.catch.sphere_cp is not None:
        theta_deg, cp = np.array(plan.catch.sphere_cp).T
        return sphere_law_through(theta_deg, cp)
    if plan.sphere_cp_path is None:
        return sphere_law()
    return _law_of_curve(plan.sphere_cp_path)


def _law_of_curve(path: Path) -> PressureLaw:
    table = read_table(path, names=("theta_deg", "cp"))
    theta_deg, cp = table.numbers("theta_deg"), table.numbers("cp")
    try:
        return sphere_law_through(theta_deg, cp)
    except ValueError:
        allowed = "angles that rise from 0 to 180 degrees"
        raise InputError(table.where, "theta_deg", None, allowed, "does not run over the whole sphere") from None
