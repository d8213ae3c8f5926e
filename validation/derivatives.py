"""Derivatives against differences of full solves: ``python -m validation.derivatives [--plans 5] [--seed 0]``.

Plans of every kind, drawn at random: T0, T90 and square netting, with straps, with ropes, with a second layer, with a
window, of joined sections, of panels laced by selvedges, each with twine that stretches or not and a catch by one of
its four measures. Every real number
that they give is asked, and what implicit differentiation tells of drag, volume, opening and L50 is held to central
differences, by five points, of equilibria that are solved each for itself. Errors are relative to the derivative, or
where that is next to nothing to a hundredth of quantity over number. Where the front or a bar changes over between the
five points there is no derivative to compare: the table counts these as kinks. Retention is a sum over fish of some
shapes that try at some angles, in the order in which meshes let them through: where two change places L50 has a small
kink. Of a hundred meshes that differ a thousandth of the number holds hundreds of these, and slopes over one step and
another differ by some 1e-4. Where a difference is off by more than 1e-5 it is taken again over the step that the
derivative is taken over, and the table counts these too. Exits with 1 where an error is still above 1e-5; SR, a
difference of two lengths, is told and not held.
"""

import sys
from collections.abc import Iterator
from dataclasses import dataclass

import click
import numpy as np

from catch_models.fish import Species
from codend.equilibrium.fidelity import choose
from codend.errors import InputError
from codend.plan.numbers import alone, changed, numbers_of
from codend.plan.plan import Plan, plan_from_dict
from codend.selectivity.escape.species import example_species_path, load_species
from codend.studies.sensitivity.derivatives import STEP, Derivatives, sensitivity_of
from codend.studies.sensitivity.solved_case import SolvedCase, quantities, solved_case

KINDS = ("diamond", "t90", "square", "straps", "ropes", "joined", "panels", "layers", "windows")
APART = 1e-4
"""Between two of the five points, relative."""
SMALL = 1e-2
"""Of quantity over number: what errors of derivatives that are next to nothing are relative to."""
ALLOWED = 1e-5
FIVE_POINTS = {-2: 1.0 / 12.0, -1: -2.0 / 3.0, 1: 2.0 / 3.0, 2: -1.0 / 12.0}
TWO_POINTS = {-1: -0.5, 1: 0.5}
"""Weights of central differences, by steps from the middle."""


@dataclass(frozen=True)
class Compared:
    """One derivative beside a difference."""

    kind: str
    key: str
    quantity: str
    derivative: float
    difference: float
    error: float
    kink: bool
    again: bool
    """Whether it took the derivative's own step."""


def random_plan(kind: str, rng: np.random.Generator) -> Plan:
    """A plan of a kind, small enough for ropes to be quick."""
    mesh = kind if kind in ("diamond", "t90", "square") else str(rng.choice(["diamond", "t90"]))
    if kind in ("panels", "windows"):
        mesh = "diamond"
    fewest, most = {"panels": (6, 12), "ropes": (3, 7), "windows": (5, 8)}.get(kind, (10, 30))
    around, bar_mm = 4 * int(rng.integers(fewest, most)), rng.uniform(30.0, 60.0)
    knot_mm = 0.0 if mesh == "square" else float(rng.choice([0.0, 0.15])) * bar_mm
    section = {
        "mesh": mesh,
        "meshes_round": around,
        "meshes_long": int(rng.integers(12, 24) if kind in ("ropes", "windows") else rng.integers(20, 40)),
        "bar_mm": bar_mm,
        "knot_mm": knot_mm,
        "twine_mm": float(rng.uniform(0.04, 0.1)) * bar_mm,
    }
    if rng.random() < 0.5:
        section["axial_stiffness_n"] = float(rng.uniform(3e3, 3e4))
    if mesh != "square" and rng.random() < 0.5:
        section |= {"bending_stiffness_n_m2": float(rng.uniform(1e-5, 1e-4)), "rest_opening_deg": 25.0}
    if kind == "panels":
        section |= {"panels": int(rng.choice([2, 4])), "selvedge_meshes": 1}
    radius_m = around * (bar_mm + (knot_mm if mesh == "t90" else 0.0)) / 1000.0 / np.pi
    radius_m *= 0.5 if mesh == "square" else 1.0
    sections = [section]
    if kind == "joined":
        sections.append({**section, "meshes_round": around // 2, "bar_mm": 1.2 * bar_mm, "meshes_long": 15})
    long_m = sum(s["meshes_long"] * 2.0 * s["bar_mm"] / 1000.0 for s in sections)
    size = {
        "filled_meshes": float(rng.integers(3, 12)) + 0.27,
        "volume_m3": float(rng.uniform(0.05, 0.2)) * radius_m**2 * long_m,
        "mass_kg": 1000.0 * float(rng.uniform(0.05, 0.2)) * radius_m**2 * long_m,
        "front_from_codline_m": float(rng.uniform(0.1, 0.3)) * long_m,
    }
    measure = str(rng.choice(list(size)))
    catch = {measure: size[measure], "density_kg_m3": 1000.0}
    if rng.random() < 0.3:
        catch |= {"pressure": "uniform", "coefficient": 1.4}
    tables = {
        "title": kind,
        "tow": {"speed_m_s": float(rng.uniform(0.8, 1.8)), "water_density_kg_m3": 1000.0},
        "entry": {"radius_m": float(rng.uniform(0.25, 0.45)) * radius_m},
        "netting": sections,
        "catch": catch,
        "drag": {"law": str(rng.choice(["le-bris-1999", "bessonneau-1997"]))},
        "model": {"fidelity": "sector", "wrinkles": False},
    }
    if kind == "straps":
        length_m = float(rng.uniform(0.5, 0.8)) * 2.0 * np.pi * radius_m
        tables["strap"] = [{"meshes_from_codline": 4, "length_m": length_m, "diameter_mm": 20.0}]
    if kind == "layers":
        own = {"mesh": "diamond", "bar_mm": 2.3 * bar_mm, "twine_mm": 0.2 * bar_mm, "axial_stiffness_n": 5e3}
        rows = section["meshes_long"] // 2
        own |= {"meshes_round": int(rng.uniform(0.36, 0.42) * around), "meshes_long": rows // 2}
        tables["layer"] = [{**own, "meshes_from_codline": [0, rows]}]
    if kind == "windows":
        section |= {"panels": 2, "name": "host"}
        piece = {"mesh": "square", "meshes_round": 6, "meshes_long": 8, "bar_mm": float(rng.uniform(0.9, 1.1)) * bar_mm}
        place = {"netting": "host", "panel": "upper", "meshes_across": 6, "meshes_from_codline": [5, 9]}
        tables["window"] = [{**piece, **place, "twine_mm": section["twine_mm"]}]
        tables["model"] = {"fidelity": "full", "wrinkles": False}
    if kind == "ropes":
        rope = {"number": 4, "shortening": float(rng.uniform(0.1, 0.2)), "diameter_mm": 20.0, "axial_stiffness_n": 2e4}
        tables["rope"] = [{"kind": "lastridge", **rope}]
    return plan_from_dict(tables)


def compared(kind: str, plan: Plan, species: Species) -> Iterator[Compared]:
    """Every derivative by a real number beside a difference of five points; nothing where a plan is not solved."""
    choice, (case,) = choose(plan), plan.cases()
    keys = [one.key for one in numbers_of(plan, case) if not one.counted and one.value != 0.0]
    found = sensitivity_of(plan, case, [species], keys, choice)
    base = solved_case(alone(plan, case), choice)
    if found is None or base is None:
        return
    for one in found.numbers:
        value, size = one.number.value, abs(one.number.value)
        kink = min(value - one.kink_below, one.kink_above - value) < 3.0 * APART * size
        wide, own = _differences(base, one, species, APART, FIVE_POINTS), None
        for name, told in found.told.items():
            slope = one.slope[name]
            error = _error(slope, difference := wide.get(name, np.nan), told / size)
            if again := bool(not kink and error > ALLOWED):
                own = own or _differences(base, one, species, STEP, TWO_POINTS)
                error = _error(slope, difference := own.get(name, np.nan), told / size)
            yield Compared(kind, one.number.key, name, slope, difference, error, bool(kink), again)


def _error(slope: float, difference: float, scale: float) -> float:
    return abs(slope - difference) / max(abs(difference), SMALL * abs(scale))


def _differences(
    base: SolvedCase, one: Derivatives, species: Species, step: float, weights: dict[int, float]
) -> dict[str, float]:
    """Derivatives by solves at so many steps, relative, each with its weight; none where one is not solved."""
    step *= abs(one.number.value)
    found = dict.fromkeys(one.slope, 0.0)
    for steps, weight in weights.items():
        try:
            plan = changed(base.plan, one.number.key, one.number.value + steps * step)
        except InputError:
            return {}
        case = solved_case(plan, base.choice, base.solution)
        if case is None:
            return {}
        for name, value in quantities(case, [species]).items():
            found[name] += weight * value / step
    return found


@click.command()
@click.option("--plans", default=5, show_default=True, help="Of each kind.")
@click.option("--seed", default=0, show_default=True)
@click.option("--only", type=click.Choice(KINDS), help="One kind.")
@click.option("--show", is_flag=True, help="Every derivative that is off.")
def main(plans: int, seed: int, only: str | None, show: bool) -> None:
    """Print the largest error of every kind and quantity."""
    species = load_species(example_species_path())
    print("kind     plans  quantity           derivatives  kinks  missing  again  median    95 %      largest")
    worst = 0.0
    for kind in KINDS if only is None else (only,):
        rows: list[Compared] = []
        number = solved = 0
        while solved < plans and number < 4 * plans:
            plan = random_plan(kind, np.random.default_rng([seed, KINDS.index(kind), number]))
            own = list(compared(kind, plan, species))
            number, solved = number + 1, solved + bool(own)
            rows += own
        for name in dict.fromkeys(row.quantity for row in rows):
            of_name = [row for row in rows if row.quantity == name]
            smooth = [row for row in of_name if not row.kink]
            errors = np.array([row.error for row in smooth])
            known = errors[np.isfinite(errors)]
            worst = max(worst, known.max(initial=0.0) if name != "sr_cm" else 0.0)
            counts = (solved, name, len(smooth), len(of_name) - len(smooth), len(errors) - len(known))
            again = sum(row.again for row in smooth)
            sizes = (np.median(known), np.quantile(known, 0.95), known.max())
            print(
                "{:8} {:5}  {:18} {:11}  {:5}  {:7}  {:5}  {:.1e}   {:.1e}   {:.1e}".format(
                    kind, *counts, again, *sizes
                ),
                flush=True,
            )
            if show:
                for row in smooth:
                    if not row.error <= ALLOWED:
                        print(
                            f"    {row.key}: {row.derivative:.8g} beside {row.difference:.8g}, off by {row.error:.1e}"
                        )
    sys.exit(1 if worst > ALLOWED else 0)


if __name__ == "__main__":
    main()
