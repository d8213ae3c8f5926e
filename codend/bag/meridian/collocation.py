"""Fourth-order collocation of the meridian equations between entry and codline, solved by Newton's method."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from codend.bag.meridian.shell import Floats, Shell, rates

LONGEST_STEP = 0.05  # in t: the shape varies over about 1
CATCH_STEPS = 40
MOST_STEPS = 10_000  # in one half-mesh row: of a catch far smaller than that nothing is resolved
LOWER, UPPER = 3, 4  # bands of the Newton matrix below and above its diagonal


@dataclass(frozen=True)
class Grid:
    """Places at which the state is sought; half-mesh rows and the catch's front are among them."""

    t: Floats
    """Shape (n + 1,)."""
    in_catch: Floats
    """1 for an interval inside the catch, 0 for one ahead of it, shape (n,)."""
    rows: NDArray[np.intp]
    """Places of the half-mesh rows in ``t``, shape (2 M + 1,)."""
    front: int
    """Place of the front."""


@dataclass(frozen=True)
class NewtonResult:
    """State on a grid and what it took."""

    state: Floats
    """Radius, slope and ln Q, shape (3, n + 1)."""
    residual: float
    """Largest defect of an interval or a boundary condition."""
    iterations: int
    converged: bool


def make_grid(shell: Shell, half_mesh_rows: int, refinement: int = 1) -> Grid:
    """Half-mesh rows and front, with points between them so that no step is long against what it must resolve.

    Steps are at most ``LONGEST_STEP``, and at most a ``CATCH_STEPS``-th of the catch within it and for as much ahead of
    it, but a ``MOST_STEPS``-th of a half-mesh row at least; ``refinement`` divides each again.
    """
    rows = np.linspace(0.0, shell.rows, half_mesh_rows + 1)
    ends = rows
    if np.abs(rows - shell.front).min() > 1e-9 * rows[1]:
        ends = np.insert(rows, np.searchsorted(rows, shell.front), shell.front)
    depth = shell.rows - shell.front
    near = ends[1:] > shell.front - depth
    longest = np.where(near, min(LONGEST_STEP, max(depth / CATCH_STEPS, rows[1] / MOST_STEPS)), LONGEST_STEP)
    parts = refinement * np.ceil(np.diff(ends) / longest - 1e-9).astype(int)
    starts = np.concatenate([[0], np.cumsum(parts)])
    t = np.interp(np.arange(starts[-1] + 1), starts, ends)
    front = int(np.argmin(np.abs(t - shell.front)))
    in_catch = (np.arange(len(t) - 1) >= front).astype(float)
    return Grid(t, in_catch, starts[np.searchsorted(ends, rows - 1e-9 * rows[1])], front)


def middle_state(shell: Shell, grid: Grid, state: Floats) -> Floats:
    """State in the middle of every interval, as the cubic through its ends has it, (3, n)."""
    left, right = state[:, :-1], state[:, 1:]
    f_left, f_right = rates(shell, left, grid.in_catch)[0], rates(shell, right, grid.in_catch)[0]
    return np.asarray(0.5 * (left + right) + np.diff(grid.t) / 8.0 * (f_left - f_right))


def _defects(shell: Shell, grid: Grid, state: Floats, with_jacobian: bool) -> tuple[Floats, Floats]:
    """Defects of the Lobatto IIIA (Simpson) collocation and, in banded storage, their Jacobian."""
    step = np.diff(grid.t)
    left, right = state[:, :-1], state[:, 1:]
    inside = grid.in_catch
    n = len(step)
    ends, ends_jacobian = rates(shell, np.concatenate([left, right], axis=1), np.concatenate([inside, inside]))
    f_left, f_right = ends[:, :n], ends[:, n:]
    middle = 0.5 * (left + right) + step / 8.0 * (f_left - f_right)
    f_middle, j_middle = rates(shell, middle, inside)
    defect = right - left - step / 6.0 * (f_left + 4.0 * f_middle + f_right)
    entry = state[0, 0] - shell.entry_radius
    tail = np.array([state[0, -1], state[1, -1] + 0.5 * np.pi])
    residual = np.concatenate([[entry], defect.T.ravel(), tail])
    if not with_jacobian:
        return residual, np.empty(0)

    j_left, j_right = ends_jacobian[:, :, :n], ends_jacobian[:, :, n:]
    eye = np.eye(3)[:, :, None]
    by_left = -eye - step / 6.0 * (j_left + 2.0 * j_middle + step / 2.0 * np.einsum("ikn,kjn->ijn", j_middle, j_left))
    by_right = eye - step / 6.0 * (j_right + 2.0 * j_middle - step / 2.0 * np.einsum("ikn,kjn->ijn", j_middle, j_right))
    bands = np.zeros((LOWER + UPPER + 1, 3 * n + 3))
    bands[UPPER, 0] = 1.0
    for i in range(3):
        for j in range(3):
            # equation 1 + 3 m + i of interval m against unknown 3 m + j and 3 m + 3 + j
            bands[UPPER + 1 + i - j, j : 3 * n : 3] = by_left[i, j]
            bands[UPPER - 2 + i - j, 3 + j :: 3] = by_right[i, j]
    last = 3 * n
    bands[UPPER + 1, last] = 1.0  # radius at the codline: equation last + 1
    bands[UPPER + 1, last + 1] = 1.0  # slope at the codline: equation last + 2
    return residual, bands


def solve_newton(
    shell: Shell, grid: Grid, start: Floats, tolerance: float = 1e-11, most_iterations: int = 40
) -> NewtonResult:
    """Newton's method with step control by the natural (simplified Newton) monotonicity test.

    A step is shortened until it stays where the netting can be (radius below that of fully stretched bars, slope within
    a half turn) and until the next simplified Newton correction is smaller than the last full one.
    """
    from scipy.linalg import LinAlgError, solve_banded

    state = start.copy()
    residual, bands = _defects(shell, grid, state, True)
    damping = 1.0
    for iteration in range(most_iterations):
        size = float(np.abs(residual).max())
        if size < tolerance:
            return NewtonResult(state, size, iteration, True)
        try:
            flat = solve_banded((LOWER, UPPER), bands, residual, check_finite=False)
        except (LinAlgError, ValueError):
            break
        if not np.all(np.isfinite(flat)):
            break
        correction = -flat.reshape(-1, 3).T
        length = float(np.linalg.norm(correction))
        damping = min(1.0, 2.0 * damping, _longest_step(shell, state, correction))
        while damping > 1e-6:
            trial = state + damping * correction
            trial_residual, _ = _defects(shell, grid, trial, False)
            simplified = solve_banded((LOWER, UPPER), bands, trial_residual, check_finite=False)
            if (
                np.linalg.norm(simplified) <= (1.0 - 0.25 * damping) * length
                or np.abs(trial_residual).max() < tolerance
            ):
                break
            damping *= 0.5
        else:
            break
        state = trial
        residual, bands = _defects(shell, grid, state, True)
    return NewtonResult(state, float(np.abs(residual).max()), iteration + 1, False)


def _longest_step(shell: Shell, state: Floats, correction: Floats) -> float:
    """Largest part of the correction that keeps bars short of fully spread and turns no slope by more than a radian."""
    turn = float(np.abs(correction[1]).max())
    grow = float(np.abs(correction[2]).max())
    allowed = min(1.0, 1.0 / max(turn, 1e-12), 2.0 / max(grow, 1e-12))
    if shell.compliance == 0.0 and not (shell.knot_across and shell.knot_compliance > 0.0):
        room = 0.999 * (1.0 + shell.knot_round) - state[0]
        outward = correction[0] > 0.0
        if np.any(outward):
            allowed = min(allowed, float((room[outward] / correction[0][outward]).min()))
    return max(allowed, 1e-6)
