"""Rigid bars hinged at their ends, in motion: kernels.

With X and V the nodes' positions and velocities, M their masses, g_k the half of bar k's squared length and J its
gradients dg_k/dX, a bar of force density q pulls its ends with -J^T q. Bessonneau and Marichal (1997, equations 10 to
16) step in time by

    V(n+1) = V(n) + dt M^-1 (E - J^T q),   X(n+1) = X(n) + dt V(n+1),   g + dt J V(n+1) = l^2 / 2

the last of which is their condition on the lengths without its term in dt^2. It gives the tensions of the step:

    J M^-1 J^T q = J (V(n) / dt + M^-1 E) + (g - l^2 / 2) / dt^2
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from codend.compiled import njit
from codend.mechanics.bars import bar_vector
from codend.mechanics.drag_laws import drag_factors
from codend.mechanics.images import add_turned_back
from codend.mechanics.loads import Loading
from codend.mechanics.structure import Structure
from codend.net.net import Floats, Ints

SLIGHT_GIVE = 1e-10
"""Added to the diagonal, relative: bars that lie upon each other then share their tension."""


class RigidPattern(NamedTuple):
    """Which bars meet at which node, and the entries of J M^-1 J^T they add to. Bar k has the ends 2 k and 2 k + 1."""

    node_start: Ints
    """Where the ends at each node begin in ``node_ends``, (n + 1,)."""
    node_ends: Ints
    """Ends, node by node, (2 m + 4 c,)."""
    row_of_end: Ints
    """Row of every end: of bar k, then of parts that meet, with four ends each, (2 m + 4 c,)."""
    slots: Ints
    """Entry of every pair of ends at a node, node by node, first end slowest."""
    row: Ints
    """Bar of each entry, (entries,), rising; within it ``column`` rises."""
    column: Ints
    diagonal: Ints
    """Entry of each bar with itself, (m,)."""


def rigid_pattern(structure: Structure, on_body: Ints | None = None, meeting: Ints | None = None) -> RigidPattern:
    """Entries of the system for the tensions of a net.

    Args:
        structure: the net, of whose bars k has the ends 2 k and 2 k + 1.
        on_body: nodes of a rigid body, whose bars have entries with each other besides.
        meeting: the nodes of pairs of parts that meet, (c, 4), each pair a row after those of the bars.
    """
    bars, nodes = len(structure.first), len(structure.free)
    at_node = np.stack([structure.first, structure.second], axis=1).ravel()
    row_of_end = np.repeat(np.arange(bars), 2)
    if meeting is not None:
        at_node = np.concatenate([at_node, meeting.ravel()])
        row_of_end = np.concatenate([row_of_end, np.repeat(np.arange(len(meeting)) + bars, 4)])
    rows = bars if meeting is None else bars + len(meeting)
    ends = np.argsort(at_node, kind="stable")
    start = np.searchsorted(at_node[ends], np.arange(nodes + 1))
    # every end with every end at its node, node by node
    count = np.diff(start)
    first = np.repeat(np.arange(len(ends)), np.repeat(count, count))
    begin = np.repeat(start[:-1], count**2)
    within = np.arange(len(first)) - np.repeat(np.concatenate([[0], np.cumsum(count**2)[:-1]]), count**2)
    second = begin + within % np.repeat(count, count**2)
    keys = row_of_end[ends[first]] * rows + row_of_end[ends[second]]
    at_nodes = len(keys)
    if on_body is not None:
        bar = np.unique(np.flatnonzero(np.isin(at_node[: 2 * bars], on_body)) // 2)
        keys = np.concatenate([keys, (bar[:, None] * rows + bar[None, :]).ravel()])
    entries, slots = np.unique(keys, return_inverse=True)
    slots = slots[:at_nodes]
    return RigidPattern(
        node_start=start.astype(np.int32),
        node_ends=ends.astype(np.int32),
        row_of_end=row_of_end.astype(np.int32),
        slots=slots.astype(np.int32),
        row=(entries // rows).astype(np.int32),
        column=(entries % rows).astype(np.int32),
        diagonal=np.searchsorted(entries, np.arange(rows) * (rows + 1)).astype(np.int32),
    )


@njit(cache=True)
def length_gradients(position: Floats, structure: Structure, gradient: Floats, square: Floats) -> None:
    """Write J, the gradient of half a bar's squared length at each of its ends, (2 m, 3), and that square, (m,)."""
    firsts, seconds, images, rotations = structure.first, structure.second, structure.image, structure.rotations
    gradient[:] = 0.0
    for bar in range(len(firsts)):
        dx, dy, dz = bar_vector(position, firsts[bar], seconds[bar], images[bar], rotations)
        gradient[2 * bar, 0], gradient[2 * bar, 1], gradient[2 * bar, 2] = -dx, -dy, -dz
        add_turned_back(gradient, 2 * bar + 1, dx, dy, dz, images[bar], rotations)
        square[bar] = dx * dx + dy * dy + dz * dz


@njit(cache=True, error_model="numpy")
def inverse_masses(
    pattern: RigidPattern, free: Floats, gradient: Floats, square: Floats, mass: Floats, added: Floats, inverse: Floats
) -> None:
    """Write the inverse of every node's mass, (n, 3, 3), with rows and columns of held coordinates 0.

    Each end of a bar along the unit vector t has half of its mass m and of its added mass a, which only counts across
    the bar: 1/2 (m I + a (I - t t^T)). Both are in kg, (m,).
    """
    starts, ends = pattern.node_start, pattern.node_ends
    here = np.empty((3, 3))
    for node in range(len(free)):
        here[:] = 0.0
        for place in range(starts[node], starts[node + 1]):
            end = ends[place]
            bar = end // 2
            across = 0.5 * added[bar] / square[bar] if square[bar] > 0.0 else 0.0
            for i in range(3):
                here[i, i] += 0.5 * (mass[bar] + added[bar])
                for j in range(3):
                    here[i, j] -= across * gradient[end, i] * gradient[end, j]
        invert_free(here, free[node], inverse[node])


@njit(cache=True, error_model="numpy")
def invert_free(block: Floats, free: Floats, inverse: Floats) -> None:
    """Write the inverse of a symmetric 3 x 3 block with rows and columns of held coordinates 0; the block is spent."""
    for i in range(3):
        if free[i] == 0.0:
            block[i, :] = 0.0
            block[:, i] = 0.0
            block[i, i] = 1.0
    a, b, c = block[0, 0], block[0, 1], block[0, 2]
    d, e, f = block[1, 1], block[1, 2], block[2, 2]
    p, q, r = d * f - e * e, c * e - b * f, b * e - c * d
    determinant = a * p + b * q + c * r
    inverse[0, 0], inverse[0, 1], inverse[0, 2] = p, q, r
    inverse[1, 0], inverse[1, 1], inverse[1, 2] = q, a * f - c * c, b * c - a * e
    inverse[2, 0], inverse[2, 1], inverse[2, 2] = r, b * c - a * e, a * d - b * b
    for i in range(3):
        for j in range(3):
            inverse[i, j] *= free[i] * free[j] / determinant


@njit(cache=True, error_model="numpy")
def kinetic_energy(
    structure: Structure, gradient: Floats, square: Floats, mass: Floats, added: Floats, velocity: Floats
) -> float:
    """Kinetic energy under the masses of ``inverse_masses``, J."""
    firsts, seconds = structure.first, structure.second
    energy = 0.0
    for end in range(2 * len(firsts)):
        bar = end // 2
        node = firsts[bar] if end % 2 == 0 else seconds[bar]
        speed, along = 0.0, 0.0
        for i in range(3):
            speed += velocity[node, i] ** 2
            along += gradient[end, i] * velocity[node, i]
        energy += 0.25 * ((mass[bar] + added[bar]) * speed - added[bar] * along**2 / square[bar])
    return energy


@njit(cache=True)
def tension_system(pattern: RigidPattern, gradient: Floats, inverse: Floats, taut: Ints, entries: Floats) -> None:
    """Write the entries of J M^-1 J^T; rows that are not ``taut``, (m + c,), stand apart from all others.

    ``gradient`` has a row of three an end.
    """
    starts, ends, slots, diagonal = pattern.node_start, pattern.node_ends, pattern.slots, pattern.diagonal
    row_of_end = pattern.row_of_end
    entries[:] = 0.0
    pair = 0
    for node in range(len(starts) - 1):
        for one in range(starts[node], starts[node + 1]):
            p = ends[one]
            x, y, z = gradient[p, 0], gradient[p, 1], gradient[p, 2]
            u = inverse[node, 0, 0] * x + inverse[node, 0, 1] * y + inverse[node, 0, 2] * z
            v = inverse[node, 1, 0] * x + inverse[node, 1, 1] * y + inverse[node, 1, 2] * z
            w = inverse[node, 2, 0] * x + inverse[node, 2, 1] * y + inverse[node, 2, 2] * z
            for other in range(starts[node], starts[node + 1]):
                r = ends[other]
                a, b = row_of_end[p], row_of_end[r]
                if a == b or (taut[a] and taut[b]):
                    entries[slots[pair]] += u * gradient[r, 0] + v * gradient[r, 1] + w * gradient[r, 2]
                pair += 1
    for bar in range(len(diagonal)):
        entry = entries[diagonal[bar]]
        # a bar between supports that hold it along itself carries nothing that could be told
        entries[diagonal[bar]] = entry * (1.0 + SLIGHT_GIVE) if entry > 0.0 else 1.0


@njit(cache=True)
def only_taut(start: Ints, column: Ints, taut: Ints, entries: Floats, masked: Floats) -> None:
    """Write the entries of a matrix whose rows are of bars, those that are not ``taut`` apart from all others."""
    for bar in range(len(taut)):
        for k in range(start[bar], start[bar + 1]):
            kept = column[k] == bar or (taut[bar] and taut[column[k]])
            masked[k] = entries[k] if kept else 0.0


@njit(cache=True)
def multiply(start: Ints, column: Ints, entries: Floats, density: Floats, product: Floats) -> None:
    """Write A q, (m,)."""
    for bar in range(len(product)):
        total = 0.0
        for k in range(start[bar], start[bar + 1]):
            total += entries[k] * density[column[k]]
        product[bar] = total


@njit(cache=True)
def relax_one_sided(
    start: Ints,
    column: Ints,
    diagonal: Ints,
    entries: Floats,
    right: Floats,
    is_strut: NDArray[np.bool_],
    density: Floats,
    sweeps: int,
) -> None:
    """Bring q nearer to A q >= right, q >= 0, one of the two equal in every bar: Gauss-Seidel sweeps to and fro.

    Struts have A q = right.
    """
    bars = len(right)
    for sweep in range(sweeps):
        for step in range(bars):
            bar = step if sweep % 2 == 0 else bars - 1 - step
            rest = right[bar]
            for k in range(start[bar], start[bar + 1]):
                rest -= entries[k] * density[column[k]]
            found = density[bar] + rest / entries[diagonal[bar]]
            density[bar] = found if is_strut[bar] else max(found, 0.0)


@njit(cache=True)
def accelerations(inverse: Floats, force: Floats, acceleration: Floats) -> None:
    """Write M^-1 f, (n, 3)."""
    for node in range(len(force)):
        x, y, z = force[node, 0], force[node, 1], force[node, 2]
        for i in range(3):
            acceleration[node, i] = inverse[node, i, 0] * x + inverse[node, i, 1] * y + inverse[node, i, 2] * z


@njit(cache=True)
def lengthening(structure: Structure, gradient: Floats, velocity: Floats, rate: Floats) -> None:
    """Write J V, (m,)."""
    firsts, seconds = structure.first, structure.second
    for bar in range(len(firsts)):
        a, b = firsts[bar], seconds[bar]
        total = 0.0
        for i in range(3):
            total += gradient[2 * bar, i] * velocity[a, i] + gradient[2 * bar + 1, i] * velocity[b, i]
        rate[bar] = total


@njit(cache=True)
def add_pulls(structure: Structure, gradient: Floats, density: Floats, force: Floats) -> None:
    """Add -J^T q to nodal forces, (n, 3)."""
    firsts, seconds = structure.first, structure.second
    for bar in range(len(firsts)):
        q = density[bar]
        for i in range(3):
            force[firsts[bar], i] -= q * gradient[2 * bar, i]
            force[seconds[bar], i] -= q * gradient[2 * bar + 1, i]


@njit(cache=True)
def draw_in(position: Floats, structure: Structure, tolerance: float, sweeps: int) -> float:
    """Move nodes until no bar of a full net is longer than its length, bar by bar and again; what is left, relative.

    Both ends of a bar that is too long move along it by the same, a held coordinate not at all.
    """
    firsts, seconds, lengths, free = structure.first, structure.second, structure.length, structure.free
    worst = np.inf
    for _ in range(sweeps):
        worst = 0.0
        for bar in range(len(firsts)):
            a, b = firsts[bar], seconds[bar]
            square, moves = 0.0, 0.0
            for i in range(3):
                square += (position[b, i] - position[a, i]) ** 2
            length = np.sqrt(square)
            over = length / lengths[bar] - 1.0
            if over <= 0.0:
                continue
            worst = max(worst, over)
            for i in range(3):
                moves += (free[a, i] + free[b, i]) * (position[b, i] - position[a, i]) ** 2
            if moves <= 1e-12 * square:
                continue
            share = (length - lengths[bar]) * length / moves
            for i in range(3):
                d = share * (position[b, i] - position[a, i])
                position[a, i] += free[a, i] * d
                position[b, i] -= free[b, i] * d
        if worst <= tolerance:
            break
    return worst


@njit(cache=True)
def stable_time_step(
    structure: Structure,
    loading: Loading,
    velocity: Floats,
    density: Floats,
    load_bound: Floats,
    mass: Floats,
    added: Floats,
    room: Floats,
) -> float:
    """Largest time step, s, at which neither the motion of a node nor the drag that slows it can grow.

    A node of mass m under the stiffness K (the sum of the moduli of its row: tensions and ``load_bound``, (n,)) swings
    with w <= (K / m)^1/2; drag of c per velocity slows it at the rate c / m. The scheme is stable if
    dt (w + c / m) <= 2, as far as loads and tensions stand still. ``room`` is space to work in, (n, 2).
    """
    firsts, seconds = structure.first, structure.second
    lengths, widths, diameters = structure.length, structure.drag_diameter, structure.diameter
    laws, normals, tangentials = structure.drag_law, structure.normal_drag, structure.tangential_drag
    water = loading.water
    fastest, flow = 0.0, 0.0
    for node in range(len(velocity)):
        room[node, 0] = load_bound[node]
        room[node, 1] = 0.0
        fastest = max(fastest, velocity[node, 0] ** 2 + velocity[node, 1] ** 2 + velocity[node, 2] ** 2)
    for layer in range(len(water.height)):
        flow = max(flow, water.flow[layer, 0] ** 2 + water.flow[layer, 1] ** 2 + water.flow[layer, 2] ** 2)
    passing = np.sqrt(flow) + np.sqrt(fastest)
    slowing = 0.0
    for bar in range(len(firsts)):
        stiffness = 2.0 * abs(density[bar])
        room[firsts[bar], 0] += stiffness
        room[seconds[bar], 0] += stiffness
        room[firsts[bar], 1] += 0.5 * mass[bar]
        room[seconds[bar], 1] += 0.5 * mass[bar]
        wetted = water.density * widths[bar] * lengths[bar]
        if wetted > 0.0:
            law, normal, tangential = laws[bar], normals[bar], tangentials[bar]
            reynolds = diameters[bar] / water.viscosity
            a, across, _, _, _, _ = drag_factors(law, normal, tangential, passing, 0.0, reynolds)
            _, c, _, _, _, _ = drag_factors(law, normal, tangential, 0.0, passing, reynolds)
            slowing = max(slowing, wetted * a / (mass[bar] + added[bar]), wetted * max(across, c) / mass[bar])
    swinging = 0.0
    free = structure.free
    for node in range(len(velocity)):
        if free[node, 0] + free[node, 1] + free[node, 2] > 0.0:
            swinging = max(swinging, room[node, 0] / room[node, 1])
    rate = np.sqrt(swinging) + slowing
    return 2.0 / rate if rate > 0.0 else np.inf
