"""Small nets for the maps: quick to solve thousands of times, with all that a large one has."""

from typing import Any

import numpy as np

from codend.bag.bag import Bag
from codend.bag.build import build_bag
from codend.bag.loads import problem_of
from codend.mechanics.problem import Problem
from codend.net.net import Floats
from codend.plan.plan import Plan, plan_from_dict

MESHES_ROUND, MESHES_LONG = 24, 20
BAR_M = 0.04
STRETCHED_RADIUS_M = MESHES_ROUND * BAR_M / np.pi
"""Radius of the bag with meshes pulled fully open: the bound of the entry's."""


def plan_of(
    filled: float = 6.0,
    entry: float = 0.35,
    speed: float = 1.0,
    *,
    netting: dict[str, Any] | None = None,
    catch: dict[str, Any] | None = None,
    normal_drag: float = 1.36,
    **model: Any,
) -> Plan:
    """A plan of 24 x 20 diamond meshes of 40 mm bars of 2 mm twine, unless told otherwise; all numbers are made up.

    Args:
        filled: meshes in the catch.
        entry: radius of the entry over that of meshes pulled fully open.
        speed: m/s.
        netting: keys of the section to change or add.
        catch: keys of the catch to add.
        normal_drag: normal drag coefficient of the twine, 0 for none.
        model: keys of the model.
    """
    section: dict[str, Any] = {
        "mesh": "diamond",
        "meshes_round": MESHES_ROUND,
        "meshes_long": MESHES_LONG,
        "bar_mm": 1000.0 * BAR_M,
        "twine_mm": 2.0,
    }
    section |= netting or {}
    bound = plan_bound(section)
    return plan_from_dict(
        {
            "title": "stability map",
            "tow": {"speed_m_s": speed, "water_density_kg_m3": 1000.0},
            "entry": {"radius_m": entry * bound},
            "netting": [section],
            "catch": {"filled_meshes": filled} | (catch or {}),
            "drag": {"normal": normal_drag},
            "model": {"fidelity": "sector"} | model,
        }
    )


def plan_bound(section: dict[str, Any]) -> float:
    """Radius of a section's meshes pulled fully open, m."""
    across = section["bar_mm"] + (section.get("knot_mm", 0.0) if section["mesh"] == "t90" else 0.0)
    return float(section["meshes_round"] * across / 1000.0 / np.pi / (2.0 if section["mesh"] == "square" else 1.0))


def bag_and_problem(plan: Plan, globalisation: int = 1, sectors: int | None = 1) -> tuple[Bag, Problem]:
    """Bag of the plan under the loads of its first case, on one sector unless told otherwise."""
    bag = build_bag(plan, globalisation=globalisation, sectors=sectors)
    return bag, problem_of(bag, plan, plan.cases()[0])


def disturbed(problem: Problem, positions: Floats, bars: float, seed: tuple[int, ...]) -> Floats:
    """Positions with a random move of every free coordinate, normally distributed, ``bars`` mean bar lengths each."""
    random = np.random.default_rng(list(seed)).normal(size=positions.shape)
    return np.asarray(positions + bars * float(problem.net.bar_length.mean()) * random * ~problem.net.fixed)
