"""Designs beside each other: what differs in their plans, and their answers at the same catches."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
import pandas as pd

from codend.errors import OPTIONS, InputError
from codend.io.columns import error_of
from codend.io.run_tables import read_run_table
from codend.plan.copy import toml_value
from codend.plan.plan import load_plan

QUANTITIES: Final = ("opening_ahead_deg", "drag_n")
"""Of a run."""
SELECTIVITY: Final = {"l50_cm": "l50", "sr_cm": "sr"}
"""Of ``selectivity.csv``, and how the columns of their intervals begin."""
PLACE: Final = ["speed_m_s", "catch_mass_kg"]
CLOSE: Final = 1e-6
"""Relative difference of catches up to which they are the same."""


@dataclass(frozen=True)
class BesideEachOther:
    """Designs compared; the first is the one that the others are held to."""

    names: tuple[str, ...]
    plans: pd.DataFrame
    """A row a key in which plans differ, a column a design; empty cells where a plan has no such key."""
    values: pd.DataFrame
    """``design, speed_m_s, catch_mass_kg, filled_meshes, species, quantity, value, half_width``."""
    differences: pd.DataFrame
    """``design, against, speed_m_s, catch_mass_kg, species, quantity, difference, lower, upper, interpolated``."""
    left_out: tuple[str, ...] = ()
    """What of the first could not be compared, a sentence a design."""


def beside_each_other(folders: Sequence[Path]) -> BesideEachOther:
    """Compare the runs in some folders.

    Answers of a design are taken at the catch masses of the first one at the same speed, between its own catches in
    proportion and never beyond them. Intervals of opening and drag reach as far as both error estimates together. L50
    and SR are of logit curves fitted to fish that meet a catch, and their intervals as wide as both 95 % intervals of
    those fits, for a finite number of fish and the error of the openings, taken as independent.

    Raises:
        InputError: a folder is named twice or holds no run, or no catch of the first can be compared at all.
    """
    names = _names(folders)
    plans = _plan_differences(names, folders)
    values = pd.concat([_values(name, folder) for name, folder in zip(names, folders, strict=True)], ignore_index=True)
    first = values[values["design"] == names[0]]
    parts = [_differences(first, values[values["design"] == name]) for name in names[1:]]
    left_out = []
    for name, folder, part in zip(names[1:], folders[1:], parts, strict=True):
        places, compared = (len(table[PLACE].drop_duplicates()) for table in (first, part))
        if compared == 0:
            allowed = f"a speed of {names[0]}, and catches that hold one of its"
            raise InputError(folder / "results.csv", "", None, allowed, "has no catch to compare")
        if compared < places:
            left_out.append(
                f"{name}: {places - compared} of {places} catches of {names[0]} are left out: it has none at their "
                "speed, or they lie beyond its catches."
            )
    return BesideEachOther(names, plans, values, pd.concat(parts, ignore_index=True), tuple(left_out))


def _names(folders: Sequence[Path]) -> tuple[str, ...]:
    """Names of the folders, with as many of those above them as tell them apart."""
    resolved = [folder.resolve() for folder in folders]
    for number, folder in enumerate(resolved):
        if folder in resolved[:number]:
            raise InputError(OPTIONS, "DIR", str(folders[number]), "each folder once", "is named twice")
    for depth in range(1, max(len(folder.parts) for folder in resolved) + 1):
        names = ["/".join(folder.parts[-depth:]) for folder in resolved]
        if len(set(names)) == len(names):
            break
    return tuple(names)


def _plan_differences(names: Sequence[str], folders: Sequence[Path]) -> pd.DataFrame:
    plans = [_flat(load_plan(folder / "plan.toml").to_dict()) for folder in folders]
    keys = dict.fromkeys(key for plan in plans for key in plan)
    differing = [key for key in keys if len({plan.get(key) for plan in plans}) > 1]
    columns = {name: [plan.get(key, "") for key in differing] for name, plan in zip(names, plans, strict=True)}
    return pd.DataFrame({"key": differing, **columns})


def _flat(table: Any, ahead: str = "") -> dict[str, str]:
    """Every value of a plan as text, by its key with all its parts."""
    if isinstance(table, dict):
        return {key: text for name, value in table.items() for key, text in _flat(value, f"{ahead}{name}.").items()}
    if isinstance(table, list) and table and isinstance(table[0], dict):
        return {key: text for i, value in enumerate(table) for key, text in _flat(value, f"{ahead}{i}.").items()}
    return {ahead[:-1]: toml_value(table)}


def _values(name: str, folder: Path) -> pd.DataFrame:
    results = read_run_table(folder / "results.csv")
    solved = results[results["converged"].astype(bool)]
    if solved.empty:
        raise InputError(folder / "results.csv", "converged", None, "a run with a solved case", "holds none")
    columns = ["case", *PLACE, "filled_meshes"]
    parts = [
        solved[columns].assign(species="", quantity=name, value=solved[name], half_width=solved[error_of(name)])
        for name in QUANTITIES
    ]
    selected = folder / "selectivity.csv"
    if selected.is_file():
        parts += _selectivity(selected, solved[columns])
    return pd.concat(parts, ignore_index=True).drop(columns="case").assign(design=name)


def _selectivity(path: Path, cases: pd.DataFrame) -> list[pd.DataFrame]:
    try:
        table = pd.read_csv(path, dtype={"case": str, "species": str})
        table = table[table["case"] != "haul"].assign(case=lambda rows: pd.to_numeric(rows["case"]))
        joined = cases.merge(table.drop(columns=["speed_m_s"]), on="case")
        return [
            joined[[*cases.columns, "species"]].assign(
                quantity=quantity,
                value=joined[f"{of}_logit_cm"],
                half_width=0.5 * (joined[f"{of}_upper_95_cm"] - joined[f"{of}_lower_95_cm"]),
            )
            for quantity, of in SELECTIVITY.items()
        ]
    except (ValueError, KeyError):
        allowed = "a table as codend selectivity writes it: run that again"
        raise InputError(path, "", None, allowed, "cannot be used") from None


def _differences(first: pd.DataFrame, other: pd.DataFrame) -> pd.DataFrame:
    """Other less first, at the catches of the first that lie between those of the other."""
    rows = []
    keys = ["species", "quantity", "speed_m_s"]
    curves = {key: curve.sort_values("catch_mass_kg") for key, curve in other.groupby(keys)}
    for key, points in first.groupby(keys, sort=False):
        curve = curves.get(key)
        if curve is None:
            continue
        mass = curve["catch_mass_kg"].to_numpy(dtype=float)
        for point in points.to_dict("records"):
            wanted, slack = point["catch_mass_kg"], CLOSE * point["catch_mass_kg"]
            if not mass[0] - slack <= wanted <= mass[-1] + slack:
                continue
            value, half = (float(np.interp(wanted, mass, curve[name])) for name in ("value", "half_width"))
            own = point["half_width"]
            # estimates of errors may all lie to one side; samples of fish do not
            width = own + half if point["quantity"] in QUANTITIES else float(np.hypot(own, half))
            difference = value - point["value"]
            rows.append(
                {
                    "design": other["design"].iloc[0],
                    "against": point["design"],
                    "speed_m_s": point["speed_m_s"],
                    "catch_mass_kg": wanted,
                    "species": point["species"],
                    "quantity": point["quantity"],
                    "difference": difference,
                    "lower": difference - width,
                    "upper": difference + width,
                    "interpolated": bool(np.abs(mass - wanted).min() > slack),
                }
            )
    return pd.DataFrame(rows, columns=DIFFERENCE_COLUMNS)


DIFFERENCE_COLUMNS: Final = [
    "design",
    "against",
    *PLACE,
    "species",
    "quantity",
    "difference",
    "lower",
    "upper",
    "interpolated",
]
