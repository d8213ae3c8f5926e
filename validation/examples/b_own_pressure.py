"""B: a pressure law of one's own. ``python -m validation.examples.b_own_pressure``.

The catch's front is open, so that with the same pressure everywhere and no twine drag the drag is that pressure times
the polygon in which the front's row of knots lies: here of 60 corners.
"""

from math import pi, sin

import codend

plan = codend.Plan.from_dict(
    {
        "title": "A law of one's own",
        "tow": {"speed_m_s": 1.0, "water_density_kg_m3": 1000.0},
        "entry": {"radius_m": 0.3},
        "netting": [{"mesh": "diamond", "meshes_round": 60, "meshes_long": 40, "bar_mm": 40, "twine_mm": 2}],
        "catch": {"filled_meshes": 12},
        "drag": {"normal": 0.0},
    }
).with_pressure(lambda theta_deg: 1.2)
found = codend.solve(plan).table.iloc[0]

polygon_m2 = 60 / 2 * sin(2 * pi / 60) * found["front_radius_m"] ** 2
print(f"drag {found['drag_n']:.4f} N; pressure times the front {1.2 * 500.0 * polygon_m2:.4f} N")
assert abs(found["drag_n"] / (1.2 * 500.0 * polygon_m2) - 1.0) < 1e-6
