"""The tangent of each load alone against central differences, on sectors, full nets and distorted shapes."""

import numpy as np
import pytest

from catch_models.pressure import sphere_law
from codend.build import build_net
from codend.loads import problem_of
from codend.mechanics import arrays
from codend.mechanics.arrays import Loading, Structure
from codend.mechanics.bars import add_bar_forces, bar_lengths
from codend.mechanics.drag import add_drag
from codend.mechanics.pressure import add_pressure, fill
from codend.mechanics.tangent import Pattern, add_bar_tangent, pattern_of
from codend.mechanics.tangent_front import front_band, load_by_share, share_gradient
from codend.mechanics.tangent_loads import add_drag_tangent, add_pressure_tangent
from codend.plan import plan_from_dict

MESHES = ["diamond", "knotted", "t90", "square"]
COLUMNS = [1, 2, None]


def _case(mesh, columns, distortion=0.1, **loading):
    section = {
        "mesh": "diamond" if mesh == "knotted" else mesh,
        "meshes_round": 8,
        "meshes_long": 4,
        "bar_mm": 100.0,
        "knot_mm": 0.0 if mesh in {"diamond", "square"} else 20.0,
        "twine_mm": 4.0,
    }
    plan = plan_from_dict(
        {
            "title": "small",
            "tow": {"speed_m_s": 1.3, "water_density_kg_m3": 1000.0},
            "entry": {"radius_m": 0.1},
            "netting": [section],
            "catch": {"filled_meshes": 2.3, "pressure": "sphere"},
        }
    )
    net = build_net(plan, columns=columns)
    problem = problem_of(net, plan, plan.cases()[0])
    rng = np.random.default_rng(7)
    position = net.positions + distortion * 0.1 * rng.normal(size=net.positions.shape)
    return problem.structure, problem.loading._replace(**loading), position


def _dense(pattern: Pattern, blocks: np.ndarray, nodes: int) -> np.ndarray:
    matrix = np.zeros((nodes, 3, nodes, 3))
    for row, column, block in zip(pattern.row, pattern.column, blocks, strict=True):
        matrix[row, :, column] += block
    return matrix.reshape(3 * nodes, 3 * nodes)


def _differences(force, position, step=1e-6):
    columns = []
    for i in range(position.size):
        move = np.zeros(position.size)
        move[i] = step
        move = move.reshape(position.shape)
        columns.append((force(position - move) - force(position + move)).ravel() / (2.0 * step))
    return np.stack(columns, axis=1)


def _shares(structure: Structure, loading: Loading, position: np.ndarray) -> np.ndarray:
    share = np.zeros_like(structure.band_meshes)
    fill(position, structure, loading, share)
    return share


def _blocks(structure):
    pattern = pattern_of(structure)
    return pattern, np.zeros((len(pattern.row), 3, 3))


@pytest.mark.parametrize("columns", COLUMNS)
@pytest.mark.parametrize("mesh", MESHES)
def test_tangent_of_elastic_bars_is_the_derivative_of_their_pull(mesh, columns):
    structure, _, position = _case(mesh, columns)
    stiffness = 50.0

    def force(at):
        length = np.zeros(len(structure.first))
        bar_lengths(at, structure, length)
        result = np.zeros_like(at)
        add_bar_forces(at, structure, stiffness * (1.0 / structure.length - 1.0 / length), result)
        return result

    pattern, blocks = _blocks(structure)
    length = np.zeros(len(structure.first))
    bar_lengths(position, structure, length)
    density = stiffness * (1.0 / structure.length - 1.0 / length)
    add_bar_tangent(position, structure, pattern, density, stiffness / length**3, blocks)
    expected = _differences(force, position)
    np.testing.assert_allclose(_dense(pattern, blocks, len(position)), expected, atol=1e-6 * np.abs(expected).max())


@pytest.mark.parametrize("law", [arrays.LE_BRIS_1999, arrays.BESSONNEAU_1997])
@pytest.mark.parametrize("columns", COLUMNS)
@pytest.mark.parametrize("mesh", ["diamond", "t90"])
def test_tangent_of_the_drag_is_its_derivative_at_given_shares(mesh, columns, law):
    structure, loading, position = _case(mesh, columns, drag_law=law, tangential=0.1)
    share = _shares(structure, loading, position)

    def force(at):
        result = np.zeros_like(at)
        add_drag(at, structure, loading, share, result)
        return result

    pattern, blocks = _blocks(structure)
    add_drag_tangent(position, structure, loading, pattern, share, blocks)
    expected = _differences(force, position)
    np.testing.assert_allclose(_dense(pattern, blocks, len(position)), expected, atol=1e-6 * np.abs(expected).max())


@pytest.mark.parametrize("columns", COLUMNS)
@pytest.mark.parametrize("mesh", MESHES)
def test_tangent_of_the_pressure_is_its_derivative_at_given_shares(mesh, columns):
    structure, loading, position = _case(mesh, columns)
    share = _shares(structure, loading, position)

    def force(at):
        result = np.zeros_like(at)
        add_pressure(at, structure, loading, share, result)
        return result

    pattern, blocks = _blocks(structure)
    add_pressure_tangent(position, structure, loading, pattern, share, blocks)
    expected = _differences(force, position)
    np.testing.assert_allclose(_dense(pattern, blocks, len(position)), expected, atol=2e-6 * np.abs(expected).max())


@pytest.mark.parametrize("turn", [0.0, np.pi])
def test_pressure_tangent_is_finite_on_facets_square_to_the_flow(turn):
    structure, loading, position = _case("diamond", None, distortion=0.0)
    flat = position.copy()
    flat[:, 0] = 0.0
    flat[:, 1] *= np.cos(turn)
    pattern, blocks = _blocks(structure)
    add_pressure_tangent(flat, structure, loading, pattern, np.ones_like(structure.band_meshes), blocks)
    assert np.all(np.isfinite(blocks))
    # just off the axis of the flow the derivative is as large, and differs by the order of the law's slope there
    near = np.zeros_like(blocks)
    add_pressure_tangent(
        flat + 1e-9 * np.random.default_rng(1).normal(size=flat.shape),
        structure,
        loading,
        pattern,
        np.ones_like(structure.band_meshes),
        near,
    )
    slope = np.abs(sphere_law().derivative([0.0, np.pi])).max()
    assert np.abs(near - blocks).max() <= 5.0 * slope * np.abs(blocks).max()


@pytest.mark.parametrize("columns", COLUMNS)
@pytest.mark.parametrize("mesh", ["diamond", "knotted", "t90"])
@pytest.mark.parametrize(("kind", "value"), [(arrays.FRONT_FROM_CODLINE, 0.3), (arrays.VOLUME, 5e-3)])
def test_moving_front_adds_the_product_of_load_by_share_and_share_by_position(mesh, columns, kind, value):
    structure, loading, position = _case(mesh, columns, distortion=0.03, catch_kind=kind, catch_value=value)

    def force(at):
        share = _shares(structure, loading, at)
        result = np.zeros_like(at)
        add_drag(at, structure, loading, share, result)
        add_pressure(at, structure, loading, share, result)
        return result

    share = _shares(structure, loading, position)
    band = front_band(loading, share)
    assert 0 < band < len(share) - 1
    pattern, blocks = _blocks(structure)
    add_drag_tangent(position, structure, loading, pattern, share, blocks)
    add_pressure_tangent(position, structure, loading, pattern, share, blocks)
    gradient, load = np.zeros_like(position), np.zeros_like(position)
    share_gradient(position, structure, loading, share, band, gradient)
    load_by_share(position, structure, loading, band, load)
    expected = _differences(force, position, 1e-7)
    found = _dense(pattern, blocks, len(position)) - np.outer(load.ravel(), gradient.ravel())
    np.testing.assert_allclose(found, expected, atol=1e-5 * np.abs(expected).max())


def test_filled_meshes_leave_the_shares_where_they_are():
    structure, loading, position = _case("diamond", 1)
    assert front_band(loading, _shares(structure, loading, position)) == -1
