"""A plan written back as TOML: the copy that lies beside the results, all defaults filled in."""

import json
from collections.abc import Mapping
from typing import Any

from codend.io.names import as_text
from codend.plan.plan import Plan


def plan_toml(plan: Plan) -> str:
    """The plan as TOML that ``load_plan`` reads back to an equal plan, from any folder; overrides are part of it."""
    tables = plan.to_dict()
    if plan.sphere_cp_path is not None:
        tables["catch"]["sphere_cp_csv"] = as_text(plan.sphere_cp_path.absolute())
    lines = ["# The plan as it was solved: changes made on the command line and defaults included."]
    lines += [f"{key} = {toml_value(value)}" for key, value in tables.items() if not isinstance(value, dict | list)]
    for name, table in tables.items():
        if isinstance(table, dict):
            lines += ["", f"[{name}]", *_entries(table)]
        elif isinstance(table, list):
            for part in table:
                lines += ["", f"[[{name}]]", *_entries(part)]
    return "\n".join(lines) + "\n"


def _entries(table: Mapping[str, Any]) -> list[str]:
    return [f"{key} = {toml_value(value)}" for key, value in table.items()]


def toml_value(value: Any) -> str:
    """A number, text, truth value or list of them: spelled as in JSON, but that TOML takes no DEL as it is."""
    if isinstance(value, list):
        return "[" + ", ".join(map(toml_value, value)) + "]"
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
