"""Species files: TOML to ``catch_models.fish.Species``, every error on one line with the key and what is allowed."""

from __future__ import annotations

import json
from importlib.resources import files
from pathlib import Path

import numpy as np

from catch_models.fish import PARAMETERS, Species
from codend.errors import InputError
from codend.io.toml import read_toml
from codend.plan.mistakes import checked

SHIPPED_SPECIES = ("example", "red-mullet")
"""The first is of no fish, all of its numbers assumed; of the others the section was measured."""
MOST_LENGTH_CLASSES = 10_000
"""Far more than any ruler tells apart; retention is computed for each, and a step of a micrometre fills any memory."""


def shipped_species_path(name: str) -> Path:
    """A species file of ``SHIPPED_SPECIES``."""
    return Path(str(files("catch_models") / "data" / f"species_{name.replace('-', '_')}.toml"))


def example_species_path() -> Path:
    """The documented example of a species file, all of its numbers assumed."""
    return shipped_species_path("example")


def load_species(path: str | Path) -> Species:
    """Read and check a species file.

    Raises:
        InputError: no such file, not TOML, an unknown, missing, mistyped or out-of-range key, a number outside its own
            range, a range of a zone's number, an exponent for an ellipse or none for a superellipse, length classes
            that run backwards or are too many, a distribution along the codend that begins farther than a row ahead.
    """
    data = read_toml(path, "species file in TOML")
    species = checked(Species, data, path)
    _check(species, path)
    return species


def species_toml(species: Species) -> str:
    """A species as TOML that ``load_species`` reads back to an equal one."""
    lines = ['# Every number with its source; one that begins with "assumed" marks a number nobody measured.', ""]
    tables = species.model_dump(exclude_none=True)
    lines += [f"{key} = {_text(value)}" for key, value in tables.items() if isinstance(value, str)]
    for name, table in tables.items():
        headed = [(f"[[{name}]]", one) for one in table] if isinstance(table, tuple) else [(f"[{name}]", table)]
        for head, one in headed:
            if isinstance(one, dict):
                lines += ["", head, *(f"{key} = {_entry(value)}" for key, value in one.items())]
    return "\n".join(lines) + "\n"


def _entry(value: object) -> str:
    if isinstance(value, str):
        return _text(value)
    if isinstance(value, tuple):
        return f"[{', '.join(map(repr, value))}]"
    if not isinstance(value, dict):
        return repr(value)
    return f"{{ {', '.join(f'{key} = {_entry(part)}' for key, part in value.items())} }}"


def _text(value: str) -> str:
    """Spelled as in JSON, but that TOML takes no DEL as it is."""
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")


def _check(species: Species, path: str | Path) -> None:
    """What several keys must fulfil together."""
    if species.shape == "superellipse" and species.section.exponent is None:
        raise InputError(path, "section.exponent", None, "a table with value and source", "is missing")
    if species.shape == "ellipse" and species.section.exponent is not None:
        raise InputError(path, "section.exponent", species.section.exponent.value, 'only with shape = "superellipse"')
    if species.lengths.to_cm <= species.lengths.from_cm:
        raise InputError(path, "lengths.to_cm", species.lengths.to_cm, f"above {species.lengths.from_cm:g}, from_cm")
    for place, zone in enumerate(species.zone):
        for key, of_zone in (("contact", zone.contact), ("attempts", zone.attempts)):
            for end in ("low", "high"):
                if (given := getattr(of_zone, end)) is not None:
                    raise InputError(
                        path, f"zone.{place}.{key}.{end}", given, "left out: numbers of zones are not ranked"
                    )
    along = species.along
    if along is not None and not along.rows_ahead[0] <= 1.0:
        allowed = "a first row of 0 to 1: what fish do nearer to the front must be said"
        raise InputError(path, "along.rows_ahead", list(along.rows_ahead), allowed)
    if along is not None and (np.diff(along.rows_ahead) <= 0.0).any():
        raise InputError(path, "along.rows_ahead", list(along.rows_ahead), "rows in rising order")
    if along is not None and (len(along.weight) != len(along.rows_ahead) or max(along.weight) == 0.0):
        allowed = f"{len(along.rows_ahead)} weights, one for each of rows_ahead, of which one is above 0"
        raise InputError(path, "along.weight", list(along.weight), allowed)
    step_cm = species.lengths.step_cm
    if species.lengths.to_cm - species.lengths.from_cm >= MOST_LENGTH_CLASSES * step_cm:
        allowed = f"so long that there are at most {MOST_LENGTH_CLASSES} length classes"
        raise InputError(path, "lengths.step_cm", step_cm, allowed)
    for name in PARAMETERS:
        number = species.number(name)
        if number is None or (number.low is None and number.high is None):
            continue
        if number.low is None or number.high is None:
            missing = "low" if number.low is None else "high"
            raise InputError(path, f"{name}.{missing}", None, "low and high together, or neither", "is missing")
        if not number.low <= number.value <= number.high:
            bounds = f"from {number.low:g} to {number.high:g}, its own low and high"
            raise InputError(path, f"{name}.value", number.value, bounds)
