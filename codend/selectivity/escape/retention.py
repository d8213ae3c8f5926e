"""Retention by length of fish that meet the meshes ahead of a catch.

A fish of the species tries meshes with probability C (contact), then n times (attempts), every time a mesh drawn from
those ahead of the front and a rotation drawn about its best one. Fish of one length differ in size, a factor e^(s z) on
the whole section, and in shape, e^(t y / 2) on the height and e^(-t y / 2) on the width, with z, y standard normal.

For a fish of mean size and shape y, mesh and rotation k lets lengths up to G_k through. A fish of length L and size z
is let through by k when L e^(s z) <= G_k (one that is larger than others of its length pushes as those of the length it
is as large as); with p the probability of all such k it escapes with probability
E = 1 - (1 - p)^n. With the G_k in falling order p, and with it E, rises in steps dE_k at L e^(s z) = G_k, so that the
mean over sizes is a sum of normal distribution functions and no quadrature at all:

    r(L) = 1 - C sum over y and k of w_y dE_k Phi((ln G_k - ln L) / s).

Where fish try. A mesh is drawn by its place: evenly over the rows a species names, or by the distribution over the
distance from the front that it gives (``along``). Meshes of one row share what falls on it. A shut mesh takes no
attempts from open ones: one whose clear width is below a tenth of that of the widest which is tried takes none, from a
quarter on all that fall to its place, and in proportion between. Zones that a species gives (a window, an extension
fish pass on their way) have a contact C_z and attempts n_z of their own, in all their meshes ahead of the front, and
take nothing from the rest: E = 1 - product over zones of (1 - C_z (1 - (1 - p_z)^(n_z))), with C above among them.

Over shapes and rotations the mean is taken by quadrature. A haul is the mean of such sums.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import ndtri

from catch_models.fish import PARAMETERS
from codend.selectivity.escape.crowd_kernels import Crowd, Nodes, Trying, ideals_of, tables_of
from codend.selectivity.escape.penetration import Holes
from codend.selectivity.escape.retention_kernels import (
    Passages,
    add_terms,
    ln_length_at,
    passages_of,
    retained_at,
)

Floats = NDArray[np.float64]

SHAPES, ROTATIONS, STEPS = 5, 12, 14
"""Nodes of the quadratures over shapes and rotations, and steps of refinement of orientation and opening."""
OF_HOLES = tuple(field.name for field in fields(Holes))
"""What a crowd has of its meshes, in the order of ``Crowd``."""
_SIZE, _ROWS_AHEAD = PARAMETERS.index("spread.size"), PARAMETERS.index("behaviour.rows_ahead")


@dataclass(frozen=True)
class EscapeTerms:
    """Escape as a sum of normal distribution functions of ln L: the terms of the formula above."""

    ln_length: Floats
    """ln G of every term, G in metres, (j,)."""
    escape: Floats
    """C w dE of every term, (j,); they add to the escape of the smallest fish."""
    spread: float
    """Standard deviation s."""

    def retention(self, length_cm: ArrayLike) -> Floats:
        """Retention at lengths in cm, any shape."""
        length = np.asarray(length_cm, dtype=float)
        retained = np.empty(length.size)
        retained_at(self.ln_length, self.escape, self.spread, np.log(0.01 * length.ravel()), retained)
        return retained.reshape(length.shape)

    def length_cm_at(self, retention: float) -> float:
        """Length retained with the given probability, cm; nan where even the smallest fish are retained more often."""
        return 100.0 * float(np.exp(ln_length_at(self.ln_length, self.escape, self.spread, retention)))

    def l50_sr(self) -> tuple[float, float]:
        """L50 and SR = L75 - L25, cm, as the curve itself has them."""
        l25, l50, l75 = (self.length_cm_at(retention) for retention in (0.25, 0.5, 0.75))
        return l50, l75 - l25


def crowd_of(catches: list[tuple[Holes, Floats, Floats]], part: NDArray[np.int64] | None = None) -> Crowd:
    """Meshes, distances from the front in rows, and shares in their rows, of every catch, strung together.

    ``part`` numbers the parts of the codend that they lie in, (k,); left out, all are of one.
    """
    holes = [catch[0] for catch in catches]

    def strung(name: str) -> NDArray:
        return np.concatenate([getattr(one, name) for one in holes])

    _, netting = np.unique([strung(name) for name in ("shape", "bar_m", "knot_m")], axis=1, return_inverse=True)
    arrays = [
        np.concatenate([[0], np.cumsum([len(one.shape) for one in holes])]),
        *(strung(name) for name in OF_HOLES),
        *(np.concatenate([catch[i] for catch in catches]) for i in (1, 2)),
        np.asarray(netting, dtype=np.int64),
        np.zeros(len(netting), dtype=np.int64) if part is None else part,
    ]
    return Crowd(*arrays)


def everywhere_alike(parts: int = 1) -> Trying:
    """Fish that try as their species' numbers say in every part of the codend."""
    none = np.empty(0)
    return Trying(np.zeros(parts, dtype=np.int64), np.zeros(1), np.zeros(1), none, none)


def nodes_of(shapes: int = SHAPES, rotations: int = ROTATIONS, steps: int = STEPS, openings: int = 0) -> Nodes:
    """Quadrature over standard normal variables: Gauss and Hermite's for shapes, equal strata for rotations.

    What a rotation does has a kink at the best one, and the power of the attempts dwells on the extremes: strata, each
    at the quantile of its middle, are within 0.2 % in L50 and 2 % in SR with 12, where Gauss and Hermite's rule is
    within 0.6 % and 5 %. An even number keeps off the kink.
    """
    shape, weight = np.polynomial.hermite_e.hermegauss(shapes)
    rotation = ndtri((np.arange(rotations) + 0.5) / rotations)
    return Nodes(shape, weight / weight.sum(), rotation, np.full(rotations, 1.0 / rotations), steps, openings)


def escape_terms(
    crowd: Crowd,
    values: Floats,
    nodes: Nodes | None = None,
    trying: Trying | None = None,
) -> list[EscapeTerms]:
    """Terms of the retention curve of every catch.

    Args:
        crowd: meshes of all catches.
        values: of ``catch_models.fish.PARAMETERS``, (15,).
        nodes: quadrature; ``nodes_of()`` when left out.
        trying: where fish try; everywhere alike when left out.

    Returns:
        Terms; none of a catch that no mesh lies ahead of, so that nothing escapes.
    """
    nodes = nodes or nodes_of()
    trying = trying or everywhere_alike(int(crowd.part.max(initial=0)) + 1)
    tables = tables_of(crowd, values, nodes)
    ideals = ideals_of(crowd, values, nodes, tables)
    found = []
    for catch, meshes in enumerate(np.diff(crowd.start)):
        most = (len(nodes.shape), int(meshes) * len(nodes.rotation))
        passages = Passages(np.empty(most), *np.empty((2, *most), dtype=np.int64))
        ways = passages_of(crowd, catch, values, nodes, values[_ROWS_AHEAD], trying, ideals, tables, passages)
        ln_length, escape = np.empty((2, most[0] * most[1]))
        count = add_terms(crowd, catch, values, nodes, trying, passages, ways, ln_length, escape)
        found.append(EscapeTerms(ln_length[:count], escape[:count], float(values[_SIZE])))
    return found
