"""Shape, drag, mesh opening and selectivity of towed trawl codends.

>>> plan = codend.load_plan("plan.toml")
>>> study = codend.solve(plan)
>>> study.table
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from codend.errors import InputError
    from codend.plan.plan import Plan, load_plan
    from codend.studies.opening_force import pull_mesh
    from codend.studies.study import Study, solve

__all__ = ["InputError", "Plan", "Study", "load_plan", "pull_mesh", "solve"]

_HOME = {
    "InputError": "codend.errors",
    "Plan": "codend.plan.plan",
    "load_plan": "codend.plan.plan",
    "Study": "codend.studies.study",
    "solve": "codend.studies.study",
    "pull_mesh": "codend.studies.opening_force",
}


def __getattr__(name: str) -> Any:
    """Import public names where they are first used: the compiled and table libraries take their time."""
    if name in _HOME:
        return getattr(import_module(_HOME[name]), name)
    if name == "panel":
        return import_module("codend.scenes.panel")
    raise AttributeError(f"module 'codend' has no attribute '{name}'")
