"""From what pydantic says about a plan to ``InputError``s: the key, the value found and what is allowed there."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from types import NoneType, UnionType
from typing import Annotated, Any, Final, Literal, Union, get_args, get_origin

from annotated_types import Ge, Gt, Le, Lt
from pydantic import BaseModel, TypeAdapter, ValidationError

from codend.errors import InputError

MEANT: Final = {"t0": "diamond", "rhombic": "diamond", "t45": "square"}
"""Words of the trade for what plans call otherwise: netting unturned, turned by 45 degrees."""


class Contradiction(ValueError):
    """Raised inside a model by a check over several keys; ``key`` is relative to the model that raises it."""

    def __init__(self, key: str, allowed: str, problem: str = "is not allowed") -> None:
        super().__init__(key, allowed, problem)
        self.key = key
        self.allowed = allowed
        self.problem = problem
        self.others: tuple[Contradiction, ...] = ()

    @staticmethod
    def raise_first(found: Iterable[Contradiction]) -> None:
        """Raise the first contradiction, with the others beside it, if there is one."""
        if all_of_them := list(found):
            all_of_them[0].others = tuple(all_of_them[1:])
            raise all_of_them[0]


def input_errors(
    detail: Mapping[str, Any], plan: type[BaseModel], data: Mapping[str, object], file: str | Path
) -> list[InputError]:
    """One detail of what pydantic found wrong with ``data``; several where a check over several keys found more."""
    location = detail["loc"]
    if detail["type"] == "extra_forbidden":
        model = _annotation_at(plan, location[:-1])
        value = _value_at(data, location)[1]
        allowed = f"one of {', '.join(model.model_fields)}"
        problem = f"is not a known key{_key_hint(plan, location)}"
        return [InputError(file, _dotted(location), value, allowed, problem)]
    if detail["type"] == "missing":
        allowed = describe(_annotation_at(plan, location))
        return [InputError(file, _dotted(location), None, allowed, "is missing")]
    cause = detail.get("ctx", {}).get("error")
    if isinstance(cause, Contradiction):
        found = []
        for one in (cause, *cause.others):
            there = (*location, *one.key.split("."))
            depth, value = _value_at(data, there)
            found.append(InputError(file, _dotted(there[:depth]), value, one.allowed, one.problem))
        return found
    depth, value = _value_at(data, location)
    allowed = describe(_annotation_at(plan, location[:depth]))
    meant = meant_value(plan, location, value)
    problem = "is not allowed" + (f' (did you mean "{meant}"?)' if meant else "")
    return [InputError(file, _dotted(location[:depth]), value, allowed, problem)]


def mistake_at(
    plan: type[BaseModel], location: Sequence[str | int], value: object, file: str | Path, shown: str
) -> InputError | None:
    """What is wrong with a value at a place of a plan, whatever else the plan says; None where nothing is.

    Args:
        plan: the model of the whole plan.
        location: parts of the key, positions as numbers.
        value: to stand there.
        file: that gives the value, for messages.
        shown: the key under which it gives it.
    """
    annotation: Any = plan
    for depth, part in enumerate(location):
        if not _is_model(annotation):
            return None  # a value of a list, which the plan's own checks take in
        if part not in annotation.model_fields:
            allowed = f"one of {', '.join(annotation.model_fields)}"
            hint = _key_hint(plan, location[: depth + 1])
            return InputError(file, shown, None, allowed, f"is not a known key of a plan{hint}")
        annotation = _annotation_at(annotation, [part])
        following = location[depth + 1 : depth + 2]
        if following and isinstance(following[0], int):
            annotation = _annotation_at(annotation, following)
            return mistake_at(annotation, location[depth + 2 :], value, file, shown) if _is_model(annotation) else None
    if _is_model(annotation):
        return InputError(file, shown, None, "the key of a value in it", "is a whole table")
    try:
        TypeAdapter(annotation).validate_python(value)
    except ValidationError:
        meant = meant_value(plan, location, value)
        problem = "is not allowed" + (f' (did you mean "{meant}"?)' if meant else "")
        return InputError(file, shown, value, describe(annotation), problem)
    return None


def is_counted(plan: type[BaseModel], location: Sequence[str | int]) -> bool:
    """Whether a plan has whole numbers at a place."""
    return describe(_annotation_at(plan, location)).startswith("a whole number")


def meant_key(plan: type[BaseModel], location: Sequence[str | int]) -> str | None:
    """The key of the same table that is spelt most like an unknown one; None if none is."""
    fields = _annotation_at(plan, location[:-1]).model_fields
    return next(iter(difflib.get_close_matches(str(location[-1]).lower(), fields, n=1)), None)


def meant_value(plan: type[BaseModel], location: Sequence[str | int], value: object) -> str | None:
    """The word that is allowed at a place and is spelt most like, or means, the one that stands there."""
    if not isinstance(value, str):
        return None
    choices, word = _choices(_annotation_at(plan, location)), value.strip().lower()
    if (meant := MEANT.get(word)) in choices:
        return meant
    return next(iter(difflib.get_close_matches(word, choices, n=1)), None)


def _choices(annotation: Any) -> list[str]:
    """Words that an annotation allows; none where it allows other things."""
    origin, arguments = get_origin(annotation), get_args(annotation)
    if origin is Literal:
        return [choice for choice in arguments if isinstance(choice, str)]
    if origin is Annotated:
        return _choices(arguments[0])
    return [word for part in arguments for word in _choices(part)] if origin in (Union, UnionType) else []


def _key_hint(plan: type[BaseModel], location: Sequence[str | int]) -> str:
    if meant := meant_key(plan, location):
        return f" (did you mean {meant}?)"
    fields = {name: field.annotation for name, field in plan.model_fields.items()}
    tables = {name: get_args(found)[0] if get_origin(found) is tuple else found for name, found in fields.items()}
    homes = [name for name, found in tables.items() if location[-1] in getattr(found, "model_fields", ())]
    return f" (it is one of {' and of '.join(homes)})" if homes else ""


def describe(annotation: Any) -> str:
    """What a type annotation admits, in words: "a number above 0, at most 10, or a list of them"."""
    origin, arguments = get_origin(annotation), get_args(annotation)
    if origin is Annotated:
        return describe(arguments[0]) + _bounds(arguments[1:])
    if origin in (Union, UnionType):
        return " or ".join(describe(argument) for argument in arguments if argument is not NoneType)
    if origin is Literal:
        return ", ".join(f'"{choice}"' if isinstance(choice, str) else str(choice) for choice in arguments)
    if origin is tuple and _is_model(arguments[0]):
        return f"one or more tables, each with {', '.join(arguments[0].model_fields)}"
    if origin is tuple and arguments[-1] is not Ellipsis:
        return f"a list of {len(arguments)}, each {describe(arguments[0])}"
    if origin is tuple:
        return f"{describe(arguments[0])}, or a list of them that is not empty"
    if _is_model(annotation):
        return f"a table with {', '.join(annotation.model_fields)}"
    words = {float: "a number", int: "a whole number", bool: "true or false", str: "a text that is not empty"}
    return words[annotation]


def _bounds(metadata: Sequence[Any]) -> str:
    words = []
    for item in metadata:
        match item:
            case Gt(gt=bound):
                words.append(f"above {bound:g}")
            case Ge(ge=bound):
                words.append(f"at least {bound:g}")
            case Lt(lt=bound):
                words.append(f"below {bound:g}")
            case Le(le=bound):
                words.append(f"at most {bound:g}")
    return " " + ", ".join(words) if words else ""


def _is_model(annotation: Any) -> bool:
    return isinstance(annotation, type) and issubclass(annotation, BaseModel)


def _annotation_at(annotation: Any, location: Sequence[str | int]) -> Any:
    """The annotation, with its bounds, at a location below a model."""
    for part in location:
        if get_origin(annotation) in (Union, UnionType) and isinstance(part, str):
            # a table that may be left out
            annotation = next((one for one in get_args(annotation) if _is_model(one)), annotation)
        if _is_model(annotation):
            field = annotation.model_fields[str(part)]
            annotation = Annotated[field.annotation, *field.metadata] if field.metadata else field.annotation
        else:
            while get_origin(annotation) is Annotated:
                annotation = get_args(annotation)[0]
            annotation = get_args(annotation)[0]  # one item of a tuple
    while get_origin(annotation) is Annotated and _is_model(get_args(annotation)[0]):
        annotation = get_args(annotation)[0]
    return annotation


def _value_at(data: object, location: Sequence[str | int]) -> tuple[int, Any]:
    """How deep ``location`` goes in ``data`` (a single number stands for a list of one) and the value found there."""
    value: Any = data
    for depth, part in enumerate(location):
        if isinstance(value, Mapping) and isinstance(part, str):
            if part not in value:
                return depth + 1, None
            value = value[part]
        elif isinstance(value, list | tuple):
            value = value[int(part)]
        else:
            return depth, value
    return len(location), value


def _dotted(location: Sequence[str | int]) -> str:
    return ".".join(str(part) for part in location)
