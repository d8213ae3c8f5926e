from dataclasses import replace
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest

from codend.bag.bag import WholeBag, all_round, mesh_corners
from codend.bag.measures import mesh_openings
from codend.net.net import bar_vectors
from codend.plan.plan import plan_from_dict
from codend.report.polygons import joined_on_axis, mesh_polygons
from codend.report.vtk import net_mesh, write_vtu
from codend.studies.case_result import CaseResult
from codend.studies.study import solve

ROUND, LONG = 24, 20
NETTINGS: dict[str, dict[str, Any]] = {
    "ideal": {"mesh": "diamond"},
    "knotted": {"mesh": "diamond", "knot_mm": 4.0},
    "t90": {"mesh": "t90", "knot_mm": 4.0},
    "square": {"mesh": "square"},
}


def solved_case(netting: str, **model: Any) -> CaseResult:
    section = {"meshes_round": ROUND, "meshes_long": LONG, "bar_mm": 40.0, "twine_mm": 2.0, **NETTINGS[netting]}
    plan = {
        "title": "Small bag",
        "tow": {"speed_m_s": 1.0, "water_density_kg_m3": 1000.0},
        "entry": {"radius_m": 0.1},
        "netting": [section],
        "catch": {"filled_meshes": 6},
        "model": model,
    }
    (result,) = solve(plan_from_dict(plan)).cases
    assert result.converged
    return result


@pytest.fixture(scope="module", params=NETTINGS)
def case(request: pytest.FixtureRequest) -> CaseResult:
    return solved_case(request.param)


def written(case: CaseResult, tmp_path: Path) -> meshio.Mesh:
    write_vtu(case, tmp_path / "net.vtu")
    return meshio.read(tmp_path / "net.vtu")


def values_by_block(mesh: meshio.Mesh, name: str) -> tuple[np.ndarray, np.ndarray]:
    bars, *meshes = mesh.cell_data[name]
    return bars, np.concatenate(meshes)


def test_every_bar_of_the_whole_net_is_a_line_with_its_tension_and_length(case: CaseResult, tmp_path: Path):
    mesh = written(case, tmp_path)
    net = case.net
    lines = mesh.cells[0]
    assert lines.type == "line"
    assert len(lines.data) == net.order * len(net.bars) == len(mesh.cell_data["tension_n"][0])
    np.testing.assert_array_equal(mesh.cell_data["tension_n"][0], np.tile(case.bar_tension_n, net.order))
    ends = mesh.points[lines.data]
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    modelled = np.linalg.norm(bar_vectors(net, case.positions), axis=1)
    np.testing.assert_allclose(length, np.tile(modelled, net.order), rtol=1e-12, atol=1e-12)


def test_every_mesh_of_the_whole_net_is_a_polygon_with_its_values(case: CaseResult, tmp_path: Path):
    mesh = written(case, tmp_path)
    order, meshes = case.net.order, case.meshes
    assert meshes is not None
    count = order * len(case.bag.mesh_row)
    assert sum(len(block.data) for block in mesh.cells[1:]) == count
    for name, expected in (
        ("tension_n", meshes.bar_tension_n),
        ("opening_deg", meshes.opening_deg),
        ("opening_force_n", meshes.opening_force_n),
        ("pressure_pa", meshes.pressure_pa),
    ):
        _, found = values_by_block(mesh, name)
        np.testing.assert_array_equal(np.sort(found), np.sort(np.tile(expected, order)))


@pytest.mark.parametrize(
    ("netting", "corners"), [("ideal", {4}), ("knotted", {6}), ("t90", {5, 6}), ("square", {3, 4})]
)
def test_repeated_corners_of_meshes_are_left_out(netting: str, corners: set[int]):
    # T90: gathered knots at the codline are points; square: the last row of meshes ends in the codline
    mesh = net_mesh(solved_case(netting))
    assert {block.data.shape[1] for block in mesh.cells[1:]} == corners
    for block in mesh.cells[1:]:
        assert block.type == {3: "triangle", 4: "quad"}.get(block.data.shape[1], "polygon")
        ordered = np.sort(block.data, axis=1)
        assert np.all(np.diff(ordered, axis=1) > 0)


def test_values_sit_on_the_polygons_they_were_measured_on():
    mesh = net_mesh(solved_case("ideal"))
    corners = mesh.points[mesh.cells[1].data]
    along, across = (np.linalg.norm(corners[:, a] - corners[:, b], axis=1) for a, b in ((2, 0), (3, 1)))
    np.testing.assert_allclose(mesh.cell_data["opening_deg"][1], np.degrees(2 * np.arctan2(across, along)), rtol=1e-9)


def test_only_bars_have_no_opening_and_no_pressure(case: CaseResult, tmp_path: Path):
    mesh = written(case, tmp_path)
    for name in mesh.cell_data:
        bars, meshes = values_by_block(mesh, name)
        # square mesh has no opening force
        told = case.bag.mesh_opens if name == "opening_force_n" else np.ones(len(case.bag.mesh_row), dtype=bool)
        assert np.count_nonzero(np.isfinite(meshes)) == case.net.order * np.count_nonzero(told)
        assert np.all(np.isfinite(bars)) if name == "tension_n" else np.all(np.isnan(bars))


def test_the_codline_is_one_node_and_no_node_is_unused(case: CaseResult):
    mesh = net_mesh(case)
    on_axis = ~np.any(mesh.points[:, 1:], axis=1)
    assert np.count_nonzero(on_axis) == 1
    used = np.unique(np.concatenate([block.data.ravel() for block in mesh.cells]))
    np.testing.assert_array_equal(used, np.arange(len(mesh.points)))


def test_joining_on_the_axis_moves_no_bar():
    case = solved_case("ideal")
    before = all_round(case.bag, case.positions)
    after = joined_on_axis(before)
    np.testing.assert_array_equal(after.positions[after.bars], before.positions[before.bars])
    np.testing.assert_array_equal(after.positions[after.meshes], before.positions[before.meshes])


def test_nodes_that_meet_elsewhere_than_on_the_axis_stay_apart():
    apart = np.array([[0.0, 1.0, 0.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [1.0, 0.0, -0.0]])
    whole = WholeBag(apart, np.array([[0, 2], [1, 4]], dtype=np.int32), np.zeros((0, 8), dtype=np.int32))
    joined = joined_on_axis(whole)
    assert len(joined.positions) == 4
    assert joined.bars.tolist() == [[0, 2], [1, 2]]


def test_each_mesh_is_one_polygon(case: CaseResult):
    polygons = mesh_polygons(all_round(case.bag, case.positions))
    numbers = np.sort(np.concatenate([which for which, _ in polygons]))
    np.testing.assert_array_equal(numbers, np.arange(case.net.order * len(case.bag.mesh_row)))


def test_polygons_are_walked_anticlockwise_seen_from_outside(case: CaseResult):
    whole = all_round(case.bag, case.positions)
    _, normal = mesh_openings(case.bag, mesh_corners(case.bag, case.positions))
    for which, corners in mesh_polygons(whole):
        points = whole.positions[corners]
        area = np.cross(points, np.roll(points, -1, axis=1)).sum(axis=1)
        first_sector = which < len(case.bag.mesh_row)
        assert np.all(np.einsum("ij,ij->i", area[first_sector], normal[which[first_sector]]) > 0.0)


def test_tensions_of_a_globalised_net_are_those_of_the_real_bars(tmp_path: Path):
    case = solved_case("ideal", fidelity="globalised", globalisation=4)
    mesh = written(case, tmp_path)
    assert len(mesh.cells[0].data) == len(case.net.bars)
    np.testing.assert_allclose(mesh.cell_data["tension_n"][0] * 4, case.solution.bar_tension)


def test_a_case_without_an_answer_has_no_shape_to_write(tmp_path: Path):
    unsolved = replace(solved_case("ideal"), rows=None, meshes=None)
    with pytest.raises(ValueError, match="was not solved"):
        write_vtu(unsolved, tmp_path / "net.vtu")
    assert not list(tmp_path.iterdir())
