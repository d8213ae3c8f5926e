"""A: a codend from a plan, its drag and openings. ``python -m validation.examples.a_first_run``.

What holds the entry equals the drag of twine and catch together.
"""

import codend

plan = {
    "title": "A first run",
    "tow": {"speed_m_s": 1.5},
    "entry": {"hanging_ratio": 0.3},
    "netting": [
        {"mesh": "diamond", "meshes_round": 100, "meshes_long": 50, "inside_mesh_mm": 110, "knot_mm": 12, "twine_mm": 4}
    ],
    "catch": {"mass_kg": [200, 500]},
}
study = codend.solve(plan)
print(study.table[["catch_mass_kg", "drag_n", "opening_ahead_deg"]])
assert study.converged
assert abs(study.table["entry_reaction_n"] / study.table["drag_n"] - 1.0).max() < 1e-6
