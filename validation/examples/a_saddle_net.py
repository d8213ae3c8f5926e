"""A: a tight net of cables in a saddle, without any load. ``python -m validation.examples.a_saddle_net``.

Its edge is held on the saddle z = x y. Straight lines lie in that surface, so a net of cables along them is in balance
on it, each cable with one tension all along: EA times the strain with which it was tightened.
"""

import numpy as np

from codend import Net, Problem, find_equilibrium

side, stiffness_n, strain = 12, 5e4, 2e-3
grid = np.linspace(-1.0, 1.0, side)
y, x = (part.ravel() for part in np.meshgrid(grid, grid, indexing="ij"))
saddle = np.stack([x, y, x * y], axis=1)
number = np.arange(side**2).reshape(side, side)
along_x = np.stack([number[:, :-1].ravel(), number[:, 1:].ravel()], axis=1)
along_y = np.stack([number[:-1].ravel(), number[1:].ravel()], axis=1)
cables = np.concatenate([along_x, along_y])
tight = np.linalg.norm(saddle[cables[:, 1]] - saddle[cables[:, 0]], axis=1)
held = np.maximum(abs(x), abs(y)) == 1.0
flat = saddle * [1.0, 1.0, 0.0] + held[:, None] * saddle * [0.0, 0.0, 1.0]
net = Net.from_bars(flat, cables, held, length_m=tight / (1.0 + strain), stiffness_n=stiffness_n)
found = find_equilibrium(Problem.of(net))

off = np.abs(found.positions - saddle).max()
inside = ~(held[cables[:, 0]] & held[cables[:, 1]])
print(f"off the saddle by {off:.1e} m; tensions {found.bar_tension[inside].min():.6f} N and more")
assert off < 1e-9
assert np.allclose(found.bar_tension[inside], stiffness_n * strain, rtol=1e-8)
