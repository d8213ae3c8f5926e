"""Whether any answer passes through itself: ``python -m validation.passing_through [--plans 300] [--seed 0]``.

Random plans of 20 to 30 meshes round (T0, T90 and square; limp, stiff, elastic, knotted; 0.3 meshes to all filled) are
solved by every method and fidelity, and every converged net is set all round and held to a check that shares nothing
with the project's own: which bars meet which facets by Moeller and Trumbore's formula on the pairs that a tree of
their middles finds near each other, and which rings cross themselves by the signs of areas. Exits with 1 if one does.
Rigid bars take a minute on a full net: they solve every ``--rigid-every``-th plan there.

Of all 300 plans 2465 nets converge by the nine models but rigid bars on full nets (commit 0e1feae, in slices of 20 by
``--seed``), and none passes through itself or holds an impossible catch; 5 are refused, 2 fail. Of plans 10, 74 and 96
single coverings of quadrangles are passed through, in folds; of plan 245 layers lay on each other without a word.
"""

import sys
from collections import Counter
from time import perf_counter

import click
import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from codend.bag.bag import Bag
from codend.errors import InputError
from codend.net.net import Net
from codend.plan.plan import Plan, plan_from_dict
from codend.studies.case_result import CaseResult
from codend.studies.study import solve

MODELS = (
    ("meridian", "auto"),
    ("sector", "auto"),
    ("sector", "newton"),
    ("sector", "dynamic-relaxation"),
    ("sector", "rigid-bars"),
    ("globalised", "auto"),
    ("full", "auto"),
    ("full", "newton"),
    ("full", "dynamic-relaxation"),
    ("full", "rigid-bars"),
)
TOUCHING, DEEPEST = 2e-3, 0.1
"""Depth over the shortest bar up to which netting counts as touching: of middle lines, and of twine with its thickness.
Rows of the latter say that layers lie on each other (``folds``) and have the errors of that."""


def random_plan(seed: int, fidelity: str, method: str, knots_push: bool = False) -> Plan:
    """One plan of the range above, its knots resisting compression or not."""
    rng = np.random.default_rng((seed, 13))
    mesh = str(rng.choice(["diamond", "t90", "square"]))
    kind = str(rng.choice(["limp", "stiff", "elastic", "knotted"]))
    meshes_round, meshes_long = 2 * int(rng.integers(10, 16)), 2 * int(rng.integers(4, 11))
    bar_mm = float(rng.uniform(20.0, 60.0))
    has_knots = mesh == "t90" or (kind == "knotted" and mesh == "diamond")
    knot_mm = float(rng.uniform(0.05, 0.25)) * bar_mm if has_knots else 0.0
    netting: dict[str, object] = {
        "mesh": mesh,
        "meshes_round": meshes_round,
        "meshes_long": meshes_long,
        "bar_mm": bar_mm,
        "knot_mm": knot_mm,
        "twine_mm": float(rng.uniform(0.02, 0.1)) * bar_mm,
    }
    if has_knots:
        netting["knot_compression"] = knots_push
    if kind == "elastic":
        netting["axial_stiffness_n"] = float(np.exp(rng.uniform(np.log(500.0), np.log(1e5))))
    if kind == "stiff" and mesh != "square":
        netting["bending_stiffness_n_m2"] = float(np.exp(rng.uniform(np.log(1e-5), np.log(3e-3))))
    across = meshes_round * (bar_mm + (knot_mm if mesh == "t90" else 0.0)) / 1000.0 / np.pi
    if mesh == "square":
        across *= 0.5
    filled = float(np.exp(rng.uniform(np.log(0.3), np.log(meshes_long)))) if rng.random() < 0.9 else float(meshes_long)
    return plan_from_dict(
        {
            "title": f"random {seed}",
            "tow": {"speed_m_s": float(rng.uniform(0.3, 2.0)), "water_density_kg_m3": 1026.0},
            "entry": {"radius_m": float(rng.uniform(0.1, 0.6)) * across},
            "netting": [netting],
            "catch": {"filled_meshes": filled, "pressure": str(rng.choice(["sphere", "uniform"]))},
            "model": {
                "fidelity": fidelity,
                "method": method,
                "globalisation": 2 if fidelity == "globalised" else 1,
            },
        }
    )


def solved(number: int, fidelity: str, method: str, knots_push: bool = False) -> CaseResult | None:
    """One random plan by a method and fidelity; None where they do not take it."""
    try:
        return solve(random_plan(number, fidelity, method, knots_push)).cases[0]
    except InputError:
        return None


def set_all_round(net: Net, positions: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Nodes of the whole net, bars and facets by their numbers; a node on the axis is one, not one a sector."""
    count, order = len(positions), net.order
    turn = np.exp(2j * np.pi * np.arange(order) / order)
    across = turn[:, None] * (positions[:, 1] + 1j * positions[:, 2])
    nodes = np.stack([np.broadcast_to(positions[:, 0], across.shape), across.real, across.imag], axis=-1).reshape(-1, 3)
    axial = np.all(positions[:, 1:] == 0.0, axis=1)

    def number(node: np.ndarray, image: np.ndarray) -> np.ndarray:
        sector = (image[None] + np.arange(order).reshape(-1, *[1] * node.ndim)) % order
        return np.where(axial[node], 0, sector * count) + node

    ends = np.stack([np.zeros_like(net.bar_image), net.bar_image], axis=1)
    return nodes, number(net.bars, ends).reshape(-1, 2), number(net.facets, net.facet_image).reshape(-1, 3)


def piercings(net: Net, positions: np.ndarray, touching: float) -> tuple[np.ndarray, np.ndarray]:
    """Bars of the whole net, (p,), and the facets each passes through, by more than ``touching`` (m) at both ends."""
    nodes, bars, facets = set_all_round(net, positions)
    start, end, corner = nodes[bars[:, 0]], nodes[bars[:, 1]], nodes[facets]
    middle = corner.mean(axis=1)
    reach = np.linalg.norm(corner - middle[:, None], axis=2).max() + 0.5 * np.linalg.norm(end - start, axis=1).max()
    near = cKDTree(0.5 * (start + end)).query_ball_tree(cKDTree(middle), reach)
    bar = np.repeat(np.arange(len(bars)), [len(found) for found in near])
    facet = np.concatenate([np.array(found, dtype=int) for found in near])
    apart = ~(bars[bar][:, :, None] == facets[facet][:, None, :]).any(axis=(1, 2))
    bar, facet = bar[apart], facet[apart]
    along, u, v = end[bar] - start[bar], *(corner[facet][:, i] - corner[facet][:, 0] for i in (1, 2))
    away = start[bar] - corner[facet][:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        determinant = np.einsum("ij,ij->i", u, np.cross(along, v))
        first = np.einsum("ij,ij->i", away, np.cross(along, v)) / determinant
        second = np.einsum("ij,ij->i", along, np.cross(away, u)) / determinant
        place = np.einsum("ij,ij->i", v, np.cross(away, u)) / determinant
        height = np.abs(determinant) / np.linalg.norm(np.cross(u, v), axis=1)
        inside = (first >= 0.0) & (second >= 0.0) & (first + second <= 1.0) & (place > 0.0) & (place < 1.0)
        deep = np.minimum(place, 1.0 - place) * height > touching
    return bar[inside & deep], facet[inside & deep]


def piercing_bars(net: Net, positions: np.ndarray, touching: float) -> np.ndarray:
    """Bars of the whole net that pass through a facet, or through two of netting that is covered twice."""
    bar, facet = piercings(net, positions, touching)
    weight = np.tile(np.where(net.facet_weight < 1.0, 0.5, 1.0), net.order)
    return np.flatnonzero(np.bincount(bar, weights=weight[facet]) >= 1.0)


def pierced_however_divided(net: Net, positions: np.ndarray, touching: float) -> np.ndarray:
    """Facets that are passed through and, of a quadrangle that is covered twice, so is one of its other covering.

    Layers that lie on each other may go in and come out by one covering alone: divided the other way it is not pierced.
    """
    _, _, facets = set_all_round(net, positions)
    half = np.tile(net.facet_weight < 1.0, net.order)
    sides = np.stack([facets, np.roll(facets, -1, axis=1)], axis=2).reshape(-1, 2)
    # coverings of one quadrangle run its sides one way; the two triangles of one run its diagonal against each other
    _, one_way = np.unique(sides, axis=0, return_inverse=True)
    quadrangle = _joined(one_way.ravel())
    within = np.column_stack([np.repeat(quadrangle, 3), np.sort(sides, axis=1)])
    _, side = np.unique(within, axis=0, return_inverse=True)
    side, senses = side.ravel(), np.where(sides[:, 0] < sides[:, 1], 1, -1)
    is_diagonal = (np.bincount(side) == 2) & (np.bincount(side, weights=senses) == 0)
    covering = _joined(np.where(is_diagonal[side], side, len(side) + np.arange(len(side))))
    pierced = np.unique(piercings(net, positions, touching)[1])
    coverings = np.unique(np.stack([quadrangle[pierced], covering[pierced]]), axis=1)
    found, times = np.unique(coverings[0], return_counts=True)
    return pierced[~half[pierced] | np.isin(quadrangle[pierced], found[times > 1])]


def _joined(key: np.ndarray) -> np.ndarray:
    """Which group each facet is of, (f,), that are joined by equal keys of their sides, (3 f,)."""
    count = len(key) // 3
    pairs = np.repeat(np.arange(count), 3), count + key
    joined = csr_array((np.ones(len(key)), pairs), shape=(count + int(key.max()) + 1,) * 2)
    return np.asarray(connected_components(joined, directed=False)[1][:count])


def crossed_rings(bag: Bag, positions: np.ndarray, touching: float) -> list[int]:
    """Rows whose rings, seen along the axis and joined in the order in which they were built, cross themselves."""
    net = bag.net
    turn = np.exp(2j * np.pi * np.arange(net.order) / net.order)
    found = []
    for row in range(int(bag.node_row.max())):
        ring = np.flatnonzero(bag.node_row == row)
        built, solved = (
            (turn[:, None] * (shape[ring, 1] + 1j * shape[ring, 2])).ravel() for shape in (net.positions, positions)
        )
        a = solved[np.argsort(np.angle(built))]
        b = np.roll(a, -1)

        def off(p: np.ndarray, q: np.ndarray, r: np.ndarray) -> np.ndarray:
            size = np.maximum(np.abs(q - p), 1e-300)
            return np.asarray(((q - p).conj()[:, None] * (r[None] - p[:, None])).imag / size[:, None])

        aside, bside = off(a, b, a), off(a, b, b)
        apart = (aside * bside < 0.0) & (np.minimum(np.abs(aside), np.abs(bside)) > touching)
        if np.any(apart & apart.T):
            found.append(row)
    return found


def fault(result: CaseResult) -> str:
    """How a converged net passes through itself, or what is impossible about its catch; empty if nothing is."""
    net, measures = result.problem.net, result.measures
    if not measures.catch_volume_m3 > 0.0 or measures.front_from_codline_m < 0.0 or measures.folded_share > 0.5:
        return "impossible catch"
    if np.any(result.bar_tension_n[~net.bar_is_strut] < 0.0):
        return "compression"
    shortest, thick = float(net.bar_length.min()), float(np.median(net.bar_diameter))
    if piercing_bars(net, result.positions, TOUCHING * shortest).size and not result.followed.folds:
        return "layers lie on each other, and the row does not say so"
    touching = max(TOUCHING * shortest, min(thick, DEEPEST * shortest))
    through = pierced_however_divided if result.followed.folds else piercing_bars
    found, rings = through(net, result.positions, touching), crossed_rings(result.bag, result.positions, touching)
    return f"pierced in {len(found)} places, rings {rings} cross" if len(found) or rings else ""


@click.command()
@click.option("--plans", default=300, show_default=True)
@click.option("--seed", default=0, show_default=True, help="Of the first plan.")
@click.option("--rigid-every", default=30, show_default=True)
@click.option("--knots-push", is_flag=True, help="Knots resist compression; plans without knots are left out.")
def main(plans: int, seed: int, rigid_every: int, knots_push: bool) -> None:
    """Solve the plans by every method and fidelity, and print the table."""
    counts: dict[tuple[str, str], Counter[str]] = {model: Counter() for model in MODELS}
    spent = dict.fromkeys(MODELS, 0.0)
    wrong = []
    for number in range(seed, seed + plans):
        if knots_push and random_plan(number, "sector", "auto").netting[0].knot_m == 0.0:
            continue
        for model in MODELS:
            if model == ("full", "rigid-bars") and number % rigid_every:
                continue
            began = perf_counter()
            result = solved(number, *model, knots_push)
            spent[model] += perf_counter() - began
            if result is None:
                counts[model]["not taken"] += 1
                continue
            outcome = result.report.outcome
            counts[model]["converged" if result.converged else "refused" if outcome.refused else "failed"] += 1
            if result.converged and (seen := fault(result)):
                wrong.append(f"plan {number}, {' '.join(model)}: {seen}")
                print(wrong[-1], flush=True)
    columns = ("converged", "refused", "failed", "not taken")
    print(f"{'fidelity':12}{'method':20}" + "".join(f"{name:>11}" for name in columns) + f"{'s':>9}")
    for model, count in counts.items():
        print(
            f"{model[0]:12}{model[1]:20}" + "".join(f"{count[name]:11d}" for name in columns) + f"{spent[model]:9.0f}"
        )
    print(f"{len(wrong)} converged nets pass through themselves or hold an impossible catch")
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
