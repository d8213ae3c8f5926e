"""Where the time goes in a selectivity study: 100 catches, 5 codends, 3 species, 1000 bootstrap draws.

Solves the codends first, which is not counted, then times every part of the prediction. The fish are the assumed ones
of the example species file, in three sizes of section.

Run as `python -m validation.selectivity_benchmark`.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from time import perf_counter, process_time
from typing import TypeVar

import click
import numpy as np

import codend
from catch_models.fish import Species
from codend.plan.plan import Plan, plan_from_dict
from codend.selectivity.escape.catches import catches_of, run_of
from codend.selectivity.escape.haul import hauls_of, terms_of_catches, terms_of_haul
from codend.selectivity.escape.predict import predict
from codend.selectivity.escape.sensitivity import SAMPLES, sensitivity
from codend.selectivity.escape.species import example_species_path, load_species
from codend.selectivity.escape.tables import retention_table, selectivity_table

T = TypeVar("T")

CODENDS = (("diamond", 100), ("diamond", 75), ("diamond", 50), ("t90", 60), ("t90", 50))
CATCHES = 100


def codend_plan(mesh: str, meshes_round: int, catches: int) -> Plan:
    """A codend of assumed sizes with many catches, from 4 to 30 filled meshes of 40."""
    return plan_from_dict(
        {
            "title": f"{mesh}, {meshes_round} meshes round",
            "tow": {"speed_m_s": 1.6, "water_density_kg_m3": 1026.0},
            "entry": {"radius_m": 0.35},
            "netting": [
                {
                    "mesh": mesh,
                    "meshes_round": meshes_round,
                    "meshes_long": 40,
                    "mesh_mm": 110.0,
                    "knot_mm": 12.0,
                    "twine_mm": 4.0,
                }
            ],
            "catch": {"filled_meshes": np.linspace(4.0, 30.0, catches).tolist()},
            "model": {"contact": False},  # folds of T90 are not what is timed
        }
    )


def three_species() -> list[Species]:
    """The example, and the same with sections a tenth smaller and larger."""
    example = load_species(example_species_path())
    found = []
    for factor in (0.9, 1.0, 1.1):
        height = example.section.height_per_length
        scaled = height.model_copy(update={"value": factor * height.value})
        section = example.section.model_copy(update={"height_per_length": scaled})
        found.append(example.model_copy(update={"name": f"example x {factor:g}", "section": section}))
    return found


@click.command()
@click.option("--catches", default=CATCHES, show_default=True)
@click.option("--draws", default=1000, show_default=True)
def main(catches: int, draws: int) -> None:
    """Print the time of every part."""
    species = three_species()
    spent: dict[str, float] = {}
    used: dict[str, float] = {}

    def timed(name: str, work: Callable[[], T]) -> T:
        start, processor = perf_counter(), process_time()
        result = work()
        spent[name] = spent.get(name, 0.0) + perf_counter() - start
        used[name] = used.get(name, 0.0) + process_time() - processor
        return result

    click.echo(f"{os.cpu_count()} cores; {len(CODENDS)} codends x {catches} catches, {len(species)} species")
    warm = run_of(codend.solve(codend_plan("diamond", 60, 2)))
    predict(warm, species[:1], n_bootstrap=2, samples=2)  # compiles the kernels
    runs = []
    for mesh, meshes_round in CODENDS:
        study = timed(
            "solving the codends, not counted", lambda m=mesh, n=meshes_round: codend.solve(codend_plan(m, n, catches))
        )
        click.echo(f"{study.plan.title}: {sum(case.converged for case in study.cases)} of {catches} catches solved")
        runs.append(run_of(study))

    for run in runs:
        (haul,) = timed("reading meshes from the tables", lambda r=run: hauls_of(catches_of(r, 15.0)))
        for one in species:
            terms = timed("retention of every catch", lambda h=haul, s=one: terms_of_catches(h, s))
            whole = timed("retention over the haul", lambda h=haul, t=terms, s=one: terms_of_haul(h, t, s))
            timed("L50 and SR of every curve", lambda t=(*terms, whole): [x.l50_sr() for x in t])
            timed(
                "curves at the length classes", lambda t=(*terms, whole), s=one: [x.retention(s.length_cm) for x in t]
            )
            timed(f"ranking by variance, {SAMPLES} samples, on top", lambda h=haul, s=one: sensitivity(h, s))
    whole = f"all of the prediction with {draws} bootstrap draws, without the ranking"
    found = [timed(whole, lambda r=run: predict(r, species, n_bootstrap=draws, samples=0)) for run in runs]
    for each in found:
        timed("tables", lambda f=each: (selectivity_table(f), retention_table(f)))
    click.echo(f"{'clock':>8s}  {'processor':>9s}")
    for name, seconds in spent.items():
        click.echo(f"{seconds:8.2f}  {used[name]:9.2f} s  {name}")


if __name__ == "__main__":
    main()
