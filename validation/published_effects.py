"""What changes of a codend do to L50, computed with one push for all, beside what trials have published.

Seven effects: mesh size, bending stiffness, meshes round, T90, catch, lastridge ropes, doubling of twine. Codends and
the fish are of assumed sizes (110 mm mesh, 4.4 m, `codend species`), the twine's stiffness too, the push is given by
`--push` and fitted to nothing. L50 is of whole hauls, off the computed curve. A published effect has a sign and, where
a number is at hand, a range; where none is, the size is not judged. A number published alone is taken as a range of a
sixth either way, or a twentieth of a ratio, and "the larger part" of one as half to all: those widths are this table's.

Run as ``python -m validation.published_effects``.
"""

from __future__ import annotations

from dataclasses import dataclass

import click
import numpy as np

import codend
from catch_models.fish import Species
from codend.plan.plan import Plan, plan_from_dict
from codend.selectivity.escape.catches import catches_of, run_of
from codend.selectivity.escape.haul import hauls_of
from codend.selectivity.escape.predict import predict_haul, rows_needed
from codend.selectivity.escape.species import example_species_path, load_species
from validation.calibration_study import changed

LIMP_N_M2 = 1e-4
"""Assumed, of a single 3.5 mm twine; that of others grows with the fourth power of the diameter."""
MASSES_KG = (50.0, 150.0, 400.0, 800.0)
UNKNOWN = (np.nan, np.nan)
DIRECTIONS = "as quoted in tests/selectivity/escape/test_selectivity.py"
ONEILL = "O'Neill et al. 2016, Fish. Res. 176: 94-99, abstract (haddock)"
SISTIAGA = "Sistiaga et al. 2023, Fish. Res., 10.1016/j.fishres.2023.106671, abstract (cod, haddock, redfish)"


@dataclass(frozen=True)
class Effect:
    """One effect on L50, its published sign and range (nan: none at hand), and the source."""

    name: str
    value: float
    neutral: float
    rises: bool
    published: tuple[float, float]
    source: str

    @property
    def sign_right(self) -> bool:
        """Whether L50 changes the way the trials found."""
        return (self.value > self.neutral) == self.rises

    @property
    def inside(self) -> bool | None:
        """Whether the size lies in the published range; None where there is none."""
        low, high = self.published
        return None if np.isnan(low) else low <= self.value <= high


def codend_plan(bending_n_m2: float = LIMP_N_M2, mesh_mm: float = 110.0, **netting: object) -> Plan:
    """A codend of 100 meshes of 110 mm round, or with other keys of its netting; ``rope`` is a table of its own."""
    rope = netting.pop("rope", None)
    section: dict[str, object] = {
        "mesh": "diamond",
        "meshes_round": 100,
        "meshes_long": round(4400 / mesh_mm),
        "mesh_mm": mesh_mm,
        "knot_mm": 12.0,
        "twine_mm": 3.5,
        "bending_stiffness_n_m2": bending_n_m2,
    } | netting
    section["rest_opening_deg"] = 160.0 if section["mesh"] == "t90" else 20.0
    tables: dict[str, object] = {
        "title": "published effects",
        "tow": {"speed_m_s": 1.6, "water_density_kg_m3": 1026.0},
        "entry": {"radius_m": 0.35},
        "netting": [section],
        "catch": {"mass_kg": list(MASSES_KG)},
    }
    return plan_from_dict(tables | ({"rope": [rope]} if rope else {}))


def l50_cm(plan: Plan, species: Species) -> tuple[float, float]:
    """L50 of the whole haul, and how much it is longer at the largest than at the smallest catch."""
    study = codend.solve(plan)
    if not study.converged:
        return np.nan, np.nan
    (haul,) = hauls_of(catches_of(run_of(study), rows_needed(species)))
    found = predict_haul(species, haul, n_bootstrap=0, samples=0).l50_sr[:, 0]
    return float(found[-1]), float(found[-2] - found[0])


def effects(push_n: float, ropes: bool) -> list[Effect]:
    """All seven with one push, or those without ropes."""
    species = changed(load_species(example_species_path()), {"behaviour.push_force_n": push_n})
    base, by_catch = l50_cm(codend_plan(), species)

    def other(*given: float, **changes: object) -> float:
        return l50_cm(codend_plan(*given, **changes), species)[0]

    sizes = {mm: codend_plan(LIMP_N_M2, mm, meshes_round=round(11000 / mm)) for mm in (90.0, 130.0)}
    of_sizes = {mm: l50_cm(plan, species)[0] / (100.0 * plan.netting[0].inside_mesh_m) for mm, plan in sizes.items()}
    thick = {"twine_mm": 6.0, "twines": 2}
    laced = {"kind": "lastridge", "number": 2, "shortening": 0.15, "diameter_mm": 24.0}
    halved = other(meshes_round=50) - base
    turned = other(mesh="t90", meshes_round=50) - base
    factor = float(np.mean(list(of_sizes.values())))
    rope = other(rope=laced) - base if ropes else np.nan
    doubled = other(2.0 * (6.0 / 3.5) ** 4 * LIMP_N_M2, **thick) / base
    stiffer = other(4.0 * LIMP_N_M2) - base
    found = [
        Effect("mesh size: L50 over inside mesh", factor, 0.0, True, (2.6, 2.9), f"haddock, {DIRECTIONS}"),
        Effect("bending stiffness x 4, cm", stiffer, 0.0, False, UNKNOWN, ONEILL),
        Effect("meshes round halved, cm", halved, 0.0, True, (6.0, 12.0), f"larger part of 12 cm, {DIRECTIONS}"),
        Effect("halved and T90, cm", turned, 0.0, True, (10.0, 14.0), f"about 12 cm, {DIRECTIONS}"),
        Effect("catch 50 to 800 kg, cm", by_catch, 0.0, True, UNKNOWN, ONEILL),
        Effect("lastridge ropes 15 % short, cm", rope, 0.0, True, UNKNOWN, SISTIAGA),
        Effect("3.5 to double 6 mm, ratio", doubled, 1.0, False, (0.857, 0.947), f"2.38 / 2.64, {DIRECTIONS}"),
    ]
    return [one for one in found if np.isfinite(one.value)]


@click.command(help=__doc__)
@click.option("--push", default=1.0, show_default=True, help="Of a fish of 30 cm, N: assumed, one for all.")
@click.option("--ropes", is_flag=True, help="Lastridge ropes as well, which take minutes.")
def main(push: float, ropes: bool) -> None:
    """Print the table."""
    found = effects(push, ropes)
    click.echo(f"push {push:g} N (L / 30 cm)^2, assumed")
    for one in found:
        size = {True: "inside", False: "outside", None: "not judged"}[one.inside]
        published = "" if one.inside is None else f"{one.published[0]:g} to {one.published[1]:g}"
        sign = "right" if one.sign_right else "WRONG"
        click.echo(f"{one.name:34s} {one.value:+8.2f}  {published:12s} sign {sign}, size {size:16s} {one.source}")
    judged = [one.inside for one in found if one.inside is not None]
    signs = sum(one.sign_right for one in found)
    click.echo(f"signs right: {signs} of {len(found)}; sizes inside: {sum(judged)} of the {len(judged)} with a range")


if __name__ == "__main__":
    main()
