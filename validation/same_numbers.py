"""Whether a change moved any number: ``python -m validation.same_numbers --write FILE``, later ``--against FILE``.

Solves every plan of ``validation/cases``, 200 seeded random plans of all kinds of netting, methods and models, and the
selectivity example, and writes every number of their tables but the times, to the last bit. Against an older file it
prints, a column, the largest relative difference and where it is, and exits with 1 where that is above ``--within``.
"""

import sys
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

import click
import numpy as np
import pandas as pd
from click.testing import CliRunner

from codend import InputError, Plan, load_plan, solve
from codend.cli.main import main as codend_command
from codend.plan.plan import plan_from_dict

CASES = Path(__file__).parent / "cases"
NOT_NUMBERS_OF_A_NET = ("solve_ms",)


def random_plan(seed: int, number: int) -> Plan:
    """A small plan drawn from all that a plan can say: kinds, joins, straps, twine, catches, models and methods."""
    rng = np.random.default_rng([seed, number])
    mesh = str(rng.choice(["diamond", "t90", "square"]))
    meshes_round = int(rng.choice([12, 20, 24, 30, 40, 60]))
    meshes_long = int(rng.choice([12, 16, 24, 36]))
    bar_mm = float(rng.uniform(15.0, 60.0))
    knot_mm = 0.0 if mesh == "square" else float(rng.choice([0.0, rng.uniform(0.02, 0.2)])) * bar_mm
    netting: dict[str, object] = {
        "mesh": mesh,
        "meshes_round": meshes_round,
        "meshes_long": meshes_long,
        "bar_mm": bar_mm,
        "knot_mm": knot_mm,
        "twine_mm": float(rng.uniform(0.02, 0.1)) * bar_mm,
    }
    if rng.random() < 0.5:
        netting["axial_stiffness_n"] = float(np.exp(rng.uniform(np.log(500.0), np.log(1e5))))
    if rng.random() < 0.3 and mesh != "square":
        netting["bending_stiffness_n_m2"] = float(np.exp(rng.uniform(np.log(1e-6), np.log(1e-3))))
        netting["rest_opening_deg"] = float(rng.uniform(10.0, 40.0))
    if rng.random() < 0.2:
        netting["twine_density_kg_m3"] = float(rng.choice([950.0, 1140.0, 1380.0]))
    sections = [netting]
    if rng.random() < 0.2:
        sections.append({**netting, "meshes_round": meshes_round // int(rng.choice([1, 2, 3])), "meshes_long": 12})
    across_mm = {"diamond": bar_mm, "t90": bar_mm + knot_mm, "square": 0.5 * bar_mm}[mesh]
    half_perimeter_m = meshes_round * across_mm / 1000.0
    filled_share = float(rng.uniform(0.1, 0.8))
    tables: dict[str, object] = {
        "title": f"random {number}",
        "tow": {"speed_m_s": float(rng.uniform(0.3, 2.0)), "water_density_kg_m3": 1026.0},
        "entry": {"radius_m": float(rng.uniform(0.2, 0.6)) * half_perimeter_m / np.pi},
        "netting": sections,
        "catch": {
            "filled_meshes": filled_share * sum(int(str(s["meshes_long"])) for s in sections),
            "pressure": str(rng.choice(["sphere", "uniform"])),
        },
        "drag": {"law": str(rng.choice(["le-bris-1999", "bessonneau-1997"]))},
    }
    if rng.random() < 0.2:
        tables["strap"] = [{"meshes_from_codline": 4, "length_m": 1.2 * half_perimeter_m, "diameter_mm": 10.0}]
    fidelity = str(rng.choice(["auto", "sector", "full", "globalised", "meridian"], p=[0.25, 0.4, 0.15, 0.1, 0.1]))
    model: dict[str, object] = {"fidelity": fidelity, "tolerance": 1e-8}
    if fidelity == "globalised":
        model["globalisation"] = 2
    if fidelity == "sector":
        model["method"] = str(rng.choice(["auto", "newton", "dynamic-relaxation"], p=[0.7, 0.2, 0.1]))
    return plan_from_dict({**tables, "model": model})


def numbers(plans: int) -> Iterator[tuple[str, pd.DataFrame]]:
    """Name and table of everything that is solved; a plan that is refused has a table of one sentence."""
    for path in sorted(CASES.glob("*.toml")):
        study = solve(load_plan(path))
        yield path.stem, study.table
        yield f"{path.stem} profile", study.profile
    for number in range(plans):
        try:
            table = solve(random_plan(0, number)).table
        except InputError as error:
            table = pd.DataFrame({"refused": [str(error)]})
        yield f"random {number}", table
    yield from selectivity_example()


def selectivity_example() -> Iterator[tuple[str, pd.DataFrame]]:
    """The tables of ``codend selectivity`` for a small codend and the example species."""
    with TemporaryDirectory() as folder:
        species = Path(folder, "species.toml")
        species.write_text(_said("species"), encoding="utf-8")
        _said("run", str(CASES / "commercial_100mm_double.toml"), "--out", folder)
        _said("selectivity", folder, "--species", str(species))
        for name in ("selectivity", "retention"):
            yield name, pd.read_csv(Path(folder, f"{name}.csv"))


def _said(*arguments: str) -> str:
    """What a command of codend prints."""
    return CliRunner().invoke(codend_command, arguments, catch_exceptions=False).stdout


def long_table(plans: int) -> pd.DataFrame:
    """Every value as text that gives the same bits back: ``solved, line, column, value``."""
    parts = []
    for name, table in numbers(plans):
        kept = table.drop(columns=[c for c in NOT_NUMBERS_OF_A_NET if c in table])
        text = kept.map(lambda value: repr(float(value)) if isinstance(value, float | np.floating) else str(value))
        long = text.reset_index(names="line").melt(id_vars="line", var_name="column", value_name="value")
        parts.append(long.assign(solved=name))
    return pd.concat(parts, ignore_index=True)[["solved", "line", "column", "value"]]


def differences(old: pd.DataFrame, new: pd.DataFrame) -> pd.DataFrame:
    """Values that differ, of what stands in both tables, with their relative difference (inf for words)."""
    both = old.astype(str).merge(new.astype(str), on=["solved", "line", "column"], suffixes=("_old", "_new"))
    moved = both[both.value_old != both.value_new].copy()
    first, second = (pd.to_numeric(moved[side], errors="coerce") for side in ("value_old", "value_new"))
    moved["relative"] = ((second - first).abs() / np.maximum(first.abs(), second.abs())).fillna(np.inf)
    return moved


@click.command()
@click.option("--write", type=click.Path(path_type=Path), help="Write the numbers as they are now.")
@click.option("--against", type=click.Path(path_type=Path, exists=True), help="Compare with numbers written before.")
@click.option("--plans", default=200, show_default=True)
@click.option("--within", default=0.0, show_default=True, help="Largest relative difference that is none.")
def main(write: Path | None, against: Path | None, plans: int, within: float) -> None:
    """Write all numbers, or compare them with older ones."""
    now = long_table(plans)
    if write is not None:
        now.to_csv(write, index=False)
    if against is None:
        return
    moved = differences(pd.read_csv(against, dtype=str, keep_default_na=False), now)
    moved = moved[moved.relative > within]
    print(f"{len(now)} values, {len(moved)} moved by more than {within:g}")
    for column, rows in moved.groupby("column"):
        worst = rows.loc[rows.relative.idxmax()]
        print(
            f"  {column}: {len(rows)} moved, most {worst.relative:.2e} in {worst.solved}, line {worst.line}:"
            f" {worst.value_old} -> {worst.value_new}"
        )
    sys.exit(bool(len(moved)))


if __name__ == "__main__":
    main()
