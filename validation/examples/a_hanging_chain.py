"""A: a chain between two hooks of the same height, under its weight. ``python -m validation.examples.a_hanging_chain``.

Its bars do not stretch. A chain of many bars hangs as the catenary does: of length s over a span L its sag is
a (cosh(L / 2 a) - 1), where 2 a sinh(L / 2 a) = s.
"""

import numpy as np
from scipy.optimize import brentq

from codend import Net, Problem, find_equilibrium

span, length, bars = 1.0, 1.4, 200
x = np.linspace(0.0, span, bars + 1)
nodes = np.stack([x, 0.0 * x, -0.5 * np.sin(np.pi * x)], axis=1)
ends = np.stack([np.arange(bars), np.arange(1, bars + 1)], axis=1)
held = (x == 0.0) | (x == span)
chain = Net.from_bars(nodes, ends, held, length_m=length / bars, diameter_m=0.01, density_kg_m3=7850.0)
found = find_equilibrium(Problem.of(chain))
sag = -found.positions[:, 2].min()

a = brentq(lambda a: 2.0 * a * np.sinh(span / (2.0 * a)) - length, 0.1, 10.0)
catenary = a * (np.cosh(span / (2.0 * a)) - 1.0)
print(f"sag {sag:.6f} m; of the catenary {catenary:.6f} m")
assert found.report.outcome.converged
assert abs(sag / catenary - 1.0) < 1e-4
