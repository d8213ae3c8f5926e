"""The sizes of a plan's netting in the trade's words: which number was given and which follow from it."""

import math
from collections.abc import Iterator

from codend.plan.plan import Plan
from codend.plan.tables import Netting
from codend.plan.twines import DENSITY_KG_M3
from codend.plan.windows import Hole
from codend.report.style import number_text

LARGER = 1.02
"""Stretched length of a window over that of its place, or its width pulled fully open, from which it is told to be too
long or too wide."""


def size_sentences(plan: Plan) -> list[str]:
    """A sentence a section and a window about its mesh and, where a titre or a material is given, about its twine."""
    found = []
    for name, netting in _named(plan):
        found.append(f"{name}: {_mesh(netting)}.")
        if twine := _twine(netting):
            found.append(f"{name}: {twine}.")
    for (name, window), hole in zip(_named(plan)[len(plan.netting) :], plan.holes, strict=True):
        found += _too_large(name, window, plan.netting[hole.section], hole)
    if plan.entry.hanging_ratio is not None:
        found.append(
            f"Entry: radius {plan.entry_radius_m:.4g} m from the hanging ratio {plan.entry.hanging_ratio:g} times "
            f"{plan.netting[0].open_meshes[0]} open meshes of {_mm(plan.netting[0].full_mesh_m)} mm round."
        )
    return found


def derived_sizes(plan: Plan) -> list[str]:
    """Those of the sentences that tell what follows from a gauge, a titre, a material or a hanging ratio."""
    plain = [f"{name}: bar" for name, _ in _named(plan)]
    return [sentence for sentence in size_sentences(plan) if not sentence.startswith(tuple(plain))]


def _named(plan: Plan) -> list[tuple[str, Netting]]:
    """Sections and windows, each with what sentences call it."""
    names = [f"Section {name}" for name in plan.section_names] + [
        f"Window {window.name or number}" for number, window in enumerate(plan.window, start=1)
    ]
    return list(zip(names, (*plan.netting, *plan.window), strict=True))


def _too_large(name: str, window: Netting, part: Netting, hole: Hole) -> Iterator[str]:
    """That a window is longer or wider than the netting it takes the place of can be, and by how much."""
    own_m, place_m = window.stretched_length_m, part.stretched_length_m * hole.deep / part.meshes_long
    if own_m > LARGER * place_m:
        yield (
            f"{name}: stretched {own_m:.3g} m long in a place that "
            f"is {place_m:.3g} m stretched: what is too long hangs slack or in folds, and may have no equilibrium."
        )
    own_m, place_m = (
        2.0 * math.pi * meshes * netting.stretched_radius_per_mesh_m
        for meshes, netting in ((window.meshes_round, window), (hole.across, part))
    )
    if own_m > LARGER * place_m:
        yield (
            f"{name}: {own_m:.3g} m wide pulled fully open, in a place that is {place_m:.3g} m so: "
            "what is too wide hangs slack or in folds, and may have no equilibrium."
        )


def mass_text(kg: float) -> str:
    """A mass in tonnes where it is one or more, else in kilograms."""
    return f"{number_text(kg / 1000)} t" if kg >= 1000.0 else f"{number_text(kg)} kg"


def _mesh(section: Netting) -> str:
    given = next(key for key in ("inside_mesh_mm", "mesh_mm", "bar_mm") if getattr(section, key) is not None)
    sizes = {
        "inside_mesh_mm": f"inside mesh {_mm(section.inside_mesh_m)} mm",
        "mesh_mm": f"full mesh {_mm(section.full_mesh_m)} mm",
        "bar_mm": f"bar {_mm(section.bar_m)} mm",
    }
    first = sizes.pop(given)
    knot = f"a knot of {section.knot_mm:g} mm"
    if section.knot_mm == 0.0:
        knot = f"no knot_mm is given: to the gauge one two twines wide is taken, {_mm(2 * section.drag_width_m)} mm"
    return f"{first} is given; from it {' and '.join(sizes.values())} ({knot})"


def _twine(section: Netting) -> str:
    if section.mass_kg_m is None:
        return ""
    said = []
    if section.rtex_g_km is not None:
        given = f"twine number {section.twine_number}" if section.twine_number else ""
        given = given or (f"runnage {section.runnage_m_kg:g} m/kg" if section.runnage_m_kg else "")
        titre = f"R{section.rtex_g_km:.4g} tex ({1e6 / section.rtex_g_km:.4g} m/kg)"
        said.append(f"{titre} from {given}" if given else f"{titre} is given")
    if section.twine_mm is None:
        said.append(
            f"thickness {_mm(section.twine_m)} mm from that, as twisted {section.material} twine of the Fisherman's "
            "Workbook (FAO 1990) has it"
        )
    if section.twine_density_kg_m3 is None and section.material is not None:
        density = f"density {DENSITY_KG_M3[section.material]:g} kg/m3, that of {section.material}"
        if section.rtex_g_km is None:
            solid_tex = 1e6 * section.mass_kg_m / section.twines
            density += f"; as a solid rod it is R{solid_tex:.0f} tex, real twine is lighter: give rtex or runnage_m_kg"
        said.append(density)
    return "twine " + ", ".join(said) if said else ""


def _mm(metres: float) -> str:
    return f"{1000.0 * metres:.4g}"
