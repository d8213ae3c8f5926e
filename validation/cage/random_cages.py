"""Random cages in a current: how many are found in balance, and whether any of them passes through itself.

``python -m validation.cage --random 60``. Sides, netting, twine, ballast, seams and current are drawn; every answer is
judged by ``ipctk``, which shares no code with the search for contact, on the triangles of the netting.
"""

from collections.abc import Iterator
from time import process_time
from typing import Any

import ipctk
import numpy as np

from codend.mechanics.sheet import sheet_of
from codend.net.net import Floats
from codend.scenes.build import BuiltScene, build
from codend.scenes.measures import balance_error, solve_scene
from codend.scenes.scene import scene_from_dict
from validation.cage.gear import box, cylinder

UNLIKE_M = 1e-4
"""Of sides that are the same but for round-off and the tolerance."""


def random_cages(count: int, seed: int = 0) -> Iterator[dict[str, Any]]:
    """Tables of so many cages."""
    rng = np.random.default_rng(seed)
    for _ in range(count):
        speed, ballast = rng.uniform(0.0, 1.2), rng.uniform(2.0, 30.0)
        twine = {"twine_density_kg_m3": rng.uniform(920.0, 1150.0), "twine_mm": rng.uniform(0.8, 2.5)}
        foot = bool(rng.integers(2))
        if rng.random() < 0.2:
            sides = int(rng.integers(6, 11))
            yield cylinder(speed, sides=sides, merged=6, ballast_kg=ballast, along_foot=foot, **twine)
        else:
            merged = int(rng.choice([5, 8, 10]))
            lengths = tuple(rng.uniform(0.8, 1.2, size=2))
            ropes = bool(rng.integers(2))
            yield box(speed, merged=merged, ballast_kg=ballast, sides_m=lengths if ropes else (1.0, 1.0),
                      along_foot=foot, seam_ropes=ropes, **twine)  # fmt: skip


def crosses_itself(built: BuiltScene, positions: Floats) -> bool:
    """Whether netting passes through netting, by ipctk."""
    sheet = sheet_of(built.problem.net)
    triangles = sheet.face[sheet.face[:, 1] != sheet.face[:, 2]]
    mesh = ipctk.CollisionMesh(built.problem.net.positions, sheet.edge, triangles)
    return bool(ipctk.has_intersections(mesh, np.asfortranarray(positions)))


def judged(count: int, seed: int) -> tuple[str, bool]:
    """What came of random cages, in words, and whether no answer is wrong."""
    found, touching, began = 0, 0, process_time()
    lost, crossed, unbalanced, leaving, unlike = [], [], [], [], []
    for number, data in enumerate(random_cages(count, seed)):
        built = build(scene_from_dict(data))
        result = solve_scene(built)
        if not result.converged:
            lost.append(number)
            continue
        found += 1
        touching += len(result.built.problem.loading.contact.kind) > 0
        crossed += [number] if crosses_itself(built, result.solution.positions) else []
        unbalanced += [number] if balance_error(result) > 1e-8 else []
        leaving += [number] if result.stable == "no" else []
        unlike += [number] if result.unlike_sides_m > UNLIKE_M else []
    said = (
        f"{found} of {count} random cages found in balance ({touching} with netting near netting), not found: "
        f"{lost or 'none'}; passed through themselves, by ipctk: {crossed or 'none'}; loads and supports out of "
        f"balance by more than 1e-8: {unbalanced or 'none'}; told as not stable: {leaving or 'none'}; told as unlike "
        f"on their two sides: {unlike or 'none'}; {process_time() - began:.0f} s of processor time"
    )
    return said, not (crossed or unbalanced)
