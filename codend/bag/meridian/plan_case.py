"""A case of a plan as a problem of the meridian method, and its shape as a start for the net."""

from dataclasses import replace

import numpy as np

from codend.bag.bag import Bag
from codend.bag.loads import pressure_law_of
from codend.bag.meridian.problem import Floats, MeridianProblem, MeridianShape
from codend.bag.meridian.solve import solve_meridian, uniform_pressure_shape
from codend.errors import InputError
from codend.mechanics.water import VISCOSITY_M2_S
from codend.net.net import Ints
from codend.plan.kinds import kinds_in_words
from codend.plan.plan import Case, Plan
from codend.solvers.outcome import Outcome

METHOD = "meridian"
MEAN_COEFFICIENT = 1.4
"""Uniform pressure over q that stands in for the sphere's law in a first guess."""


def why_not(plan: Plan) -> str:
    """What keeps the meridian method from a start for a plan, in words; empty if nothing does."""
    if len(plan.netting) > 1:
        return "it takes one section of netting"
    if not plan.netting[0].kind.membrane:
        return f"it takes {kinds_in_words(lambda kind: kind.membrane)} netting"
    if plan.netting[0].tapers:
        return "it takes as many meshes round all along"
    return ""


def why_not_exactly(plan: Plan) -> str:
    """What keeps the method's answer from being the plan's, in words; empty if nothing does."""
    if reason := why_not(plan):
        return reason
    if plan.netting[0].bending_stiffness_n_m2 > 0.0:
        return "it knows no bending stiffness"
    if plan.ropes:
        return "it knows no ropes or selvedges"
    if plan.window:
        return "it knows no windows"
    return "it knows no straps" if plan.strap else ""


def solve_case(plan: Plan, case: Case) -> MeridianShape:
    """Shape of a case by the meridian method, its front found for whatever the catch is given by.

    Its ``outcome`` says whether it is one; a catch too large for the bag, or too small for a membrane, has none.

    Raises:
        InputError: the plan is not one the method takes.
    """
    reason = why_not_exactly(plan)
    if reason:
        raise InputError(
            file=plan.source, key="model.fidelity", value="meridian", allowed=f"another fidelity; {reason}"
        )
    return _under_its_loads(plan, case)


def _under_its_loads(plan: Plan, case: Case) -> MeridianShape:
    """Shape of a case whose twine is taken as limp."""
    if case.catch_kind == "filled_meshes":
        return solve_meridian(problem_for(plan, case, _rows(plan) - 2.0 * case.catch_value))
    from scipy.optimize import brentq

    wanted = case.catch_value / (plan.catch_density_kg_m3 if case.catch_kind == "mass_kg" else 1.0)

    def solved(front_row: float) -> MeridianShape:
        shape = solve_meridian(problem_for(plan, case, front_row))
        if not shape.converged:
            raise _NoShape(shape)
        return shape

    def excess(shape: MeridianShape) -> float:
        by_front = case.catch_kind == "front_from_codline_m"
        return (shape.length_m - shape.front_x_m if by_front else shape.catch_volume_m3) - wanted

    most_row, least_row = 0.0, _rows(plan) - 0.5
    try:
        if excess(most := solved(most_row)) < 0.0:
            return replace(most, outcome=Outcome.OVERFULL)
        if excess(least := solved(least_row)) > 0.0:
            return replace(least, outcome=Outcome.TOO_SMALL)
        return solved(float(brentq(lambda row: excess(solved(row)), most_row, least_row, xtol=1e-10)))
    except _NoShape as error:
        return error.shape


class _NoShape(Exception):
    """A trial in the search for the front that was not solved."""

    def __init__(self, shape: MeridianShape) -> None:
        super().__init__(shape.outcome.value)
        self.shape = shape


def first_guess(plan: Plan, case: Case) -> MeridianShape | None:
    """Shape of limp twine under uniform pressure without drag: near the answer and cheap; None where there is none.

    It knows no straps, and none is given where one would be tight.
    """
    if why_not(plan) or case.catch_kind != "filled_meshes":
        return None
    coefficient = plan.catch.coefficient if plan.catch.pressure == "uniform" else MEAN_COEFFICIENT
    try:
        shape = uniform_pressure_shape(problem_for(plan, case, _rows(plan) - 2.0 * case.catch_value), coefficient)
    except ValueError:
        return None
    return shape if shape.converged and _within_straps(plan, shape) else None


def _within_straps(plan: Plan, shape: MeridianShape) -> bool:
    """Whether the shape leaves all straps slack."""
    places = zip(plan.straps, plan.strap_rows, strict=True)
    return all(2.0 * np.pi * shape.radius_m[_rows(plan) - row] <= strap.around_m for strap, row in places)


def tensions_on(bag: Bag, shape: MeridianShape, rows: Ints | slice = slice(None)) -> Floats:
    """Tension of the real bars that every bar of a sector laid out along rows of the shape stands for, N, (m,)."""
    tension, phi = shape.bar_tension_n[rows], shape.half_angle_rad[rows]
    by_band = 0.5 * (tension[:-1] + tension[1:])
    phi = 0.5 * (phi[:-1] + phi[1:])
    tension, phi = by_band[bag.bar_band], phi[bag.bar_band]
    # a knot carries what its two twines pull with, along the netting or across it
    across = bag.node_row[bag.net.bars[:, 0]] == bag.node_row[bag.net.bars[:, 1]]
    knot_tension = 2.0 * tension * np.where(across, np.sin(phi), np.cos(phi))
    tension = np.where(bag.bar_is_twine, tension, knot_tension)
    tension[bag.straps] = tension[bag.ropes] = 0.0
    return tension


def share_of(shape: MeridianShape, bands: int) -> Floats:
    """Share of each band that lies in the catch, in meshes, (bands,)."""
    return np.clip(np.arange(1.0, bands + 1.0) - shape.front_row, 0.0, 1.0)


def _rows(plan: Plan) -> int:
    return plan.netting[0].rows_per_mesh * plan.netting[0].meshes_long


def problem_for(plan: Plan, case: Case, front_row: float) -> MeridianProblem:
    """Problem of the meridian method for a plan of one section, the catch's front at a half-mesh row."""
    section = plan.netting[0]
    normal, tangential = plan.drag.coefficients
    return MeridianProblem(
        meshes_round=section.open_meshes[0],
        half_mesh_rows=_rows(plan),
        bar_m=section.bar_m,
        entry_radius_m=plan.entry_radius_m,
        front_row=max(front_row, 0.0),
        stagnation_pressure_pa=0.5 * plan.tow.water_density_kg_m3 * case.speed_m_s**2,
        pressure_law=pressure_law_of(plan),
        mesh=section.mesh,
        knot_m=section.knot_m,
        drag_width_m=section.drag_width_m,
        drag_law=plan.drag.law,
        normal_drag=normal,
        tangential_drag=tangential,
        speed_m_s=case.speed_m_s,
        reynolds_per_speed=section.twine_m / VISCOSITY_M2_S,
        axial_stiffness_n=section.axial_stiffness_n,
        knot_axial_stiffness_n=section.knot_axial_stiffness_n,
    )
