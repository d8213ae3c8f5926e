"""Fish ahead of merged meshes meet openings that go from row to row, and errors tell what that is worth."""

import numpy as np
import pytest

from codend.selectivity.escape.meshes_met import _between_merged_rows
from codend.selectivity.escape.species import example_species_path, load_species
from codend.studies.catches_solved import selectivity_in
from codend.studies.study import solve
from tests.plans import make_plan


def test_openings_that_change_evenly_along_the_net_do_so_at_its_real_rows():
    ring = np.array([-2.0, 0.0, 2.0])
    row, mesh = np.divmod(np.arange(15), 3)
    ahead = 20.0 - 3.0 * row[:, None] - np.arange(3)
    values = 40.0 + 1.5 * ahead.mean(axis=1) + ring[mesh]
    found = _between_merged_rows(values, row, np.zeros(15, dtype=np.int64), ahead)
    inside = slice(3, 12)  # beyond the middle of the first and the last row nothing is known
    assert found[inside] == pytest.approx((40.0 + 1.5 * ahead + ring[mesh][:, None])[inside], rel=1e-12)


def test_where_netting_changes_openings_do_not_go_over_into_each_other():
    row = np.arange(6)
    section = np.array([0, 0, 0, 1, 1, 1])
    ahead = 20.0 - 2.0 * row[:, None] - np.arange(2)
    found = _between_merged_rows(np.where(section == 0, 30.0, 60.0), row, section, ahead)
    assert (found == np.where(section == 0, 30.0, 60.0)[:, None]).all()


@pytest.mark.parametrize("mesh", ["diamond", "t90"])
@pytest.mark.parametrize("merged", [2, 4])
def test_merged_meshes_tell_l50_and_sr_of_all_meshes_within_what_they_state(mesh, merged):
    (species,) = [load_species(example_species_path())]
    found = []
    for fidelity in ({"fidelity": "full"}, {"fidelity": "globalised", "globalisation": merged}):
        netting = {"twine_density_kg_m3": 1140.0, "knot_mm": 4.0 if mesh == "t90" else 0.0}
        plan = make_plan(40, 32, filled=8.0, netting=netting, mesh=mesh, model=fidelity)
        (one,) = selectivity_in(solve(plan), [species]).values()
        found.append(one)
    every, few = found
    for name in ("l50", "sr"):
        assert abs(few[f"{name}_cm"] - every[f"{name}_cm"]) < few[f"{name}_opening_error_cm"]
        assert every[f"{name}_opening_error_cm"] < 1e-6
    assert few["sr_cm"] == pytest.approx(every["sr_cm"], rel=0.05)
