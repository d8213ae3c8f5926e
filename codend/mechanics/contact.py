"""Contact without friction between parts of a net's surface: force, tangent and bound, kernels.

Parts nearer to each other than a distance D are pushed apart by the barrier b(d) = -k (d - D)^2 ln(d / D) of their
distance d, which rises without bound as they touch (incremental potential contact: Li et al. 2020, ACM Trans. Graph.
39(4), 49, equation 6, here of the distance and not of its square). Parts are nodes and triangles, and edges and edges;
of these, pairs that are nearly parallel count less and less (their equations 24 to 26), since their nearest points
leap, and the nodes at their ends bear the contact then.

With D = |r|^2, r = sum of w_i(t) x_i least over the places t along the parts, and J_k = dr / dt_k, the derivatives are
dD/dx_i = 2 w_i r and, for the places follow the nodes, D_xx - D_xt D_tt^-1 D_tx with D_xi,xj = 2 w_i w_j, D_tk,tl =
2 J_k . J_l and D_xi,tk = 2 (w_i J_k + r dw_i / dt_k).

Pairs in a sector stand for all their images; each is named once, with the images its nodes sit in.
"""

from typing import NamedTuple

import numpy as np

from codend.compiled import njit
from codend.mechanics.images import add_turned_back, turned
from codend.mechanics.nearest import Nearest, nearest
from codend.mechanics.tangent import Pattern, add_turned_block
from codend.net.net import Floats, Ints

PARALLEL = 1e-3
"""Square of the sine of the angle between two edges as long as they were built below which they count less."""


class Contact(NamedTuple):
    """Parts of a net near each other."""

    node: Ints
    """A node and the corners of a triangle, or the ends of two edges, (k, 4)."""
    image: Ints
    """Images these sit in, (k, 4)."""
    kind: Ints
    """``nearest.NODE_TRIANGLE`` or ``EDGE_EDGE``, (k,)."""
    weight: Floats
    """1/2 where the pair of all images is named twice over, (k,)."""
    even: Floats
    """c0 of ``turned_apart``, m4, (k,); 0 of nodes and triangles."""
    distance: float
    """D, at which contact begins, m."""
    stiffness: float
    """k, N/m: parts at half of D press on each other with 1.2 k D."""
    rotations: Floats
    """Cosine and sine for the images -K .. K, (2 K + 1, 2)."""
    exact: float = 1.0
    """Share in the tangent of what is negative definite of a pair: at 1 it is the force's own, at 0 it keeps a net's
    pivots positive where that is far from balance."""


def no_contact() -> Contact:
    """Nothing near anything."""
    empty = np.zeros((0, 4), dtype=np.int32)
    return Contact(
        empty, empty, np.zeros(0, dtype=np.int32), np.zeros(0), np.zeros(0), 0.0, 0.0, np.array([[1.0, 0.0]])
    )


@njit(cache=True)
def write_corners(position: Floats, node: Ints, image: Ints, rotations: Floats, pair: int, corner: Floats) -> None:
    """Write where the nodes of a pair are, (4, 3)."""
    for i in range(4):
        place = node[pair, i]
        corner[i, 0] = position[place, 0]
        corner[i, 1], corner[i, 2] = turned(position[place, 1], position[place, 2], image[pair, i], rotations)


@njit(cache=True)
def room() -> Nearest:
    """Room for one pair."""
    return Nearest(np.zeros((4, 3)), np.zeros(4), np.zeros((2, 4)), np.zeros(3))


@njit(cache=True, error_model="numpy")
def barrier(contact: Contact, pair: int, square: float) -> tuple[float, float, float]:
    """Energy of a pair at the square of a distance, J, and its first two derivatives by that."""
    start = contact.distance
    d = np.sqrt(square)
    if d >= start:
        return 0.0, 0.0, 0.0
    k, gap, log = contact.stiffness * contact.weight[pair], d - start, np.log(d / start)
    first = -k * (2.0 * gap * log + gap * gap / d)
    second = -k * (2.0 * log + 4.0 * gap / d - gap * gap / square)
    return -k * gap * gap * log, first / (2.0 * d), (second - first / d) / (4.0 * square)


@njit(cache=True, error_model="numpy")
def turned_apart(corner: Floats, even: float, first: Floats, second: Floats) -> tuple[float, float, float]:
    """How much a pair of edges u and v counts, m(c) = (2 - c / c0) c / c0 up to c0 = ``even`` and 1 beyond.

    c = |u x v|^2 = |u|^2 |v|^2 - (u.v)^2, whose derivatives by u and v are written, (2, 3) and (2, 3, 2, 3).

    Returns:
        m and its first two derivatives by c.
    """
    uu, uv, vv = 0.0, 0.0, 0.0
    for i in range(3):
        u, v = corner[1, i] - corner[0, i], corner[3, i] - corner[2, i]
        uu, uv, vv = uu + u * u, uv + u * v, vv + v * v
    share = (uu * vv - uv * uv) / even if even > 0.0 else 1.0
    if share >= 1.0:
        return 1.0, 0.0, 0.0
    for i in range(3):
        ui, vi = corner[1, i] - corner[0, i], corner[3, i] - corner[2, i]
        first[0, i], first[1, i] = 2.0 * (vv * ui - uv * vi), 2.0 * (uu * vi - uv * ui)
        for j in range(3):
            uj, vj = corner[1, j] - corner[0, j], corner[3, j] - corner[2, j]
            one = 1.0 if i == j else 0.0
            second[0, i, 0, j] = 2.0 * (vv * one - vi * vj)
            second[1, i, 1, j] = 2.0 * (uu * one - ui * uj)
            second[0, i, 1, j] = 4.0 * ui * vj - 2.0 * vi * uj - 2.0 * uv * one
            second[1, j, 0, i] = second[0, i, 1, j]
    return (2.0 - share) * share, (2.0 - 2.0 * share) / even, -2.0 / (even * even)


@njit(cache=True, error_model="numpy")
def side_of(node: int) -> tuple[int, float]:
    """Which edge of a pair a node ends, and the sign with which its place enters there."""
    return node // 2, -1.0 if node % 2 == 0 else 1.0


@njit(cache=True, error_model="numpy")
def add_force(position: Floats, contact: Contact, force: Floats) -> None:
    """Add the push of contact to the nodal forces, N."""
    found, first, second = room(), np.zeros((2, 3)), np.zeros((2, 3, 2, 3))
    for pair in range(len(contact.kind)):
        write_corners(position, contact.node, contact.image, contact.rotations, pair, found.corner)
        _, square = nearest(contact.kind[pair], found)
        energy, slope, _ = barrier(contact, pair, square)
        if slope == 0.0:
            continue
        counts, by_c, _ = turned_apart(found.corner, contact.even[pair], first, second)
        push = -2.0 * counts * slope
        for i in range(4):
            factor = push * found.weight[i]
            x, y, z = factor * found.apart[0], factor * found.apart[1], factor * found.apart[2]
            if by_c != 0.0:
                edge, sign = side_of(i)
                turn = -sign * by_c * energy
                x, y, z = x + turn * first[edge, 0], y + turn * first[edge, 1], z + turn * first[edge, 2]
            image = contact.image[pair, i]
            add_turned_back(force, contact.node[pair, i], x, y, z, image, contact.rotations)


@njit(cache=True, error_model="numpy")
def add_tangent(position: Floats, contact: Contact, pattern: Pattern, blocks: Floats) -> None:
    """Add the part of contact to the tangent, with the share ``exact`` of what is negative definite of each pair."""
    found, first, second = room(), np.zeros((2, 3)), np.zeros((2, 3, 2, 3))
    h, by_place, lines, inverse = np.zeros((3, 3)), np.zeros((2, 4, 3)), np.zeros((2, 3)), np.zeros((2, 2))
    whole = np.zeros((12, 12))
    for pair in range(len(contact.kind)):
        write_corners(position, contact.node, contact.image, contact.rotations, pair, found.corner)
        free, square = nearest(contact.kind[pair], found)
        energy, slope, curve = barrier(contact, pair, square)
        if slope == 0.0:
            continue
        counts, by_c, bend = turned_apart(found.corner, contact.even[pair], first, second)
        weight, apart = found.weight, found.apart
        _places(found, free, lines, by_place, inverse)
        for i in range(4):
            edge_i, sign_i = side_of(i)
            for j in range(4):
                edge_j, sign_j = side_of(j)
                for a in range(3):
                    gi = 2.0 * weight[i] * apart[a]
                    for b in range(3):
                        gj = 2.0 * weight[j] * apart[b]
                        bent = 2.0 * weight[i] * weight[j] if a == b else 0.0
                        for k in range(free):
                            for m in range(free):
                                bent -= by_place[k, i, a] * inverse[k, m] * by_place[m, j, b]
                        value = counts * (curve * gi * gj + slope * bent)
                        if by_c != 0.0:
                            ci, cj = sign_i * first[edge_i, a], sign_j * first[edge_j, b]
                            cij = sign_i * sign_j * second[edge_i, a, edge_j, b]
                            value += energy * (bend * ci * cj + by_c * cij) + by_c * slope * (ci * gj + gi * cj)
                        whole[3 * i + a, 3 * j + b] = value
        if contact.exact < 1.0:
            _take_negative(whole, 1.0 - contact.exact)
        for i in range(4):
            for j in range(4):
                for a in range(3):
                    for b in range(3):
                        h[a, b] = whole[3 * i + a, 3 * j + b]
                row, column = contact.image[pair, i], contact.image[pair, j]
                add_turned_block(blocks, pattern.contact_slot[pair, i, j], 1.0, h, row, column, contact.rotations)


@njit(cache=True, error_model="numpy")
def _take_negative(matrix: Floats, share: float) -> None:
    """Take from a symmetric matrix a share of what is negative definite in it."""
    values, vectors = np.linalg.eigh(matrix)
    for k in range(len(values)):
        if values[k] >= 0.0:
            break
        for i in range(len(values)):
            for j in range(len(values)):
                matrix[i, j] -= share * values[k] * vectors[i, k] * vectors[j, k]


@njit(cache=True, error_model="numpy")
def _places(found: Nearest, free: int, lines: Floats, by_place: Floats, inverse: Floats) -> None:
    """Write J_k, D_xi,tk and the inverse of D_tk,tl of the places that are free."""
    weight, slope, apart, corner = found.weight, found.slope, found.apart, found.corner
    for k in range(free):
        for a in range(3):
            lines[k, a] = 0.0
            for i in range(4):
                lines[k, a] += slope[k, i] * corner[i, a]
        for i in range(4):
            for a in range(3):
                by_place[k, i, a] = 2.0 * (weight[i] * lines[k, a] + apart[a] * slope[k, i])
    uu, uv, vv = 0.0, 0.0, 0.0
    for a in range(3):
        uu, uv, vv = uu + lines[0, a] ** 2, uv + lines[0, a] * lines[1, a], vv + lines[1, a] ** 2
    if free == 1:
        inverse[0, 0] = 0.5 / uu
    elif free == 2:
        area = 2.0 * (uu * vv - uv * uv)
        inverse[0, 0], inverse[0, 1], inverse[1, 0], inverse[1, 1] = vv / area, -uv / area, -uv / area, uu / area


@njit(cache=True, error_model="numpy")
def add_bound(position: Floats, contact: Contact, bound: Floats) -> None:
    """Add contact's part to the bound on each node's row of the stiffness, N/m, as near as the parts are now."""
    found = room()
    for pair in range(len(contact.kind)):
        write_corners(position, contact.node, contact.image, contact.rotations, pair, found.corner)
        _, square = nearest(contact.kind[pair], found)
        _, slope, curve = barrier(contact, pair, square)
        stiffness = 4.0 * curve * square + 2.0 * abs(slope)
        for i in range(4):
            bound[contact.node[pair, i]] += 2.0 * stiffness * abs(found.weight[i])
