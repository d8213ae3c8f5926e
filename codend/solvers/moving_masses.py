"""Masses of a net in motion: of its bars, of the water that goes with them, and of its points."""

import numpy as np

from codend.mechanics import motion
from codend.mechanics.rigid import RigidPattern
from codend.net.net import Floats, Net


class MovingMasses:
    """What the nodes of a net weigh in motion."""

    def __init__(self, net: Net, water: float, added_mass: Floats | float) -> None:
        """Take it for bars of their density, or that of ``water``, kg/m3; ``added_mass`` is Cm, (m,) or of all."""
        volume = 0.25 * np.pi * net.bar_solid_diameter**2 * net.bar_length
        self.of_bars = np.where(np.isnan(net.bar_density), water, net.bar_density) * volume
        """kg, (m,)."""
        self.of_water = np.broadcast_to(added_mass, volume.shape) * water * volume
        """Added mass across every bar, kg, (m,)."""
        self.of_points = np.zeros(len(net.positions))
        """kg, (n,)."""
        np.add.at(self.of_points, net.point_node, net.point_mass)
        at_nodes = self.of_points.copy()
        np.add.at(at_nodes, net.bars.ravel(), np.repeat(self.of_bars, 2))
        if not np.all(at_nodes[~net.fixed.all(axis=1)] > 0.0):
            raise ValueError("bars in motion need a mass where they meet: give their diameter")
        self._bars_at = np.maximum(np.bincount(net.bars.ravel(), minlength=len(net.positions)), 1)
        self.blocks = np.zeros((len(net.positions), 3, 3))
        """Of the nodes, (n, 3, 3): as ``set_bare`` leaves them, and what is added to that."""

    @property
    def of_points_a_bar(self) -> Floats:
        """The points' for each bar at their node, kg, (n,)."""
        return self.of_points / self._bars_at

    def set_bare(self, pattern: RigidPattern, gradient: Floats, square: Floats) -> Floats:
        """The blocks of bars that lie as their gradients, (2 m, 3), and squared lengths, (m,), say."""
        self.blocks[:] = 0.0
        for i in range(3):
            self.blocks[:, i, i] = self.of_points
        motion.add_masses(pattern, gradient, square, self.of_bars, self.of_water, self.blocks)
        return self.blocks
