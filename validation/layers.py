"""What second layers do to a codend and to L50: ``python -m validation.layers``.

Codends of 100 meshes round of 110 and 120 mm (their sizes assumed) bare, and with strengthening bags of 265 mm mesh and
6 mm twine over their last 30 meshes, of several meshes round: held to the netting below, as the model has them, and as
nets of their own in contact without friction. Published for haddock in codends of 110 and 120 mm, with such a bag
against without: L50 about 1.9 cm lower. Its meshes round are not at hand, and how much its twine stretches is assumed.
"""

from dataclasses import replace
from math import ceil
from time import process_time

import click

from codend.equilibrium.bag_model import model_of
from codend.equilibrium.layer_contact import in_contact
from codend.plan.plan import Plan, plan_from_dict
from codend.selectivity.escape.catches import Run, catches_of, run_of
from codend.selectivity.escape.haul import hauls_of
from codend.selectivity.escape.predict import predict_haul, rows_needed
from codend.selectivity.escape.species import Species, example_species_path, load_species
from codend.studies.case_result import CaseResult
from codend.studies.study import Study, measured, solve

PUBLISHED_CM = -1.9
MESHES_MM = 110.0, 120.0
MESHES_ROUND = 100, 50, 40, 30, 25
"""Of the layers, assumed: 41.5 and 45.3 are as wide as the codends."""
LAYER_MM, LAYER_TWINE_MM = 265.0, 6.0
MESHES_BELOW = 30


def codend_plan(mesh_mm: float = 110.0) -> Plan:
    """The codend without a layer."""
    netting = {
        "mesh": "diamond", "meshes_round": 100, "meshes_long": 40, "mesh_mm": mesh_mm, "knot_mm": 12.0, "twine_mm": 3.5,
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


def with_layer(plan: Plan, meshes_round: int) -> Plan:
    """The plan under a layer so many meshes round, as long as its last 30 meshes."""
    tables, below = plan.to_dict(), plan.netting[-1]
    tables["model"] |= {"wrinkles": False, "contact": False}
    own = {"mesh": "diamond", "mesh_mm": LAYER_MM, "knot_mm": 2.0 * below.knot_mm, "twine_mm": LAYER_TWINE_MM}
    long = ceil(MESHES_BELOW * 2000.0 * (below.bar_m + below.knot_m) / LAYER_MM)
    over = {"meshes_from_codline": [0, MESHES_BELOW], "axial_stiffness_n": 3000.0}
    tables["layer"] = [own | over | {"meshes_round": meshes_round, "meshes_long": long}]
    return plan_from_dict(tables)


def l50_cm(run: Run, species: Species) -> float:
    """L50 of the whole haul."""
    (haul,) = hauls_of(catches_of(run, rows_needed(species)))
    return float(predict_haul(species, haul, n_bootstrap=0, samples=0).l50_sr[-1, 0])


def slid(study: Study) -> tuple[Run, int]:
    """The run of a study with its layers as nets of their own in contact, and in how many catches they come to rest."""
    cases = [_slid(study.plan, case) for case in study.cases]
    free = Study(study.plan, study.choice, tuple(one or held for one, held in zip(cases, study.cases, strict=True)))
    return replace(run_of(free), layers=study.layers), sum(one is not None for one in cases)


def _slid(plan: Plan, held: CaseResult) -> CaseResult | None:
    found = in_contact(model_of(plan, 1, 1), held.case, held.problem, held.solution)
    return None if found is None or not found[2].report.outcome.converged else measured(found[0], held.case, *found[1:])


@click.command(help=__doc__)
def main() -> None:
    """Print the table."""
    species = load_species(example_species_path())
    click.echo(
        f"mesh | layer: meshes round | width over the codend's | largest catch: hoop share | drag N | opening deg | "
        f"L50 cm (published {PUBLISHED_CM:+.1f}) | in contact: at rest | drag N | opening deg | L50 cm | s a catch"
    )
    for mesh_mm in MESHES_MM:
        bare = solve(codend_plan(mesh_mm))
        l50, last = l50_cm(run_of(bare), species), bare.table.iloc[-1]
        click.echo(f"{mesh_mm:g} | none | | | {last['drag_n']:.1f} | {last['opening_ahead_deg']:.2f} | {l50:.2f} |")
        for meshes_round in MESHES_ROUND:
            plan = with_layer(bare.plan, meshes_round)
            began = process_time()
            study = solve(plan)
            free, at_rest = slid(study)
            spent = (process_time() - began) / len(study.cases)
            held, moved = study.table.iloc[-1], free.results.iloc[-1]
            width = plan.layer[0].stretched_radius_m / plan.netting[0].stretched_radius_m
            click.echo(
                f"{mesh_mm:g} | {meshes_round} | {width:.2f} | {held['layer_hoop_share']:.3f} | {held['drag_n']:.1f} | "
                f"{held['opening_ahead_deg']:.2f} | {l50_cm(run_of(study), species) - l50:+.2f} | {at_rest} of "
                f"{len(study.cases)} | {moved['drag_n']:.1f} | {moved['opening_ahead_deg']:.2f} | "
                f"{l50_cm(free, species) - l50:+.2f} | {spent:.2f}"
            )


if __name__ == "__main__":
    main()
