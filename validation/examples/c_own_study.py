"""C: a study of one's own: mesh size and meshes round against L50. ``python -m validation.examples.c_own_study``.

The species is the example whose numbers are assumed: what is asserted is a direction, not a number of any fish.
"""

import codend
from codend.selectivity.escape.species import example_species_path

plan = {
    "title": "A codend",
    "tow": {"speed_m_s": 1.5},
    "entry": {"radius_m": 0.4},
    "netting": [{"mesh": "diamond", "meshes_round": 100, "meshes_long": 50, "inside_mesh_mm": 100, "twine_mm": 4}],
    "catch": {"mass_kg": [200, 600]},
}
table = codend.sweep(
    {
        "plan": plan,
        "species": [str(example_species_path())],
        "vary": {"netting.0.inside_mesh_mm": [100, 120], "netting.0.meshes_round": [60, 100]},
    }
)
heaviest = table[table["case"] == 2].pivot(
    index="netting.0.meshes_round", columns="netting.0.inside_mesh_mm", values="l50_cm"
)
print(heaviest)
assert (heaviest[120] > heaviest[100]).all()
assert (heaviest.loc[60] > heaviest.loc[100]).all()
