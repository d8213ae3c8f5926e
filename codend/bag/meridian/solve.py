"""Shape and drag of a bag from the meridian equations: starts, solve, checks and measures."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from catch_models.pressure import UNIFORM_COEFFICIENT, uniform_law
from codend.bag.meridian.closed_form import ClosedForm, solve_closed_form
from codend.bag.meridian.collocation import Grid, NewtonResult, make_grid, middle_state, solve_newton
from codend.bag.meridian.problem import MeridianProblem, MeridianShape
from codend.bag.meridian.shell import Floats, Shell, axial_drag, bars_at
from codend.solvers.outcome import Outcome

_ROUND_OFF = 1e-9


def solve_meridian(problem: MeridianProblem, refinement: int = 1) -> MeridianShape:
    """Equilibrium under the problem's pressure law and twine drag, by fourth-order collocation and Newton's method.

    Newton starts from the closed form for uniform pressure. The answer says whether it may be used: ``converged`` is
    False, and ``outcome`` says why, when no start converged or the meridian found is no equilibrium of a towed bag.

    Args:
        problem: the bag and its catch.
        refinement: divides every step of the grid, to see what the discretisation does.
    """
    shell = problem.shell()
    grid = make_grid(shell, problem.half_mesh_rows, refinement)
    iterations = 0
    for name, start in _starts(shell, grid):  # never empty
        result = solve_newton(shell, grid, start)
        iterations += result.iterations
        shape = replace(_shape(problem, grid, result, f"collocation from {name}"), iterations=iterations)
        if shape.converged:
            break
    return shape


def uniform_pressure_shape(problem: MeridianProblem, coefficient: float = UNIFORM_COEFFICIENT) -> MeridianShape:
    """The same bag with p = ``coefficient`` q in the catch and no twine drag: by quadrature, a start for other methods.

    Where the closed form does not apply (see ``solve_closed_form``) the same problem is solved by collocation;
    ``method`` says which it was.

    Raises:
        ValueError: ``coefficient`` is not above 0; without pressure the shape is undetermined.
    """
    if not coefficient > 0.0:
        raise ValueError(f"coefficient = {coefficient} must be above 0")
    plain = replace(problem, pressure_law=uniform_law(coefficient), drag_width_m=0.0)
    shell = plain.shell()
    closed = solve_closed_form(shell)
    if closed is None:
        return solve_meridian(plain)
    grid = make_grid(shell, plain.half_mesh_rows)
    state = _closed_form_state(closed, coefficient, grid.t)
    return _shape(plain, grid, NewtonResult(state, closed.residual, closed.iterations, True), "quadrature")


def _starts(shell: Shell, grid: Grid) -> Iterator[tuple[str, Floats]]:
    """States to start Newton from, the likeliest first."""
    # the mean over the aft half stands for the law; a law of suction has no such start, and is tried from 1
    mean = float(np.mean(shell.pressure(np.linspace(0.5 * np.pi, np.pi, 7))))
    coefficient = mean if mean > 0.0 else 1.0
    closed = solve_closed_form(shell)
    if closed is not None:
        yield "the closed form", _closed_form_state(closed, coefficient, grid.t)
    # a neighbour the closed form holds for, in the same rows: no knots across, entry and front moved into its range
    front = min(max(shell.front, 0.02 * shell.rows), 0.98 * shell.rows)
    for entry in (min(shell.entry_radius, 0.7), 0.4, 0.2):
        neighbour = replace(
            shell,
            knot=shell.knot_along,
            knot_across=False,
            compliance=0.0,
            knot_compliance=0.0,
            front=front,
            entry_radius=entry,
        )
        closed = solve_closed_form(neighbour)
        if closed is not None:
            yield "a neighbour's closed form", _closed_form_state(closed, coefficient, grid.t)
    yield "a rough shape", _rough_state(shell, grid.t, coefficient)


def _closed_form_state(closed: ClosedForm, coefficient: float, t: Floats) -> Floats:
    """Radius, slope and ln Q at rows t: Q = C / (k l_s), from Q cos a = C r^2 and cos a = k r^2 l_s in the catch."""
    radius, phi, slope = closed.at(t)
    axial = closed.meridian.catch.axial[0, 0]
    return np.stack([radius, slope, np.log(coefficient / (axial * closed.netting.row_length(phi)))])


def _rough_state(shell: Shell, t: Floats, coefficient: float) -> Floats:
    """A tube of the limit radius, rounded to the codline and tapered ahead of the front towards the entry's radius."""
    widest = 0.8
    rounded = widest * np.tanh((shell.rows - t) / widest)
    front = widest * np.tanh((shell.rows - shell.front) / widest)
    tapered = front * np.exp(t - shell.front) + shell.entry_radius * np.exp(-t)
    radius = np.where(t > shell.front, rounded, np.minimum(tapered, widest))
    slope = np.arctan(np.gradient(radius, t) / 0.7)
    slope[-1] = -0.5 * np.pi
    return np.stack([radius, slope, np.full_like(t, np.log(coefficient * front**2))])


def _shape(problem: MeridianProblem, grid: Grid, result: NewtonResult, method: str) -> MeridianShape:
    """Measures of a state on a grid, integrated by Simpson's rule with the collocation's own midpoints."""
    shell, state = problem.shell(), result.state
    step = np.diff(grid.t)
    middle = middle_state(shell, grid, state)

    def integrals(ends: Floats, middles: Floats) -> Floats:
        return np.asarray(step / 6.0 * (ends[:-1] + 4.0 * middles + ends[1:]))

    def densities(at: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        """Per unit of t: axial length, volume, catch load (towards the tail) and twine drag."""
        radius, slope, log_force = at
        bars = bars_at(shell, radius, log_force)
        forward = bars.row_length * np.cos(slope)
        pressure = shell.pressure(np.clip(0.5 * np.pi - slope, 0.0, np.pi))
        load = -2.0 * pressure * radius * bars.row_length * np.sin(slope)
        return forward, radius**2 * forward, load, axial_drag(shell, bars, slope)

    lengths, volumes, loads, drags = (
        integrals(*pair) for pair in zip(densities(state), densities(middle), strict=True)
    )
    spread = problem.spread_radius_m
    force = np.pi * spread**2 * problem.stagnation_pressure_pa
    x = spread * np.concatenate([[0.0], np.cumsum(lengths)])
    radius, slope, log_force = state
    bars = bars_at(shell, radius, log_force)
    q = np.exp(log_force)
    catch_drag = force * float(loads @ grid.in_catch)
    twine_drag = force * float(drags @ (1.0 - grid.in_catch))
    reaction = force * float(q[0] * np.cos(slope[0]))
    outcome = Outcome.CONVERGED
    if not (result.converged and np.all(np.isfinite(state))):
        outcome = Outcome.NO_MERIDIAN
    elif np.any(np.cos(slope) < -_ROUND_OFF):
        outcome = Outcome.SLOPE_REVERSED
    elif np.any(radius < -_ROUND_OFF):
        outcome = Outcome.RADIUS_NEGATIVE
    volume = float(np.pi * spread**3 * (volumes @ grid.in_catch))
    if outcome is Outcome.CONVERGED and x[-1] < x[grid.front]:
        outcome = Outcome.FRONT_BEHIND
    elif outcome is Outcome.CONVERGED and not volume > 0.0:
        outcome = Outcome.NO_VOLUME
    rows = grid.rows
    return MeridianShape(
        x_m=x[rows],
        radius_m=spread * radius[rows],
        slope_rad=slope[rows],
        half_angle_rad=np.arctan2(bars.sine, bars.cosine)[rows],
        bar_tension_n=(force * q / (2.0 * problem.meshes_round * bars.cosine))[rows],
        front_row=problem.front_row,
        front_x_m=float(x[grid.front]),
        front_radius_m=float(spread * radius[grid.front]),
        largest_radius_m=spread * _largest_radius(step, state, bars.row_length),
        length_m=float(x[-1]),
        catch_volume_m3=volume,
        drag_n=catch_drag + twine_drag,
        catch_drag_n=catch_drag,
        twine_drag_n=twine_drag,
        entry_reaction_n=reaction,
        axial_imbalance=abs(reaction - catch_drag - twine_drag) / reaction,
        residual=result.residual,
        iterations=result.iterations,
        method=method,
        outcome=outcome,
    )


def _largest_radius(step: Floats, state: Floats, row_length: Floats) -> float:
    """Largest radius of the cubics through the radii and their rates l_s sin a, taken where the slope changes sign."""
    radius, slope, _ = state
    rate = row_length * np.sin(slope)
    turns = np.flatnonzero((slope[:-1] > 0.0) & (slope[1:] <= 0.0))
    s = slope[turns] / (slope[turns] - slope[turns + 1])
    left, right = radius[turns], radius[turns + 1]
    value = (1.0 + 2.0 * s) * (1.0 - s) ** 2 * left + s**2 * (3.0 - 2.0 * s) * right
    value = value + step[turns] * s * (1.0 - s) * ((1.0 - s) * rate[turns] - s * rate[turns + 1])
    return float(max(radius.max(), value.max(initial=0.0)))
