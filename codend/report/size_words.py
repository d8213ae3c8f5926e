"""The sizes of a plan's netting in the trade's words: which number was given and which follow from it."""

from codend.plan.plan import Plan
from codend.plan.tables import Netting
from codend.plan.twines import DENSITY_KG_M3
from codend.report.style import number_text


def size_sentences(plan: Plan) -> list[str]:
    """A sentence a section about its mesh and, where a titre or a material is given, about its twine; the entry's."""
    found = []
    for name, section in zip(plan.section_names, plan.netting, strict=True):
        found.append(f"Section {name}: {_mesh(section)}.")
        if twine := _twine(section):
            found.append(f"Section {name}: {twine}.")
    if plan.entry.hanging_ratio is not None:
        found.append(
            f"Entry: radius {plan.entry_radius_m:.4g} m from the hanging ratio {plan.entry.hanging_ratio:g} times "
            f"{plan.netting[0].open_meshes[0]} open meshes of {_mm(plan.netting[0].full_mesh_m)} mm round."
        )
    return found


def derived_sizes(plan: Plan) -> list[str]:
    """Those of the sentences that tell what follows from a gauge, a titre, a material or a hanging ratio."""
    plain = [f"Section {name}: bar" for name in plan.section_names]
    return [sentence for sentence in size_sentences(plan) if not sentence.startswith(tuple(plain))]


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
        said.append(f"density {DENSITY_KG_M3[section.material]:g} kg/m3, that of {section.material}")
    return "twine " + ", ".join(said) if said else ""


def _mm(metres: float) -> str:
    return f"{1000.0 * metres:.4g}"
