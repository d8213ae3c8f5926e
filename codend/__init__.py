"""Shape, drag, mesh opening and selectivity of towed trawl codends.

>>> plan = codend.load_plan("plan.toml")
>>> study = codend.solve(plan)
>>> study.table
>>> study.plot("opening")
>>> codend.selectivity(study, "haddock.toml")
>>> codend.fit("hauls.csv", "covered").answers[0].estimates

A net that is no codend, from its nodes and bars:

>>> net = codend.Net.from_bars(positions, ends, held, stiffness_n=5e4)
>>> problem = codend.Problem.of(net)
>>> found = codend.find_equilibrium(problem)
>>> codend.loads_and_supports(problem, found)
>>> codend.draw(problem, found)
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from codend.errors import InputError
    from codend.mechanics.problem import Problem
    from codend.net.net import Net
    from codend.plan.plan import Plan, load_plan
    from codend.public import Study, solve
    from codend.report.net_figure import draw
    from codend.selectivity.fits.analysis import fit_field_data as fit
    from codend.solvers.reactions import loads_and_supports
    from codend.solvers.solve import find_equilibrium
    from codend.studies.many import sweep
    from codend.studies.opening_force import pull_mesh

__all__ = [
    "InputError",
    "Net",
    "Plan",
    "Problem",
    "Study",
    "draw",
    "find_equilibrium",
    "fit",
    "load_plan",
    "loads_and_supports",
    "pull_mesh",
    "sensitivities",
    "solve",
    "sweep",
]

_HOME = {
    "InputError": "codend.errors",
    "Net": "codend.net.net",
    "Plan": "codend.plan.plan",
    "Problem": "codend.mechanics.problem",
    "Study": "codend.public",
    "draw": "codend.report.net_figure",
    "find_equilibrium": "codend.solvers.solve",
    "fit_field_data": "codend.selectivity.fits.analysis",
    "load_plan": "codend.plan.plan",
    "loads_and_supports": "codend.solvers.reactions",
    "pull_mesh": "codend.studies.opening_force",
    "sensitivities": "codend.studies.sensitivity.table",
    "solve": "codend.public",
    "sweep": "codend.studies.many",
}
_OTHER_NAMES = {"fit": "fit_field_data"}
_ROOMS = {"panel": "codend.scenes.panel", "selectivity": "codend.selectivity"}


def __getattr__(name: str) -> Any:
    """Import public names where they are first used: the compiled and table libraries take their time."""
    if name in _ROOMS:
        return import_module(_ROOMS[name])
    name_there = _OTHER_NAMES.get(name, name)
    if name_there in _HOME:
        return getattr(import_module(_HOME[name_there]), name_there)
    raise AttributeError(f"module 'codend' has no attribute '{name}'")
