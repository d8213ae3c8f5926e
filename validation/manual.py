"""Writes the pages of the manual that follow from the program itself: every key, every column, every command.

``python -m validation.manual`` writes them into ``codend/guide``; a test holds what stands there to what this makes.
"""

import ast
import inspect
import textwrap
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from importlib import resources
from pathlib import Path
from typing import Any

import click
from pydantic import BaseModel

from catch_models.fish import Species
from codend.cli.main import main as commands
from codend.plan.plan import Plan
from codend.scenes.scene import Scene

GUIDE = Path(str(resources.files("codend.guide")))
UNITS = {
    "kg_m3": "kg/m3",
    "n_m2": "N m2",
    "m_kg": "m/kg",
    "kg_m": "kg/m",
    "m_s": "m/s",
    "deg": "degrees",
    "mm": "mm",
    "cm": "cm",
    "m3": "m3",
    "m2": "m2",
    "kg": "kg",
    "pa": "Pa",
    "ms": "ms",
    "m": "m",
    "n": "N",
    "s": "s",
}
"""Ends of names, the longer first, and the units they stand for."""
NO_UNIT = ("share_", "shares_")
MADE = "<!-- made by `python -m validation.manual`: change what it is made from -->\n\n"


def unit(name: str) -> str:
    """Unit that a key's or column's name ends in, empty where it has none."""
    for end, words in UNITS.items():
        if name.endswith(f"_{end}") and not name.startswith(NO_UNIT):
            return words
    return ""


def documented(table: type[BaseModel]) -> dict[str, str]:
    """Docs of a table's keys: the strings below their lines, with those of the tables it is made from."""
    found: dict[str, str] = {}
    for one in reversed([base for base in table.__mro__ if issubclass(base, BaseModel) and base is not BaseModel]):
        try:
            (body,) = ast.parse(textwrap.dedent(inspect.getsource(one))).body
        except (OSError, TypeError):  # made by create_model: its keys are documented where they are made
            continue
        assert isinstance(body, ast.ClassDef)
        for line, below in zip(body.body, body.body[1:], strict=False):
            if isinstance(line, ast.AnnAssign) and isinstance(line.target, ast.Name):
                match below:
                    case ast.Expr(value=ast.Constant(value=str(text))):
                        found[line.target.id] = " ".join(text.split())
    return found


def tables_of(model: type[BaseModel]) -> Iterator[tuple[str, type[BaseModel], bool]]:
    """Tables of a file: name, its class, and whether there may be several."""
    for name, field in model.model_fields.items():
        text = str(field.annotation)
        for one in _classes(field.annotation):
            yield field.alias or name, one, text.startswith("tuple") or "tuple[" in text


def _classes(annotation: Any) -> Iterator[type[BaseModel]]:
    if inspect.isclass(annotation) and issubclass(annotation, BaseModel):
        yield annotation
    for inner in getattr(annotation, "__args__", ()):
        yield from _classes(inner)


def allowed(schema: Mapping[str, Any], defs: Mapping[str, Any]) -> str:
    """What a key may be, in words, from its JSON schema."""
    if "$ref" in schema:
        schema = defs[schema["$ref"].rpartition("/")[2]]
    if "anyOf" in schema:
        return " or ".join(word for one in schema["anyOf"] if (word := allowed(one, defs)))
    if "enum" in schema:
        return ", ".join(f'`"{one}"`' if isinstance(one, str) else f"`{one}`" for one in schema["enum"])
    if "const" in schema:
        return f'`"{schema["const"]}"`'
    match schema.get("type"):
        case "array":
            if "prefixItems" in schema:
                return f"{len(schema['prefixItems'])} numbers"
            return f"{allowed(schema.get('items', {}), defs)}, or a list"
        case "number" | "integer" as kind:
            return " ".join(["number" if kind == "number" else "whole number", *_bounds(schema)])
        case "string":
            return "text"
        case "boolean":
            return "true, false"
        case "object":
            return "value and source" if "source" in schema.get("properties", {}) else "table"
    return ""


def _bounds(schema: Mapping[str, Any]) -> Iterator[str]:
    words = {"exclusiveMinimum": "above", "minimum": "from", "exclusiveMaximum": "below", "maximum": "to"}
    for key, word in words.items():
        if key in schema:
            yield f"{word} {schema[key]:g}"


def row(cells: Sequence[str]) -> str:
    """A line of a Markdown table."""
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |\n"


def keys_of_table(table: type[BaseModel]) -> str:
    """A Markdown table of a TOML table's keys."""
    schema = table.model_json_schema()
    defs, docs = schema.get("$defs", {}), documented(table)
    lines = [row(["key", "unit", "allowed", "left out", "what it is"]), row(["---"] * 5)]
    needed = [key for key in schema.get("required", ()) if "left out:" not in docs.get(key, "").lower()]
    for key, one in schema["properties"].items():
        left_out = "must be given" if key in needed else _default(one.get("default"))
        lines.append(
            row([f"`{key}`", unit(key), allowed(one, defs), left_out, docs.get(key, one.get("description", ""))])
        )
    return "".join(lines)


def _default(value: Any) -> str:
    match value:
        case None | [] | ():
            return "none"
        case bool():
            return f"`{str(value).lower()}`"
        case str():
            return f'`"{value}"`'
        case int() | float():
            return f"`{value:g}`"
    return "see below" if isinstance(value, dict) else f"`{value}`"


def keys_page(title: str, about: str, model: type[BaseModel]) -> str:
    """A page of the keys of a kind of file."""
    parts = [f"# {title}\n\n{MADE}{about}\n"]
    for name, table, several in tables_of(model):
        heading = f"[[{name}]]" if several else f"[{name}]"
        about_table = inspect.cleandoc(table.__doc__ or "").replace("``", "`")
        parts.append(f"\n## `{heading}`\n\n{about_table}\n\n{keys_of_table(table)}".replace("``", "`"))
    return "".join(parts)


def columns_page() -> str:
    """The page of every table's columns."""
    found = tomllib.loads((GUIDE / "columns.toml").read_text(encoding="utf-8"))
    parts = [f"# Columns of the tables\n\n{MADE}Units are in the names of the columns; angles are in degrees.\n"]
    for columns in found.values():
        parts.append(f"\n## {columns['_file']}\n\n{columns['_about']}\n\n")
        parts += [row(["column", "unit", "what it is"]), row(["---"] * 3)]
        parts += [row([f"`{key}`", unit(key), text]) for key, text in columns.items() if not key.startswith("_")]
    return "".join(parts)


def commands_page() -> str:
    """The page of every command and its options."""
    parts = [f"# Commands\n\n{MADE}`codend COMMAND --help` prints the same.\n"]
    for path, command in sorted(_leaves(commands, "codend")):
        with click.Context(command, info_name=path, max_content_width=100) as context:
            parts.append(f"\n## {path}\n\n```text\n{command.get_help(context)}\n```\n")
    return "".join(parts)


def _leaves(command: click.Command, path: str) -> Iterator[tuple[str, click.Command]]:
    if isinstance(command, click.Group):
        for name, one in command.commands.items():
            yield from _leaves(one, f"{path} {name}")
    else:
        yield path, command


def pages() -> dict[str, str]:
    """Every page that is made, by file name."""
    plan = "A plan is a TOML file. A key that is unknown, missing or out of range ends the run with one line."
    scene = "A scene is a TOML file of ropes, points, netting and water that are no codend: `codend scene`."
    fish = "A species file holds what meshes meet of a fish, each number with its source: `codend species` prints one."
    return {
        "plan-keys.md": keys_page("Keys of a plan", plan, Plan),
        "scene-keys.md": keys_page("Keys of a scene", scene, Scene),
        "species-keys.md": keys_page("Keys of a species file", fish, Species),
        "columns.md": columns_page(),
        "commands.md": commands_page(),
    }


if __name__ == "__main__":
    for name, text in pages().items():
        (GUIDE / name).write_text(text, encoding="utf-8")
        print(f"{GUIDE / name}: {len(text.splitlines())} lines")
