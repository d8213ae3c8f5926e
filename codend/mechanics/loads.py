"""The loads of a net, the one list of them: their data, force, tangent and bound, each from its own file. Kernels.

A new load is a file with these functions and a line in each of the lists below.
"""

from typing import NamedTuple

import numpy as np

from codend.compiled import njit
from codend.mechanics import bending, catch_weight, contact, drag, inertia, points, pressure, seabed, wrap
from codend.mechanics.bars import add_bar_forces, bar_lengths
from codend.mechanics.contact import Contact
from codend.mechanics.inertia import Inertia
from codend.mechanics.points import Points
from codend.mechanics.pressure import Catch
from codend.mechanics.seabed import Seabed
from codend.mechanics.structure import Structure
from codend.mechanics.tangent import Pattern
from codend.mechanics.water import Water
from codend.net.net import Floats


class Loading(NamedTuple):
    """What acts on a net."""

    dead: Floats
    """Nodal forces that are the same wherever the net is, the wet weight among them, N, (n, 3)."""
    water: Water
    points: Points
    catch: Catch
    seabed: Seabed
    contact: Contact
    """What lies near what: a solver looks again as the net moves (``solvers.contact``)."""
    inertia: Inertia
    """Of the step at whose end the net is, none of a net at rest."""


@njit(cache=True)
def add_force(position: Floats, structure: Structure, loading: Loading, share: Floats, force: Floats) -> None:
    """Add all loads on a net to the nodal forces, N, (n, 3): all but the tension of its bars."""
    velocity = inertia.velocities(position, loading.inertia)
    add_moving_force(position, velocity, structure, loading, share, force)
    inertia.add_force(velocity, loading.inertia, force)


@njit(cache=True)
def add_moving_force(
    position: Floats, velocity: Floats, structure: Structure, loading: Loading, share: Floats, force: Floats
) -> None:
    """Add all loads on a net whose nodes move, ``velocity`` (n, 3), to the nodal forces, N."""
    add_in_parts(position, velocity, structure, loading, share, force, force, force)


@njit(cache=True)
def add_in_parts(
    position: Floats,
    velocity: Floats,
    structure: Structure,
    loading: Loading,
    share: Floats,
    on_twine: Floats,
    by_catch: Floats,
    rest: Floats,
) -> None:
    """Add the loads on a net whose nodes move to nodal forces, N, (n, 3) each: drag of bars, of the catch, and others.

    The catch presses with the water's pressure in it and by its weight.
    """
    dead = loading.dead
    for node in range(len(rest)):
        for i in range(3):
            rest[node, i] += dead[node, i]
    bending.add_force(position, structure, rest)
    drag.add_force(position, velocity, structure, loading.water, loading.catch, share, on_twine)
    points.add_force(position, velocity, loading.points, loading.water, rest)
    pressure.add_force(position, structure, loading.catch, share, by_catch)
    catch_weight.add_force(position, structure, loading.catch, share, by_catch)
    seabed.add_force(position, loading.seabed, rest)
    contact.add_force(position, loading.contact, rest)
    wrap.add_force(position, structure, rest)


@njit(cache=True, error_model="numpy")
def loads_and_supports(
    structure: Structure, loading: Loading, position: Floats, tension: Floats, share: Floats
) -> tuple[Floats, Floats]:
    """Loads on the nodes, the twine's bending among them, and what it takes to hold each so, N, each (n, 3).

    The latter is what a support carries, and at a free node what the solver leaves out of balance.

    Args:
        structure: the net.
        loading: what acts on it.
        position: nodes, (n, 3), m.
        tension: of its bars, N, (m,).
        share: of each band that lies in the catch, (bands,).
    """
    load = np.zeros_like(position)
    add_force(position, structure, loading, share, load)
    return load, supports(structure, position, tension, load)


@njit(cache=True, error_model="numpy")
def supports(structure: Structure, position: Floats, tension: Floats, load: Floats) -> Floats:
    """What it takes to hold each node under loads, N, (n, 3) both; arguments as of ``loads_and_supports``."""
    total, length = load.copy(), np.empty(len(tension))
    bar_lengths(position, structure, length)
    for bar in range(len(tension)):
        length[bar] = tension[bar] / length[bar] if length[bar] > 0.0 else 0.0
    add_bar_forces(position, structure, length, total)
    return -total


@njit(cache=True)
def add_tangent(
    position: Floats, structure: Structure, loading: Loading, pattern: Pattern, share: Floats, blocks: Floats
) -> None:
    """Add minus the derivative of all loads to the tangent, at given shares of the catch and height of its front."""
    bending.add_tangent(position, structure, pattern, blocks)
    velocity, rate = inertia.velocities(position, loading.inertia), loading.inertia.rate
    drag.add_tangent(position, velocity, rate, structure, loading.water, loading.catch, pattern, share, blocks)
    inertia.add_tangent(loading.inertia, pattern, blocks)
    points.add_tangent(position, loading.points, loading.water, pattern, blocks)
    pressure.add_tangent(position, structure, loading.catch, pattern, share, blocks)
    catch_weight.add_tangent(position, structure, loading.catch, pattern, share, blocks)
    seabed.add_tangent(position, loading.seabed, pattern, blocks)
    contact.add_tangent(position, loading.contact, pattern, blocks)
    wrap.add_tangent(position, structure, pattern, blocks)


@njit(cache=True)
def add_bound(position: Floats, structure: Structure, loading: Loading, share: Floats, bound: Floats) -> None:
    """Add a bound on the loads' part of each node's row of the stiffness, N/m, (n,).

    Drag has none: it changes by no more than a load per bar's length, which the tensions that carry it exceed.
    """
    bending.add_bound(position, structure, bound)
    pressure.add_bound(position, structure, loading.catch, share, bound)
    catch_weight.add_bound(position, structure, loading.catch, share, bound)
    seabed.add_bound(position, loading.seabed, bound)
    contact.add_bound(position, loading.contact, bound)
    wrap.add_bound(position, structure, bound)
