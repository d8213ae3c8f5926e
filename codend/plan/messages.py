"""From what pydantic says about a plan to one ``InputError``: the key, the value found and what is allowed there."""

from __future__ import annotations

import difflib
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from annotated_types import Ge, Gt, Le, Lt
from pydantic import BaseModel, ValidationError

from codend.errors import InputError


class Contradiction(ValueError):
    """Raised inside a model by a check over several keys; ``key`` is relative to the model that raises it."""

    def __init__(self, key: str, allowed: str, problem: str = "is not allowed") -> None:
        super().__init__(key, allowed, problem)
        self.key = key
        self.allowed = allowed
        self.problem = problem


def input_error(
    error: ValidationError, plan: type[BaseModel], data: Mapping[str, object], file: str | Path
) -> InputError:
    """The first thing wrong with ``data`` as an ``InputError``; unknown keys go first, they explain missing ones."""
    details = error.errors(include_url=False, include_input=False)
    first = next((detail for detail in details if detail["type"] == "extra_forbidden"), details[0])
    location = first["loc"]
    if first["type"] == "extra_forbidden":
        model = _annotation_at(plan, location[:-1])
        value = _value_at(data, location)[1]
        closest = difflib.get_close_matches(str(location[-1]), model.model_fields, n=1)
        hint = f" (did you mean {closest[0]}?)" if closest else ""
        allowed = f"one of {', '.join(model.model_fields)}"
        return InputError(file, _dotted(location), value, allowed, f"is not a known key{hint}")
    if first["type"] == "missing":
        allowed = describe(_annotation_at(plan, location))
        return InputError(file, _dotted(location), None, allowed, "is missing")
    cause = first.get("ctx", {}).get("error")
    if isinstance(cause, Contradiction):
        location = (*location, *cause.key.split("."))
        depth, value = _value_at(data, location)
        return InputError(file, _dotted(location[:depth]), value, cause.allowed, cause.problem)
    depth, value = _value_at(data, location)
    return InputError(file, _dotted(location[:depth]), value, describe(_annotation_at(plan, location[:depth])))


def describe(annotation: Any) -> str:
    """What a type annotation admits, in words: "a number above 0, at most 10, or a list of them"."""
    origin, arguments = get_origin(annotation), get_args(annotation)
    if origin is Annotated:
        return describe(arguments[0]) + _bounds(arguments[1:])
    if origin in (Union, UnionType):
        return " or ".join(describe(argument) for argument in arguments if argument is not NoneType)
    if origin is Literal:
        return ", ".join(f'"{choice}"' for choice in arguments)
    if origin is tuple and _is_model(arguments[0]):
        return f"one or more tables, each with {', '.join(arguments[0].model_fields)}"
    if origin is tuple:
        return f"{describe(arguments[0])}, or a list of them that is not empty"
    if _is_model(annotation):
        return f"a table with {', '.join(annotation.model_fields)}"
    return {float: "a number", int: "a whole number", str: "a text that is not empty"}[annotation]


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
