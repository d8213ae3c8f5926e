"""Closed-form meridian under uniform pressure: its two unknowns, and the shape at any row (see ``quadrature``)."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from codend.bag.meridian.quadrature import Ahead, Catch, Netting, SlackTail, netting_of
from codend.bag.meridian.shell import Floats, Shell

_GAUSS_NODES, _GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(12)
_GRADING = np.array([0.0, 1.5, 4.0, 12.0])  # panel ends from the ends of a piece, near which the integrands vary
_LOGARITHM_RATES = np.array([1.0, np.sqrt(6.0)])  # rows grow by 1/rate for each factor e nearer to the limit shapes
_FEW_NODES, _FEW_WEIGHTS = np.polynomial.legendre.leggauss(6)
_PARTS = 4
_NEAR_ENOUGH = 1e-8  # the last of Newton's steps: its error is the square of that
_LARGEST_DEFECT = 1e-10
_MOST_ITERATIONS = 30


class Piece(Protocol):
    """A stretch of meridian as a function of one parameter."""

    def rates(self, parameter: Floats) -> Floats:
        """Rows per parameter."""

    def state(self, parameter: Floats) -> tuple[Floats, Floats, Floats]:
        """Radius, half angle and slope."""


@dataclass(frozen=True)
class Meridian:
    """Pieces of a meridian from entry to codline; every array has a leading batch axis, parameters shape (batch, 1)."""

    ahead: Ahead
    ahead_ends: tuple[Floats, Floats]
    catch: Catch
    catch_ends: tuple[Floats, Floats]
    rows: Floats
    """Rows ahead of the front and in the catch, nan where the pieces do not join, (batch, 2)."""


def _panel_ends(start: Floats, end: Floats) -> Floats:
    """Ends of panels graded towards both ends, (batch, 8) from (batch, 1)."""
    offset = np.minimum(_GRADING, 0.5 * (end - start))
    return np.concatenate([start + offset, end - offset[:, ::-1]], axis=1)


def _rows_between(piece: Piece, start: Floats, end: Floats) -> Floats:
    """Rows of a piece between two parameters, (batch,)."""
    ends = _panel_ends(start, end)
    half = 0.5 * np.diff(ends, axis=1)
    nodes = (0.5 * (ends[:, 1:] + ends[:, :-1]))[:, :, None] + half[:, :, None] * _GAUSS_NODES
    values = piece.rates(nodes.reshape(len(start), -1)).reshape(nodes.shape)
    return np.asarray(((values @ _GAUSS_WEIGHTS) * half).sum(axis=1))


def _join(ahead: Ahead, entry_slope: Floats, front_slope: Floats, catch: Catch, v: Floats) -> Meridian:
    """The meridian with these slopes at entry and front, v the place of the front in the catch."""
    across = catch.netting.across
    w_entry, w_front = ahead.place(entry_slope), ahead.place(front_slope)
    v_tail = catch.place(0.0)
    before = _rows_between(ahead, w_entry, w_front)
    within = _rows_between(catch, v, v_tail)
    if across > 0.0:
        within = within + _rows_between(SlackTail(catch.axial), np.full_like(v, -across), np.zeros_like(v))
    # without a neck, w = 0 is a point on the axis: no meridian passes it
    joined = (w_front > w_entry) & (ahead.neck | (w_front * w_entry > 0.0))
    before = np.where(joined[:, 0], before, np.nan)
    return Meridian(ahead, (w_entry, w_front), catch, (v, v_tail), np.stack([before, within], axis=1))


def _from_entry_slope(netting: Netting, phi_entry: float, unknowns: Floats) -> Meridian:
    """Front ahead of the largest radius; unknowns fix the entry slope above that of closed meshes, and the gap.

    Good for any length, but singular where the front comes to the largest radius.
    """
    y, z = unknowns[:, :1], unknowns[:, 1:]
    closed = netting.row_length(0.0)
    closing = np.arccos(netting.row_length(phi_entry) / closed)  # slope -closing leads to closed meshes
    above = (closing + 0.5 * np.pi) / (1.0 + np.exp(-y))
    slope = above - closing
    excess = 2.0 * np.sin(0.5 * above) * np.sin(closing - 0.5 * above) / np.cos(closing)  # E l_s(0) - 1
    catch = Catch(netting, netting.widest / (1.0 + np.exp(z)))
    ahead = Ahead.from_excess(netting, excess)
    phi_front = np.arcsin(np.sqrt(ahead.axial / catch.axial) - netting.across)
    front_slope = np.arccos(ahead.axial * netting.row_length(phi_front))
    return _join(ahead, slope, front_slope, catch, -catch.place(phi_front))


def _from_front_place(netting: Netting, phi_entry: float, unknowns: Floats) -> Meridian:
    """Front about the largest radius, meridian narrowing at the entry; unknowns fix v at the front, and the gap."""
    y, z = unknowns[:, :1], unknowns[:, 1:]
    catch = Catch(netting, netting.widest / (1.0 + np.exp(z)))
    v = catch.place(0.0) * np.tanh(y)
    radius, _, front_slope = catch.state(v)
    axial = catch.axial * radius**2
    slope = -np.arccos(axial * netting.row_length(phi_entry))
    ahead = Ahead.from_excess(netting, axial * netting.row_length(0.0) - 1.0)
    return _join(ahead, slope, front_slope, catch, v)


def _straightened(rows: Floats) -> Floats:
    """ln(exp(c rows) - 1): nearly linear in the unknowns for short pieces and long ones alike."""
    scaled = rows * _LOGARITHM_RATES
    return scaled + np.log(-np.expm1(-scaled))


@dataclass(frozen=True)
class ClosedForm:
    """Solved closed-form meridian of a shell."""

    netting: Netting
    meridian: Meridian
    """With a batch axis of one."""
    iterations: int
    residual: float
    """Largest error in the number of rows, over the rows wanted."""

    def at(self, t: Floats) -> tuple[Floats, Floats, Floats]:
        """Radius, half angle phi and slope a at rows t, rising, all (n,)."""
        pieces: list[tuple[Piece, float, float]] = [
            (self.meridian.ahead, self.meridian.ahead_ends[0].item(), self.meridian.ahead_ends[1].item()),
            (self.meridian.catch, self.meridian.catch_ends[0].item(), self.meridian.catch_ends[1].item()),
        ]
        if self.netting.across > 0.0:
            pieces.append((SlackTail(self.meridian.catch.axial), -self.netting.across, 0.0))
        out = np.empty((3, len(t)))
        first, run = 0, 0.0
        for piece, start, end in pieces:
            knots = _knots(start, end)
            rows = np.concatenate([[0.0], np.cumsum(_rows_within(piece, knots[:-1], knots[1:]))])
            last = len(t) if piece is pieces[-1][0] else int(np.searchsorted(t, run + rows[-1]))
            parameter = _parameter_at(piece, knots, rows, t[first:last] - run)
            out[:, first:last] = [value[0] for value in piece.state(parameter[None, :])]
            first, run = last, run + rows[-1]
        return out[0], out[1], out[2]


def _knots(start: float, end: float) -> Floats:
    """Parameters that divide a piece finely enough for few Gauss points between two of them."""
    ends = _panel_ends(np.array([[start]]), np.array([[end]]))[0]
    parts = np.linspace(ends[:-1], ends[1:], _PARTS, endpoint=False, axis=1)
    return np.unique(np.append(parts, end))


def _rows_within(piece: Piece, start: Floats, end: Floats) -> Floats:
    """Rows between near parameters, (n,)."""
    half = 0.5 * (end - start)
    nodes = 0.5 * (start + end)[:, None] + half[:, None] * _FEW_NODES
    return np.asarray(piece.rates(nodes.reshape(1, -1)).reshape(nodes.shape) @ _FEW_WEIGHTS * half)


def _parameter_at(piece: Piece, knots: Floats, rows: Floats, wanted: Floats) -> Floats:
    """Parameters at which a piece has run ``wanted`` rows: Newton's method between two knots, rates being smooth."""
    part = np.clip(np.searchsorted(rows, wanted) - 1, 0, len(knots) - 2)
    low, high = knots[part], knots[part + 1]
    parameter = low + (high - low) * (wanted - rows[part]) / (rows[part + 1] - rows[part])
    for _ in range(6):
        missing = wanted - rows[part] - _rows_within(piece, low, parameter)
        step = missing / piece.rates(parameter[None, :])[0]
        parameter = np.clip(parameter + step, low, high)
        if np.abs(step).max(initial=0.0) < _NEAR_ENOUGH * (1.0 + np.abs(knots).max()):
            break
    return parameter


def solve_closed_form(shell: Shell) -> ClosedForm | None:
    """Solve for the two unknowns by Newton's method from a few starts.

    None where the closed form does not apply or is not found: elastic bars or knots, a front at the entry row, an entry
    wider than the limit r of the catch, T90 knots slack at the entry or at the front, or no start that converges.
    """
    netting = netting_of(shell)
    if not shell.inextensible or shell.front <= 0.0 or not 0.0 < shell.entry_radius - netting.across < 1.0:
        return None
    phi_entry = float(np.arcsin(shell.entry_radius - netting.across))
    if phi_entry >= netting.widest:
        return None
    wanted = np.array([shell.front, shell.rows - shell.front])
    target = _straightened(wanted)
    rows = wanted[1] * _LOGARITHM_RATES[1]
    iterations = 0
    with np.errstate(all="ignore"):  # unknowns for which the pieces do not join give nan, and are passed over
        for chart, shares, first in (
            (_from_entry_slope, (0.65, 0.87, 0.5), np.linspace(-1.0 - shell.front, 5.0, 13)),
            (_from_front_place, (0.9, 1.1, 0.75, 1.4, 2.0), np.linspace(-1.5, 1.5, 16)),
            (_from_entry_slope, (0.98, 0.33), np.linspace(-1.0 - shell.front, 5.0, 40)),
        ):
            for share in shares:
                # rows from largest radius to codline are about ln(1 + 3 exp z) / sqrt(6)
                gap = np.log(np.expm1(min(share * rows, 600.0)) / 3.0)
                starts = np.stack([first, np.full_like(first, gap)], axis=1)
                error = np.abs(_straightened(chart(netting, phi_entry, starts).rows) - target).sum(axis=1)
                if not np.any(np.isfinite(error)):
                    continue
                found, steps = _newton(chart, netting, phi_entry, starts[np.nanargmin(error)], target)
                iterations += steps
                if found is not None:
                    defect = float(np.abs(found.rows[0] / wanted - 1.0).max())
                    return ClosedForm(netting, found, iterations, defect)
    return None


def _newton(
    chart: Callable[[Netting, float, Floats], Meridian],
    netting: Netting,
    phi_entry: float,
    start: Floats,
    target: Floats,
) -> tuple[Meridian | None, int]:
    """Damped Newton's method with forward differences in the batch; None unless the rows are met."""
    nudge = 1e-6
    offsets = nudge * np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    best, smallest, step, damping = start, np.inf, np.zeros(2), 1.0
    unknowns, iterations = start, 0
    while iterations < _MOST_ITERATIONS:
        iterations += 1
        meridian = chart(netting, phi_entry, unknowns + offsets)
        defect = _straightened(meridian.rows) - target
        size = np.abs(defect[0]).max()
        if not (np.all(np.isfinite(defect)) and size < smallest):
            damping *= 0.5
            if damping < 1e-2 or smallest < _LARGEST_DEFECT:
                break
            unknowns = best + damping * step
            continue
        best, smallest = unknowns, size
        if size < 1e-13:
            break
        jacobian = (defect[1:] - defect[0]).T / nudge
        if not abs(np.linalg.det(jacobian)) > 0.0:
            break
        step = -np.linalg.solve(jacobian, defect[0])
        damping = min(1.0, 2.0 * damping, 3.0 / max(float(np.abs(step).max()), 1e-9))
        unknowns = best + damping * step
    return (chart(netting, phi_entry, best[None, :]) if smallest < _LARGEST_DEFECT else None), iterations
