"""All mistakes of a plan or species file at once, in one ``InputError``.

What is wrong in one place must not hide what is wrong in another. So keys and values that are misspelt for sure are
mended in a copy, tables that are wrong in themselves give way to good ones, and the copy is checked again: whatever it
then lacks was wrong from the start.
"""

from __future__ import annotations

from collections.abc import Mapping
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
        stand_ins: good tables, by name, of which checks over several tables hold whatever they say.

    Raises:
        InputError: the first mistake, with all others beside it.
    """
    try:
        return model.model_validate(data)
    except ValidationError as error:
        first = error
    found: dict[str, InputError] = {}
    mended = deepcopy(dict(data))
    for detail in first.errors(include_url=False, include_input=False):
        if _mend(mended, detail, model):
            found.update((one.key, one) for one in input_errors(detail, model, data, file))
    wrong = _add_errors(found, model, mended, file)
    if wrong and stand_ins is not None and wrong <= stand_ins.keys():
        mended |= {name: stand_ins[name] for name in wrong}
        _add_errors(found, model, mended, file)
    raise all_at_once(list(found.values())) from None


def _add_errors(
    found: dict[str, InputError], model: type[BaseModel], data: Mapping[str, Any], file: str | Path
) -> set[str]:
    """Add mistakes at keys that have none yet; the tables and keys at the top that are wrong in themselves."""
    try:
        model.model_validate(data)
    except ValidationError as error:
        details = error.errors(include_url=False, include_input=False)
        for detail in details:
            for one in input_errors(detail, model, data, file):
                found.setdefault(one.key, one)
        return {str(detail["loc"][0]) for detail in details if detail["loc"]}
    return set()


def _mend(data: dict[str, Any], detail: Any, model: type[BaseModel]) -> bool:
    """Take an unknown key out, or give it or a word the spelling that was meant; whether there was anything to do."""
    *parents, last = detail["loc"] or ("",)
    table: Any = data
    for part in parents:
        table = table[part] if isinstance(table, dict) or (isinstance(table, list) and isinstance(part, int)) else None
    if not isinstance(table, dict) or last not in table:
        return False
    if detail["type"] == "extra_forbidden":
        value, meant = table.pop(last), meant_key(model, detail["loc"])
        if meant:
            table.setdefault(meant, value)
        return True
    meant = meant_value(model, detail["loc"], table[last])
    if meant:
        table[last] = meant
    return bool(meant)
