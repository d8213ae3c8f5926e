"""The meshes that fish meet are the same out of memory as out of the tables."""

from dataclasses import fields

import numpy as np
import pytest

import codend
from codend.plan.plan import plan_from_dict
from codend.selectivity.escape.catches import catches_of, run_of
from codend.studies.catches_solved import catches_in

TUBE = {"mesh": "diamond", "meshes_round": 24, "meshes_long": 16, "bar_mm": 45.0, "knot_mm": 8.0, "twine_mm": 3.0}
SQUARE = TUBE | {"mesh": "square", "knot_mm": 0.0}
WINDOW = {
    "mesh": "square", "meshes_round": 6, "meshes_long": 8, "bar_mm": 45.0, "twine_mm": 2.0,
    "netting": "1", "panel": "upper", "meshes_from_codline": [6, 10], "meshes_across": 6,
}  # fmt: skip
PLANS = {
    "diamond": {"netting": [TUBE]},
    "t90": {"netting": [TUBE | {"mesh": "t90"}]},
    "square": {"netting": [SQUARE]},
    "globalised": {"netting": [TUBE], "model": {"fidelity": "globalised", "globalisation": 2}},
    "full": {"netting": [TUBE], "model": {"fidelity": "full"}},
    "t90 behind square": {
        "netting": [TUBE | {"mesh": "square", "meshes_long": 6, "knot_mm": 0.0}, TUBE | {"mesh": "t90"}]
    },
    "two panels with ropes": {
        "netting": [TUBE | {"panels": 2}],
        "rope": [{"number": 2, "shortening": 0.1, "axial_stiffness_n": 2e4, "diameter_mm": 12}],
    },
    "smeared": {
        "netting": [TUBE],
        "rope": [{"number": 2, "shortening": 0.1, "axial_stiffness_n": 2e4, "diameter_mm": 12}],
        "model": {"fidelity": "smeared"},
    },
    "layer": {"netting": [TUBE], "layer": [TUBE | {"meshes_round": 20, "meshes_from_codline": [0, 6]}]},
    "window": {
        "netting": [TUBE | {"panels": 2}],
        "window": [WINDOW],
    },
}


def plan_of(tables):
    """A small codend of the tables, with two catches."""
    return plan_from_dict(
        {
            "title": "met",
            "tow": {"speed_m_s": 1.3},
            "entry": {"radius_m": 0.16},
            "catch": {"filled_meshes": [4.0, 9.0]},
            **tables,
        }
    )


@pytest.mark.parametrize("name", PLANS)
def test_meshes_out_of_memory_are_those_of_the_tables(name):
    study = codend.solve(plan_of(PLANS[name]))
    assert study.converged
    for there, here in zip(catches_of(run_of(study), 6.0), catches_in(study, 6.0), strict=True):
        assert there.parts == here.parts
        assert (there.case, there.smeared, there.volume_m3) == (here.case, here.smeared, here.volume_m3)
        assert np.array_equal(there.rows_ahead, here.rows_ahead)
        assert np.array_equal(there.share, here.share)
        for field in fields(there.holes):
            assert np.array_equal(getattr(there.holes, field.name), getattr(here.holes, field.name)), field.name
