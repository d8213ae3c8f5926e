"""Steps of dynamic relaxation: the inner loop of the solver, compiled.

One pass over the nodes does everything: a bar is written from its lower to its higher node, so when the pass reaches a
node all bars from lower nodes have already left their pull in its force, and the node can be moved at once. Between two
refreshes the loads stand still and the force density of a bar is linear in the square of its length, which needs
neither root nor division; loads, law and masses are set afresh every ``REFRESH`` steps and whenever the motion is
stopped, and convergence is judged on fresh values only.
"""

from typing import NamedTuple

import numpy as np

from codend.compiled import njit
from codend.mechanics.balance import out_of_balance
from codend.mechanics.bars import bar_vector
from codend.mechanics.catch_front import fill
from codend.mechanics.images import add_turned_back
from codend.mechanics.loads import Loading, add_bound, add_force
from codend.mechanics.structure import Structure
from codend.net.net import Floats, Ints

REFRESH = 25
LONGEST_MOVE = 0.15
"""Longest move of a node in one step, over the mean bar: what goes further goes through its neighbours."""
LEAST_OF_STRUTS = -1e300
"""Force density, N/m, that no strut falls below; compiled with ``fastmath``, which knows no infinity."""
X, FORCE, VELOCITY, MOBILITY, LOAD = 0, 3, 6, 9, 12
WIDTH = 16
"""Columns of the packed state of a node: position, force, velocity, 1 / mass, load; one column is spare."""

CONVERGED, STEPS_SPENT, NOT_FINITE, OVERSTRETCHED, OVERFULL = range(5)


class Workspace(NamedTuple):
    """Arrays that the relaxation writes."""

    state: Floats
    """Packed state of the nodes, (n, 16)."""
    chain: Ints
    """Where the bars of each node begin in the order of ``bars``, (n + 1,)."""
    bar_order: Ints
    """Bars in the order of their first node, (m,)."""
    bar_end: Ints
    """Second node of the bars in that order, (m,)."""
    bar_image: Ints
    """Image of that node, (m,)."""
    law: Floats
    """Force density of the bars in that order as a + k l^2, and what it never falls below: a, k and that, (m, 3)."""
    multiplier: Floats
    relief: Floats
    gain: Floats
    density: Floats
    """Force density of the bars, N/m, (m,)."""
    length: Floats
    share: Floats
    """Share of each band in the catch, (bands,)."""
    force: Floats
    """Out-of-balance force of the nodes, (n, 3)."""
    position: Floats
    """Positions as the loads need them, (n, 3)."""
    stiffness: Floats
    """Bound on the nodes' rows of the stiffness matrix, (n,)."""
    load_bound: Floats
    """The part of pressure and stiff twine in that, set at every rest, (n,)."""


def workspace(structure: Structure, bands: int, position: Floats) -> Workspace:
    """Arrays for a relaxation that starts from ``position``, with a catch that fills so many bands."""
    nodes, bars = len(structure.free), len(structure.first)
    order = np.argsort(structure.first, kind="stable")
    state = np.zeros((nodes, WIDTH))
    state[:, X : X + 3] = position
    return Workspace(
        state=state,
        chain=np.searchsorted(structure.first[order], np.arange(nodes + 1)).astype(np.uint32),
        bar_order=order.astype(np.int32),
        bar_end=structure.second[order].astype(np.uint32),
        bar_image=structure.image[order],
        law=np.where(structure.is_strut[order], [[0.0], [0.0], [LEAST_OF_STRUTS]], 0.0).T.copy(),
        multiplier=np.zeros(bars),
        relief=np.ones(bars),
        gain=np.zeros(bars),
        density=np.zeros(bars),
        length=np.zeros(bars),
        share=np.zeros(bands),
        force=np.zeros((nodes, 3)),
        position=np.zeros((nodes, 3)),
        stiffness=np.zeros(nodes),
        load_bound=np.zeros(nodes),
    )


@njit(cache=True)
def refresh(work: Workspace, structure: Structure, loading: Loading, mass_factor: float) -> tuple[float, float, bool]:
    """Set loads, tensions, masses and law afresh; return residual, axial imbalance and whether the catch fits."""
    state, force, position, stiffness = work.state, work.force, work.position, work.stiffness
    position[:] = state[:, X : X + 3]
    fits = fill(position, structure, loading.catch, work.share)
    force[:] = 0.0
    add_force(position, structure, loading, work.share, force)
    state[:, LOAD : LOAD + 3] = force
    state[:, FORCE : FORCE + 3] = force

    # masses that keep a unit time step stable: half the sum of the moduli of a node's row of the stiffness matrix
    stiffness[:] = work.load_bound
    firsts, seconds, images, rotations = structure.first, structure.second, structure.image, structure.rotations
    rests, reliefs, gains, multipliers = structure.length, work.relief, work.gain, work.multiplier
    bar_order, law, lengths, densities = work.bar_order, work.law, work.length, work.density
    tension = 0.0
    for place in range(len(bar_order)):
        bar = bar_order[place]
        first, second, image = firsts[bar], seconds[bar], images[bar]
        dx, dy, dz = bar_vector(position, first, second, image, rotations)
        length = np.sqrt(dx * dx + dy * dy + dz * dz)
        rest, gain = rests[bar], gains[bar]
        held = reliefs[bar] * multipliers[bar]
        density = max(law[place, 2], held + gain * (1.0 / rest - 1.0 / length)) if length > 0.0 else 0.0
        # a slack bar is seen at the length at which it will come taut
        seen = length if density != 0.0 else rest
        rigidity = gain / seen
        law[place, 1] = 0.5 * rigidity / (seen * seen)
        law[place, 0] = held + gain / rest - 1.5 * rigidity
        lengths[bar], densities[bar] = length, density
        size = abs(density)
        tension += size * length
        stiffness[first] += size + rigidity
        stiffness[second] += size + rigidity
        if density != 0.0:
            force[first, 0] += density * dx
            force[first, 1] += density * dy
            force[first, 2] += density * dz
            add_turned_back(force, second, -density * dx, -density * dy, -density * dz, image, rotations)
    free = structure.free
    for node in range(len(force)):
        mobility = 2.0 / (mass_factor * stiffness[node]) if stiffness[node] > 0.0 else 0.0
        for i in range(3):
            state[node, MOBILITY + i] = mobility * free[node, i]
    residual, imbalance = out_of_balance(structure, force, state[:, LOAD : LOAD + 3], tension / max(len(bar_order), 1))
    return residual, imbalance, fits


@njit(cache=True, fastmath=True, error_model="numpy")
def step(
    state: Floats,
    chain: Ints,
    bar_end: Ints,
    bar_image: Ints,
    law: Floats,
    rotations: Floats,
    keep: float,
    push: float,
    longest: float,
) -> float:
    """Move all nodes by one step, v <- keep v + push f / m, x <- x + v; return the work done by the forces.

    With keep = push = 1 that work is the change of kinetic energy, but for what is taken from nodes that would move
    further than ``longest``.
    """
    gain, square = 0.0, longest * longest
    middle = (rotations.shape[0] - 1) // 2
    turning = rotations.shape[0] > 1
    one = np.uint64(1)
    for count in range(state.shape[0]):
        node = np.uint64(count)
        x, y, z = state[node, 0], state[node, 1], state[node, 2]
        fx, fy, fz = state[node, 3], state[node, 4], state[node, 5]
        for bar in range(np.uint64(chain[node]), np.uint64(chain[node + one])):
            end = np.uint64(bar_end[bar])
            image = bar_image[bar] if turning else 0
            if image == 0:
                dx, dy, dz = state[end, 0] - x, state[end, 1] - y, state[end, 2] - z
                q = max(law[bar, 2], law[bar, 0] + law[bar, 1] * (dx * dx + dy * dy + dz * dz))
                dx, dy, dz = q * dx, q * dy, q * dz
                state[end, 3] -= dx
                state[end, 4] -= dy
                state[end, 5] -= dz
            else:
                cosine, sine = rotations[middle + image, 0], rotations[middle + image, 1]
                dx = state[end, 0] - x
                dy = cosine * state[end, 1] - sine * state[end, 2] - y
                dz = sine * state[end, 1] + cosine * state[end, 2] - z
                q = max(law[bar, 2], law[bar, 0] + law[bar, 1] * (dx * dx + dy * dy + dz * dz))
                dx, dy, dz = q * dx, q * dy, q * dz
                state[end, 3] -= dx
                state[end, 4] -= cosine * dy + sine * dz
                state[end, 5] -= cosine * dz - sine * dy
                if end == node:
                    # a ring bar joins a node to its own image: its pull on the second end comes back at once
                    fx -= dx
                    fy -= cosine * dy + sine * dz
                    fz -= cosine * dz - sine * dy
            fx += dx
            fy += dy
            fz += dz
        vx, vy, vz = state[node, 6], state[node, 7], state[node, 8]
        ux = keep * vx + push * state[node, 9] * fx
        uy = keep * vy + push * state[node, 10] * fy
        uz = keep * vz + push * state[node, 11] * fz
        move = ux * ux + uy * uy + uz * uz
        if move > square:
            shorter = longest / np.sqrt(move)
            ux, uy, uz = shorter * ux, shorter * uy, shorter * uz
        gain += fx * (ux + vx) + fy * (uy + vy) + fz * (uz + vz)
        state[node, 6], state[node, 7], state[node, 8] = ux, uy, uz
        state[node, 0], state[node, 1], state[node, 2] = x + ux, y + uy, z + uz
        state[node, 3], state[node, 4], state[node, 5] = state[node, 12], state[node, 13], state[node, 14]
    return 0.5 * gain


@njit(cache=True)
def step_back(state: Floats) -> None:
    """Undo the last move, but keep its velocity."""
    for node in range(state.shape[0]):
        for i in range(3):
            state[node, X + i] -= state[node, VELOCITY + i]


@njit(cache=True)
def start_from_rest(work: Workspace, back: float) -> float:
    """Stop all nodes a fraction ``back`` of a step before where they are; kinetic energy of the coming half step.

    The velocity is set to that half a step before rest, which the first step turns into that half a step after it.
    """
    energy = 0.0
    state, force = work.state, work.force
    for node in range(state.shape[0]):
        for i in range(3):
            impulse = state[node, MOBILITY + i] * force[node, i]
            state[node, X + i] -= back * (state[node, VELOCITY + i] - impulse)
            state[node, VELOCITY + i] = -0.5 * impulse
            energy += 0.125 * impulse * force[node, i]
    return energy


@njit(cache=True)
def lowest_frequency(state: Floats, last_x: Floats, force: Floats, last_force: Floats, free: Floats) -> float:
    """Rayleigh quotient of the last move, (dx . K dx / dx . M dx)^1/2 per step; 0 where it says nothing."""
    stored, inertia = 0.0, 0.0
    for node in range(state.shape[0]):
        for i in range(3):
            mobility = state[node, MOBILITY + i]
            if free[node, i] > 0.0 and mobility > 0.0:
                move = state[node, X + i] - last_x[node, i]
                stored -= move * (force[node, i] - last_force[node, i])
                inertia += move * move / mobility
    return np.sqrt(stored / inertia) if stored > 0.0 and inertia > 0.0 else 0.0


@njit(cache=True)
def relax(
    work: Workspace,
    structure: Structure,
    loading: Loading,
    tolerance: float,
    mass_factor: float,
    viscous: bool,
    steps_allowed: int,
) -> tuple[int, int, int, float, float]:
    """Relax from rest until residual and axial imbalance fall to ``tolerance``.

    Kinetic damping stops the motion at every peak of the kinetic energy, interpolated between the steps; viscous
    damping is critical for the lowest frequency seen (Rayleigh quotient of the last moves).

    Returns:
        outcome, steps, stops, residual and axial imbalance (``balance.out_of_balance``).
    """
    state = work.state
    work.position[:] = state[:, X : X + 3]
    fill(work.position, structure, loading.catch, work.share)
    work.load_bound[:] = 0.0
    add_bound(work.position, structure, loading, work.share, work.load_bound)
    residual, imbalance, fits = refresh(work, structure, loading, mass_factor)
    steps, stops, since_rest = 0, 0, 0
    energy, last_energy, energy_before = 0.0, 0.0, 0.0
    keep, push, back = 1.0, 1.0, 0.0
    at_rest = True
    # stiff twine and contact are too stiff loads to stand still for long
    interval = REFRESH if len(structure.corner_rest) == 0 and len(loading.contact.kind) == 0 else 1
    longest = LONGEST_MOVE * structure.length.mean()
    last_x, last_force = state[:, X : X + 3].copy(), work.force.copy()
    while True:
        if not np.isfinite(residual):
            return NOT_FINITE, steps, stops, residual, imbalance
        if residual <= tolerance and imbalance <= tolerance:
            return (CONVERGED if fits else OVERFULL), steps, stops, residual, imbalance
        if steps >= steps_allowed:
            return STEPS_SPENT, steps, stops, residual, imbalance
        if at_rest:
            work.load_bound[:] = 0.0
            add_bound(work.position, structure, loading, work.share, work.load_bound)
            energy = start_from_rest(work, back)
            last_energy, energy_before, since_rest = energy, energy, 0
        at_rest = False
        for _ in range(interval):
            work_done = step(
                state, work.chain, work.bar_end, work.bar_image, work.law, structure.rotations, keep, push, longest
            )
            steps += 1
            if viscous:
                continue
            energy_before, last_energy = last_energy, energy
            energy += work_done
            since_rest += 1
            if energy < last_energy and since_rest > 1:
                # the parabola through the last three energies has its peak within the step before the last
                bend = energy_before - 2.0 * last_energy + energy
                peak = 0.5 * (energy_before - energy) / bend if bend < 0.0 else 0.5
                back = 0.5 - min(max(peak, -0.5), 0.5) if since_rest > 2 else 0.0
                step_back(state)
                at_rest = True
                stops += 1
                break
        residual, imbalance, fits = refresh(work, structure, loading, mass_factor)
        if viscous:
            frequency = lowest_frequency(state, last_x, work.force, last_force, structure.free)
            damping = min(2.0 * frequency, 1.0)
            keep, push = (2.0 - damping) / (2.0 + damping), 2.0 / (2.0 + damping)
            last_x[:] = state[:, X : X + 3]
            last_force[:] = work.force
        # a soft strap is longer by far in a net that holds its shape without it
        if np.any((work.length > 3.0 * structure.length) & ~structure.is_rope):
            return OVERSTRETCHED, steps, stops, residual, imbalance
