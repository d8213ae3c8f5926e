"""B: diamond netting on fewer meshes round, and turned. ``python -m validation.examples.b_turned_netting``.

Fewer meshes round open further ahead of the catch, and let longer fish out. The species is the example whose numbers
are assumed: what is asserted is a direction, not a number of any fish.
"""

import codend
from codend.selectivity.escape.species import example_species_path

plan = {
    "title": "Diamond",
    "tow": {"speed_m_s": 1.5},
    "entry": {"radius_m": 0.4},
    "netting": [
        {"mesh": "diamond", "meshes_round": 100, "meshes_long": 40, "inside_mesh_mm": 105, "knot_mm": 15, "twine_mm": 4}
    ],
    "catch": {"mass_kg": 300},
}
designs = {
    "diamond, 100 round": {},
    "diamond, 50 round": {"netting.0.meshes_round": 50},
    "T90, 50 round": {"netting.0.mesh": "t90", "netting.0.meshes_round": 50},
}
l50_cm = {}
for name, changes in designs.items():
    study = codend.solve(plan, changes)
    table = codend.selectivity(study, example_species_path())
    l50_cm[name] = float(table["l50_cm"].iloc[0])
    print(f"{name}: opening {study.table['opening_ahead_deg'].iloc[0]:.1f} degrees, L50 {l50_cm[name]:.1f} cm")
assert l50_cm["diamond, 50 round"] > l50_cm["diamond, 100 round"]
assert l50_cm["T90, 50 round"] > l50_cm["diamond, 100 round"]
