"""Rest of a net whose parts would pass through each other, by its motion: let go as built, with all parts in the way.

The motion (``solvers.motion``: pushes and tensions of one system) needs no start nearby and carries nothing through
anything; from where it is calm, gentle steps under contact lead to the balance.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from codend.mechanics.bars import bar_lengths
from codend.mechanics.problem import Problem
from codend.solvers.dynamic_relaxation import as_built
from codend.solvers.motion import Motion
from codend.solvers.outcome import Progress, Solution

METHOD = "motion"
ROUNDS, STEPS = 8, 400
"""Most rounds of so many time steps, after each of which the net is asked whether it is calm."""
OF_A_BAR, SLOWEST_M_S = 0.05, 0.5
"""What water passes of netting's median bar in a time step, at the speed of the current or this."""
CALM = 0.05
"""Root mean square of the nodes' speeds, over that of the water, at which a net is calm."""
LENGTH_ERROR = 0.05
DRAWN_IN = 0.99
"""By how much in a step bars that are built too long are drawn in."""
CROWDED, MANY = 0.5, 500
"""Pairs that meet, over the bars and in all, beyond which a motion takes too long: netting laid in a bundle."""


def calm_shapes(touching: Problem, progress: Progress | None = None) -> Iterator[Solution]:
    """Shapes on the way to rest from how a net under contact is built, each calmer than the one before."""
    net, water = touching.net, touching.loading.water
    if not np.all(net.bar_solid_diameter > 0.0):
        return  # without mass there is no motion
    speed = max(float(np.linalg.norm(water.flow, axis=1).max()), SLOWEST_M_S)
    dt = OF_A_BAR * float(np.median(net.bar_length[~net.bar_is_rope])) / speed
    motion, built = Motion(touching, net.positions, length_error=LENGTH_ERROR), as_built(touching)
    rest, length, as_long = motion.structure.length, np.empty(len(net.bars)), np.empty(len(net.bars))
    bar_lengths(net.positions, touching.structure, as_long)
    motion.stretching.strain[:] = 0.0  # drawn in, not pulled
    for number in range(1, ROUNDS * STEPS + 1):
        motion.structure = motion.structure._replace(length=np.maximum(rest, DRAWN_IN**number * as_long))
        try:
            motion.step(dt)
        except ArithmeticError:
            return
        if motion.meeting is not None and len(motion.meeting.nodes) > max(CROWDED * len(net.bars), MANY):
            return
        if number % STEPS > 0:
            continue
        moving = motion.structure.free.any(axis=1)
        swift = float(np.sqrt(np.mean(np.sum(motion.velocity[moving] ** 2, axis=1))))
        if progress is not None:
            progress(METHOD, swift / speed)
        if swift > CALM * speed and number < ROUNDS * STEPS:
            continue
        bar_lengths(motion.position, touching.structure, length)
        told = f"{METHOD} under contact from as built: calm after {motion.time:.3g} s"
        report = replace(built.report, attempts=(told,))
        yield replace(built, positions=motion.position.copy(), bar_tension=motion.density * length, report=report)
