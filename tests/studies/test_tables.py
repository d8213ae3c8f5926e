"""Tables of a study: every row and mesh with its section and its place, whatever was modelled."""

import numpy as np
import pytest

import codend
from codend.plan.plan import Plan
from tests.plans import joined_plan, make_plan

HALVED = ("diamond", 24, 8, 40.0, {"name": "fore, wide"}), ("diamond", 12, 8, 40.0, {})
SQUARES_BETWEEN = tuple(
    (mesh, 12, 4, 40.0, {"name": name}) for mesh, name in zip(("diamond", "square", "t90"), "abc", strict=True)
)
MERGED = {"fidelity": "globalised", "globalisation": 2}


def halved(model: dict) -> Plan:
    return joined_plan(*HALVED, catch={"filled_meshes": 5.0}, model=model)


@pytest.mark.parametrize("model", [{}, MERGED])
def test_rows_are_placed_in_real_meshes_from_the_entry(model):
    profile = codend.solve(halved(model)).profile
    np.testing.assert_array_equal(profile["meshes_from_entry"], np.linspace(0.0, 16.0, len(profile)))


@pytest.mark.parametrize("model", [{}, MERGED])
def test_rows_are_of_the_section_whose_meshes_they_count(model):
    """Where two sections meet, of the one with fewer meshes round."""
    profile = codend.solve(halved(model)).profile
    fore = profile["meshes_from_entry"] < 8.0
    np.testing.assert_array_equal(profile["section"], np.where(fore, "fore, wide", "2"))


def test_square_meshes_lie_half_a_mesh_behind_the_row_that_counts_them():
    study = codend.solve(joined_plan(*SQUARES_BETWEEN, catch={"filled_meshes": 3.0}, model={"fidelity": "full"}))
    meshes = study.meshes.merge(study.profile, on=["case", "row"], suffixes=("", "_of_row"))
    square = meshes["section"] == "b"
    assert square.sum() == 4 * 12
    np.testing.assert_array_equal(meshes["meshes_from_entry"] - meshes["meshes_from_entry_of_row"], 0.5 * square)
    np.testing.assert_array_equal(meshes["section"], meshes["section_of_row"])


def test_meshes_are_counted_from_0_in_their_row():
    study = codend.solve(joined_plan(*SQUARES_BETWEEN, catch={"filled_meshes": 3.0}, model={"fidelity": "full"}))
    for _, mesh in study.meshes.groupby("row")["mesh"]:
        assert mesh.tolist() == list(range(12))


def test_every_model_more_than_one_mesh_wide_has_its_meshes():
    """A sector of 24 meshes joined to 12 is two wide ahead of the joint, and their mean stands in the profile."""
    study = codend.solve(halved({}))
    meshes = study.meshes.groupby("row")
    assert meshes.size().tolist() == [2] * 15 + [1] * 16
    mean = study.profile["opening_deg"].dropna()
    np.testing.assert_allclose(meshes["opening_deg"].mean(), mean, rtol=1e-12)
    assert codend.solve(make_plan(12, 10, filled=3.0)).meshes.empty
