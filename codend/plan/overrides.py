"""Changes to a plan from the command line: ``netting.0.bar_mm=25`` laid over the TOML data before it is checked."""

import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Literal, get_args

from codend.errors import InputError

CatchKind = Literal["filled_meshes", "volume_m3", "mass_kg", "front_from_codline_m"]
CATCH_QUANTITIES: tuple[CatchKind, ...] = get_args(CatchKind)
"""Keys of which a plan's catch has exactly one."""
MESH_SIZES: tuple[str, ...] = ("bar_mm", "mesh_mm", "inside_mesh_mm")
"""Keys of which each section of netting has exactly one."""
TITRES: tuple[str, ...] = ("rtex", "runnage_m_kg", "twine_number")
"""Keys of which each section of netting has at most one."""
STRAP_LENGTHS: tuple[str, ...] = ("length_m", "circumference_share")
"""Keys of which each strap has exactly one."""
ENTRY_SIZES: tuple[str, ...] = ("radius_m", "hanging_ratio")
"""Keys of which the entry has exactly one."""

_SHAPE = "KEY=VALUE, such as netting.0.bar_mm=25 or tow.speed_m_s=[1.0, 1.5]"


Overrides = Sequence[str] | Mapping[str, Any]
"""Changes to a plan: ``"netting.0.bar_mm=25"`` as texts, or ``{"netting.0.bar_mm": 25}``."""


def apply_overrides(data: Mapping[str, Any], overrides: Overrides, file: str | Path) -> dict[str, Any]:
    """A copy of ``data`` with each ``dotted.key=value`` set, in order; nothing is validated here.

    A value is read as a TOML value; what is not TOML is taken as a bare text, so ``catch.pressure=uniform`` works.
    Tables that are missing are made. Of keys that exclude each other (``CATCH_QUANTITIES``, ``MESH_SIZES``, ...) the
    override takes the place of the one in the file: ``catch.volume_m3=0.1`` drops ``filled_meshes``. Two overrides
    that exclude each other are both kept, so that validation refuses them.

    Raises:
        InputError: an override is not KEY=VALUE, or its key leads into something that is no table or list.
    """
    if isinstance(overrides, Mapping):
        return apply_values(data, [(tuple(key.split(".")), value) for key, value in overrides.items()], file)
    return apply_values(data, [parsed_override(override, file) for override in overrides], file)


def apply_values(
    data: Mapping[str, Any], wanted: Sequence[tuple[tuple[str, ...], Any]], file: str | Path
) -> dict[str, Any]:
    """``apply_overrides`` with keys in their parts and values as they are.

    Raises:
        InputError: a key leads into something that is no table or list.
    """
    changed: dict[str, Any] = _copied(data)
    overridden = {key for key, _ in wanted}
    for key, value in wanted:
        *parents, last = key
        table: Any = changed
        for depth, part in enumerate(parents):
            if isinstance(table, dict):
                table = table.setdefault(part, {})
            else:
                table = table[_position(table, part, key[: depth + 1], file)]
        if isinstance(table, dict):
            table[last] = value
            for rival in _rivals(key):
                if (*parents, rival) not in overridden:
                    table.pop(rival, None)
        else:
            table[_position(table, last, key, file)] = value
    return changed


def _copied(value: Any) -> Any:
    """Tables and lists anew, all the way in; what is in them does not change."""
    if isinstance(value, str | float | int):
        return value
    if isinstance(value, Mapping):
        return {key: _copied(one) for key, one in value.items()}
    return [_copied(one) for one in value] if isinstance(value, list) else value


def parsed_override(override: str, file: str | Path) -> tuple[tuple[str, ...], Any]:
    """Parts of the key, and the value, of a ``dotted.key=value``.

    Raises:
        InputError: it has no key or no "=".
    """
    dotted, equals, text = override.partition("=")
    key = tuple(part.strip() for part in dotted.split("."))
    if not equals or not all(key):
        raise InputError(file, override, None, _SHAPE, "is not a change to a plan")
    return key, _toml_value(text.strip())


def _toml_value(text: str) -> Any:
    try:
        document = tomllib.loads(f"value = {text}")
    except (ValueError, RecursionError):
        return text
    return document["value"] if document.keys() == {"value"} else text


def _position(container: Any, part: str, key: Sequence[str], file: str | Path) -> int:
    """Index of ``part`` in a list, refusing what is no list and what lies outside it."""
    dotted = ".".join(key)
    if not isinstance(container, list):
        raise InputError(file, dotted, None, f"{'.'.join(key[:-1])} itself, which holds one value", "does not exist")
    if not (part.isascii() and part.isdecimal() and len(part) < 10 and int(part) < len(container)):
        raise InputError(file, dotted, None, f"a position from 0 to {len(container) - 1}", "does not exist")
    return int(part)


def _rivals(key: Sequence[str]) -> tuple[str, ...]:
    groups: dict[str, tuple[tuple[str, ...], ...]] = {
        "catch": (CATCH_QUANTITIES,),
        "netting": (MESH_SIZES, TITRES),
        "window": (MESH_SIZES, TITRES),
        "entry": (ENTRY_SIZES,),
        "strap": (STRAP_LENGTHS,),
    }
    return tuple(name for group in groups.get(key[0], ()) if key[-1] in group for name in group if name != key[-1])
