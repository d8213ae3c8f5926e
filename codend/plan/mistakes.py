"""All mistakes of a plan or species file at once, in one ``InputError``.

What is wrong in one place must not hide what is wrong in another. So keys and values that are misspelt for sure are
mended in a copy, wrong values that other checks do not ask for give way to good ones, and the copy is checked again:
whatever it then lacks was wrong from the start.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from copy import deepcopy
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from codend.errors import InputError, all_at_once
from codend.plan.messages import input_errors, meant_key, meant_value

M = TypeVar("M", bound=BaseModel)


def checked(model: type[M], data: Mapping[str, Any], file: str | Path, stand_ins: Mapping[str, Any] | None = None) -> M:
    """Tables as ``tomllib`` returns them as a model of them.

    Args:
        model: of the whole file.
        data: its tables.
        file: where they are from, for messages.
        stand_ins: good values by their keys, positions left out, that have no say in checks over several tables; None
            for keys that may be left out.

    Raises:
        InputError: the first mistake, with all others beside it.
    """
    try:
        return model.model_validate(data)
    except ValidationError as error:
        first = error
    found: dict[str, InputError] = {}
    renamed: set[str] = set()
    mended = deepcopy(dict(data))
    for detail in first.errors(include_url=False, include_input=False):
        if _mend(mended, detail, model, renamed):
            found.update((one.key, one) for one in input_errors(detail, model, data, file))
    wrong = _add_errors(found, model, mended, file, renamed)
    if all([_replace(mended, key.split("."), stand_ins or {}) for key in wrong]):
        _add_errors(found, model, mended, file, renamed)
    raise all_at_once(list(found.values())) from None


def _add_errors(
    found: dict[str, InputError],
    model: type[BaseModel],
    data: Mapping[str, Any],
    file: str | Path,
    told: Collection[str],
) -> list[str]:
    """Add mistakes at keys that have none yet, nor within them; the keys at which there are any.

    Those at ``told`` have been told of under another name.
    """
    try:
        model.model_validate(data)
    except ValidationError as error:
        details = error.errors(include_url=False, include_input=False)
        wrong = [one for detail in details for one in input_errors(detail, model, data, file)]
        for one in wrong:
            if one.key not in told and not any(key.startswith(f"{one.key}.") for key in found):
                found.setdefault(one.key, one)
        return [one.key for one in wrong]
    return []


def _replace(data: Any, key: Sequence[str], stand_ins: Mapping[str, Any]) -> bool:
    """Put a stand-in at a key, or at the table it lies in; whether there is one."""
    names: list[str] = []
    for part in key:
        names += [] if part.isdecimal() else [part]
        if isinstance(data, dict) and (name := ".".join(names)) in stand_ins:
            data.pop(part, None)
            if stand_ins[name] is not None:
                data[part] = stand_ins[name]
            return True
        try:
            data = data[int(part)] if isinstance(data, list) else data[part]
        except (LookupError, TypeError, ValueError):
            return False
    return False


def _mend(data: dict[str, Any], detail: Any, model: type[BaseModel], renamed: set[str]) -> bool:
    """Take an unknown key out, or give it or a word the spelling that was meant; whether there was anything to do.

    New names of keys are added to ``renamed``.
    """
    *parents, last = detail["loc"] or ("",)
    table: Any = data
    for part in parents:
        table = table[part] if isinstance(table, dict) or (isinstance(table, list) and isinstance(part, int)) else None
    if not isinstance(table, dict) or last not in table:
        return False
    if detail["type"] == "extra_forbidden":
        value, meant = table.pop(last), meant_key(model, detail["loc"])
        if meant and meant not in table:
            table[meant] = value
            renamed.add(".".join(map(str, (*parents, meant))))
        return True
    meant = meant_value(model, detail["loc"], table[last])
    if meant:
        table[last] = meant
    return bool(meant)
