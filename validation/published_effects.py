"""What changes of a codend do to L50, computed with one push for all, beside what trials have published.

Seven effects: mesh size, bending stiffness, meshes round, T90, catch, lastridge ropes, thicker twine; and three of
small meshes, whose twine of 2.5 mm, length and catches are assumed as all codends' are: meshes round and mesh size of
turned netting, as published of hake and horse mackerel (their range here is that of both, with its standard errors),
and meshes round of square netting, with a fish whose section was measured (``codend species red-mullet``). Codends are
of assumed sizes (a gauge of 110 mm as the published ones, 4.4 m), the twine's stiffness too; every push of a range is
assumed as well, and none is fitted to any of this. The fish is that of `codend species` but for its section, which
follows from a condition factor of 1 (a fish of 30 cm weighs 270 g), a body that fills 0.6 of its length times its
largest section, and an ellipse two thirds as wide as it is high: assumed, and not of one species. Meshes round and T90
are asked of double 5 mm twine, which is assumed for such codends: turned netting differs by its stiffness. What is
published of them was simulated, for fish that push nothing; of twine it is of trials with haddock in meshes of 100 mm,
from double to double. Ropes are smeared over all meshes, and shapes that are not the same all round are not followed.
L50 is of whole hauls, off the computed curve. A published effect has a sign and, where a number is at hand, a range;
where none is, the size is not judged. A number published alone is taken as a range of a sixth either way, or a
twentieth of a ratio: those widths are this table's.

Where the sizes are missed, and why. Turning the meshes adds 7 to 8 cm where 2.4 to 3.4 are published: with twine of EI
1e-4 N m2 in place of 8e-4 it takes 6 cm off, so that the answer hangs on a stiffness which that study does not state.
Half the meshes round then add 8.0 cm, and both 7.5. From double 6 to double 4 mm twine L50 rises by half of what is
published unless fish push hard; the stiffness of the twines of the trials is at hand of none of them. Square meshes
twice as many lower L50 by 0.9 cm where 2.5 are published: with half of the catches by 1.3, with a quarter by 2.4, with
an eighth by 4.1, so that it hangs on the catch, which the abstract does not state. Half the turned meshes round add 1.8
cm where at most 1.3 are published, and hang on the twine: 1.8 mm in place of 2.5 mm adds 4.9.

All codends of double 4 mm twine that stretches (EA of 10 kN a single 3.5 mm twine; twice or half of it is the same)
need a push of 4 N for the same L50, as neighbours hold the meshes: then T90 adds 2.8 cm, half the meshes 7.1, both 9.8,
mesh size gives 2.64 and thicker twine 0.94; as many of the six sizes of large meshes are inside. Eleven catches in
place of four give 2.9, 7.0 and 9.5 cm there: what lies so near an end of its range is neither in nor out.

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
from codend.selectivity.escape.haul import Haul, hauls_of
from codend.selectivity.escape.predict import predict_haul, rows_needed
from codend.selectivity.escape.species import example_species_path, load_species, shipped_species_path
from validation.calibration_study import changed

LIMP_N_M2 = 1e-4
"""Assumed, of a single 3.5 mm twine; that of others grows with the fourth power of the diameter."""
MASSES_KG = (50.0, 150.0, 400.0, 800.0)
PUSHES_N = (0.0, 0.5, 1.0, 2.0, 3.0)
HEIGHT, WIDTH = 0.178, 0.119
"""Assumed section of a fish over its length: 0.6 pi / 4 of their product is 0.01, the condition factor of 1."""
UNKNOWN = (np.nan, np.nan)
DIRECTIONS = "as quoted in tests/selectivity/escape/test_selectivity.py"
HERRMANN = "Herrmann et al. 2007, Fish. Res. 84(2): 222-232, abstract (simulated, 110 mm)"
LOWRY = "2.38 / 2.64: Lowry and Robertson 1996, Fish. Res. 26: 353-363, abstract (haddock)"
ONEILL = "O'Neill et al. 2016, Fish. Res. 176: 94-99, abstract (haddock)"
SISTIAGA = "Sistiaga et al. 2023, Fish. Res., 10.1016/j.fishres.2023.106671, abstract (cod, haddock, redfish)"
KYNOCH = "almost 4 cm: Kynoch et al. 1999, Mar. Technol. Soc. J. 33(2): 61-72, abstract (haddock, 100 mm)"
GENC = (
    "Sensurat Genc et al. 2018, Ege J. Fish. Aquat. Sci. 35(2): 157-168, abstract (hake, horse mackerel; T90 of 44 mm, "
    "300 and 150 round, and of 40 mm, 165)"
)
SALA = "Sala et al. 2016, PLoS ONE 11(7): e0160354, abstract (red mullet, square meshes)"
ROPE: dict[str, object] = {"kind": "lastridge", "number": 2, "shortening": 0.15, "diameter_mm": 24.0}


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

    @property
    def mark(self) -> str:
        """A star where the size is inside, an exclamation mark where the sign is wrong."""
        if not self.sign_right:
            return "!"
        return "*" if self.inside else " "


def assumed_fish() -> Species:
    """The fish of ``codend species`` with the section of a condition factor of 1."""
    section = {"section.height_per_length": HEIGHT, "section.width_per_length": WIDTH}
    return changed(load_species(example_species_path()), section)


def bending_n_m2(twine_mm: float, twines: int = 1) -> float:
    """Assumed stiffness of a bar of such twine."""
    return twines * (twine_mm / 3.5) ** 4 * LIMP_N_M2


def codend_plan(
    twine_mm: float = 3.5, twines: int = 1, *, stiffer: float = 1.0, mesh_mm: float = 110.0, **other: object
) -> Plan:
    """A codend of 100 meshes of a gauge of 110 mm round, or with other keys; ``rope`` is a table of its own."""
    rope = other.pop("rope", None)
    section: dict[str, object] = {
        "mesh": "diamond",
        "meshes_round": 100,
        "meshes_long": round(4400 / mesh_mm),
        "inside_mesh_mm": mesh_mm,
        "knot_mm": 12.0,
        "twine_mm": twine_mm,
        "twines": twines,
        "bending_stiffness_n_m2": stiffer * bending_n_m2(twine_mm, twines),
    } | other
    section["rest_opening_deg"] = 160.0 if section["mesh"] == "t90" else 20.0
    tables: dict[str, object] = {
        "title": "published effects",
        "tow": {"speed_m_s": 1.6, "water_density_kg_m3": 1026.0},
        "entry": {"radius_m": 0.35},
        "netting": [section],
        "catch": {"mass_kg": list(MASSES_KG)},
        "model": {"wrinkles": False, "fidelity": "smeared" if rope else "auto"},
    }
    return plan_from_dict(tables | ({"rope": [rope]} if rope else {}))


def small_meshes(mesh: str, meshes_round: int, mesh_mm: float) -> Plan:
    """A codend of small meshes of single twine, as long as the others."""
    square = mesh == "square"
    own = {"knot_mm": 0.0, "bending_stiffness_n_m2": 0.0} if square else {"knot_mm": 6.0}
    long = round(4400 / (mesh_mm / 2.0 if square else mesh_mm))
    return codend_plan(2.5, mesh_mm=mesh_mm, mesh=mesh, meshes_round=meshes_round, meshes_long=long, **own)


def plans() -> dict[str, Plan]:
    """Codends that the effects are differences of, by name."""
    return {
        "single 3.5 mm": codend_plan(),
        "four times as stiff": codend_plan(stiffer=4.0),
        "90 mm": codend_plan(mesh_mm=90.0, meshes_round=122),
        "130 mm": codend_plan(mesh_mm=130.0, meshes_round=85),
        "ropes": codend_plan(rope=ROPE),
        "double 3.5 mm": codend_plan(3.5, 2, mesh_mm=100.0),
        "double 4 mm": codend_plan(4.0, 2, mesh_mm=100.0),
        "double 6 mm": codend_plan(6.0, 2, mesh_mm=100.0),
        "double 5 mm": codend_plan(5.0, 2),
        "halved": codend_plan(5.0, 2, meshes_round=50),
        "turned": codend_plan(5.0, 2, mesh="t90"),
        "halved and turned": codend_plan(5.0, 2, mesh="t90", meshes_round=50),
        "turned 44 mm, 300": small_meshes("t90", 300, 44.0),
        "turned 44 mm, 150": small_meshes("t90", 150, 44.0),
        "turned 40 mm, 165": small_meshes("t90", 165, 40.0),
        "square 40 mm, 107": small_meshes("square", 107, 40.0),
        "square 40 mm, 213": small_meshes("square", 213, 40.0),
    }


def hauls(species: Species) -> dict[str, Haul]:
    """The codends of ``plans`` solved; none of one that was not."""
    found = {}
    for name, plan in plans().items():
        study = codend.solve(plan)
        if study.converged:
            (found[name],) = hauls_of(catches_of(run_of(study), rows_needed(species)))
    return found


def red_mullet() -> Species:
    """That of ``codend species red-mullet``, which alone is measured."""
    return load_species(shipped_species_path("red-mullet"))


def effects(hauls: dict[str, Haul], species: Species, push_n: float) -> list[Effect]:
    """All of them with one push."""
    push = {"behaviour.push_force_n": push_n}
    pushing, mullet = changed(species, push), changed(red_mullet(), push)
    curves = {
        name: predict_haul(mullet if "square" in name else pushing, haul, n_bootstrap=0, samples=0).l50_sr[:, 0]
        for name, haul in hauls.items()
    }
    l50 = {name: float(values[-1]) for name, values in curves.items()}
    of_catches = curves["single 3.5 mm"][:-1]
    base = l50["single 3.5 mm"]
    inside = {name: 100.0 * plan.netting[0].inside_mesh_m for name, plan in plans().items()}
    factor = float(np.mean([l50[name] / inside[name] for name in ("90 mm", "130 mm")]))
    halved, turned, both = (l50[name] - l50["double 5 mm"] for name in ("halved", "turned", "halved and turned"))
    thicker, thinner = l50["double 6 mm"] / l50["double 3.5 mm"], l50["double 4 mm"] - l50["double 6 mm"]
    fewer_turned, larger_turned = (
        l50["turned 44 mm, 150"] - l50[name] for name in ("turned 44 mm, 300", "turned 40 mm, 165")
    )
    more_square = l50["square 40 mm, 213"] - l50["square 40 mm, 107"]
    stiffer, by_catch = l50["four times as stiff"] - base, float(of_catches[-1] - of_catches[0])
    return [
        Effect("mesh size: L50 over inside mesh", factor, 0.0, True, (2.6, 2.9), f"haddock, {DIRECTIONS}"),
        Effect("bending stiffness x 4, cm", stiffer, 0.0, False, UNKNOWN, ONEILL),
        Effect("meshes round halved, cm", halved, 0.0, True, (7.1, 9.9), f"71 % of 12 cm: {HERRMANN}"),
        Effect("T90, cm", turned, 0.0, True, (2.4, 3.4), f"24 % of 12 cm: {HERRMANN}"),
        Effect("halved and T90, cm", both, 0.0, True, (10.0, 14.0), f"nearly 12 cm: {HERRMANN}"),
        Effect("catch 50 to 800 kg, cm", by_catch, 0.0, True, UNKNOWN, ONEILL),
        Effect("lastridge ropes 15 % short, cm", l50["ropes"] - base, 0.0, True, UNKNOWN, SISTIAGA),
        Effect("double 3.5 to double 6 mm, ratio", thicker, 1.0, False, (0.857, 0.947), LOWRY),
        Effect("double 6 to double 4 mm, cm", thinner, 0.0, True, (3.3, 4.7), KYNOCH),
        Effect("T90 44 mm, 300 to 150 round, cm", fewer_turned, 0.0, True, (-0.4, 1.3), GENC),
        Effect("T90 40 to 44 mm, cm", larger_turned, 0.0, True, (0.5, 2.8), GENC),
        Effect("square, 107 to 213 round, cm", more_square, 0.0, False, (-2.9, -2.1), SALA),
    ]


@click.command(help=__doc__)
def main() -> None:
    """Print the table."""
    species = assumed_fish()
    solved = hauls(species)
    missing = plans().keys() - solved.keys()
    if missing:
        raise click.ClickException(f"not solved: {', '.join(sorted(missing))}")
    by_push = [effects(solved, species, push) for push in PUSHES_N]
    columns = "".join(f"{f'{push:g} N':>9s}" for push in PUSHES_N)
    click.echo(f"push of a fish of 30 cm, assumed, one for all; it grows as the length squared\n{'':34s}{columns}")
    for each in zip(*by_push, strict=True):
        values = "".join(f"{one.value:+8.2f}{one.mark}" for one in each)
        published = "none at hand" if each[0].inside is None else "{:g} to {:g}".format(*each[0].published)
        click.echo(f"{each[0].name:34s}{values}  {published:15s} {each[0].source}")
    signs = "".join(f"{sum(one.sign_right for one in found):7d}/{len(found)}" for found in by_push)
    judged = [[one.inside for one in found if one.inside is not None] for found in by_push]
    click.echo(f"{'signs right':34s}{signs}")
    click.echo(f"{'sizes inside, of those published':34s}" + "".join(f"{sum(one):7d}/{len(one)}" for one in judged))
    click.echo("* inside the published range, ! of the wrong sign")


if __name__ == "__main__":
    main()
