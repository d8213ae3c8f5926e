"""What second layers do to a codend: ``python -m validation.layers``.

A codend of 100 meshes round and 110 mm (its sizes assumed) bare, and with
strengthening bags over its last 30 meshes: one far larger, and ever tighter ones. Published for haddock in codends of
110 and 120 mm, with a strengthening bag against without: L50 about 1.9 cm lower. EA of the layers is assumed.
"""

from time import process_time

import click

from codend.plan.plan import Plan, plan_from_dict
from codend.selectivity.escape.catches import catches_of, run_of
from codend.selectivity.escape.haul import hauls_of
from codend.selectivity.escape.predict import predict_haul, rows_needed
from codend.selectivity.escape.species import Species, example_species_path, load_species
from codend.studies.study import solve

PUBLISHED_CM = -1.9
ROUND_SHARES = (2.0, 1.2, 0.9, 0.7)
"""Meshes round of the layers, of twice the mesh size, over half those of the codend."""


def codend_plan() -> Plan:
    """The codend without a layer."""
    netting = {
        "mesh": "diamond", "meshes_round": 100, "meshes_long": 40, "mesh_mm": 110.0, "knot_mm": 12.0, "twine_mm": 3.5,
    }  # fmt: skip
    return plan_from_dict(
        {
            "title": "under a strengthening bag",
            "tow": {"speed_m_s": 1.6, "water_density_kg_m3": 1026.0},
            "entry": {"radius_m": 0.35},
            "netting": [netting],
            "catch": {"mass_kg": [100.0, 300.0, 700.0, 1200.0]},
        }
    )


def l50_cm(plan: Plan, species: Species) -> float:
    """L50 of the whole haul."""
    (haul,) = hauls_of(catches_of(run_of(solve(plan)), rows_needed(species)))
    return float(predict_haul(species, haul, n_bootstrap=0, samples=0).l50_sr[-1, 0])


def with_layer(plan: Plan, share: float) -> Plan:
    """The plan under a layer of twice its mesh, so many of half its meshes round, over its last 30 meshes."""
    tables, below = plan.to_dict(), plan.netting[-1]
    long = min(30, below.meshes_long)
    tables["model"] |= {"wrinkles": False}
    tables["layer"] = [
        {
            "mesh": "diamond",
            "meshes_round": max(round(0.5 * share * below.meshes_round), 3),
            "meshes_long": long // 2,
            "bar_mm": 2000.0 * below.bar_m,
            "knot_mm": 2.0 * below.knot_mm,
            "twine_mm": below.twine_mm,
            "axial_stiffness_n": 3000.0,
            "meshes_from_codline": [0, long],
        }
    ]
    return plan_from_dict(tables)


@click.command(help=__doc__)
def main() -> None:
    """Print the table."""
    bare, species = codend_plan(), load_species(example_species_path())
    l50 = l50_cm(bare, species)
    click.echo(
        "layer, meshes round of half the codend's | hoop share, largest catch | opening ahead, deg | drag, N | L50, cm"
    )
    click.echo(f"| none | | {_ahead(bare)} | {l50:.2f} | |")
    for share in ROUND_SHARES:
        plan = with_layer(bare, share)
        began = process_time()
        study = solve(plan)
        spent = (process_time() - began) / len(study.cases)
        last = study.table.iloc[-1]
        changed = l50_cm(plan, species) - l50
        click.echo(
            f"| {share:g} | {last['layer_hoop_share']:.3f} | {_ahead(plan)} | "
            f"{changed:+.2f} ({PUBLISHED_CM:+.1f} published) | {1e3 * spent:.0f} ms |"
        )


def _ahead(plan: Plan) -> str:
    last = solve(plan).table.iloc[-1]
    return f"{last['opening_ahead_deg']:.2f} | {last['drag_n']:.1f}"


if __name__ == "__main__":
    main()
