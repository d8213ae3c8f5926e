"""A: a steel wire that hangs from a boat in a current. ``python -m validation.examples.a_cable_in_a_current``.

Nothing hangs at its end, so it lies straight at the angle a to the flow at which its weight w and its drag across it
balance (Le Bris et al. 1999, equation 4): w cos a = R sin^2 a, R = rho V^2 d Cd / 2 its drag per metre square to the
flow, or cos a = sqrt(1 + k^2) - k with k = w / 2 R.
"""

import numpy as np

from codend import Net, Problem, find_equilibrium
from codend.mechanics.drag_laws import drag
from codend.mechanics.water import uniform_flow

length, diameter, density, water, speed, bars = 50.0, 0.012, 7850.0, 1025.0, 1.5, 40
s = np.linspace(0.0, length, bars + 1)
nodes = np.stack([0.7 * s, 0.0 * s, -0.7 * s], axis=1)
ends = np.stack([np.arange(bars), np.arange(1, bars + 1)], axis=1)
law = drag("le-bris-1999", 1.36, 0.07)
wire = Net.from_bars(
    nodes, ends, s == 0.0, length_m=length / bars, diameter_m=diameter, density_kg_m3=density, drag=law
)
found = find_equilibrium(Problem.of(wire, water=uniform_flow(water, [speed, 0.0, 0.0])))
along, _, down = found.positions[-1] - found.positions[0]

weight = (density - water) * 9.80665 * np.pi * diameter**2 / 4.0
k = weight / (water * speed**2 * diameter * 1.36)
angle, critical = np.arctan2(-down, along), np.arccos(np.sqrt(1.0 + k**2) - k)
print(f"{np.degrees(angle):.6f} degrees to the flow; by the closed form {np.degrees(critical):.6f}")
assert abs(angle - critical) < 1e-7
