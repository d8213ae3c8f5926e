"""A net under loads: what a solver is given, and all it knows."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from codend.mechanics.body import Body
from codend.mechanics.contact import no_contact
from codend.mechanics.inertia import at_rest
from codend.mechanics.loads import Loading
from codend.mechanics.points import points_of
from codend.mechanics.pressure import FILLED_MESHES, Catch
from codend.mechanics.rings import Rings, rings_of
from codend.mechanics.seabed import Seabed, no_seabed
from codend.mechanics.sheet import Sheet
from codend.mechanics.structure import Structure, structure_of
from codend.mechanics.surface import ContactLaw, Surface
from codend.mechanics.tube import Tube, tube_of
from codend.mechanics.water import Water, uniform_flow
from codend.mechanics.weight import wet_weight
from codend.net.net import Floats, Net


@dataclass(frozen=True)
class Problem:
    """A net, the same net as the kernels see it, and what acts on it."""

    net: Net
    structure: Structure
    loading: Loading
    rings: Rings
    """Rings of knots in the order in which the net was built, wherever it starts."""
    tube: Tube
    """The one that its facets make, ``tube.NO_TUBE`` where they make none."""
    surface: Surface | None = None
    """What nothing may pass through; None where contact is left out."""
    body: Body | None = None
    """A rigid body that floats, whose nodes the net has as held; None where all that is held stays where it is."""

    @property
    def bands(self) -> int:
        """Bands of the net that a catch may fill."""
        return len(self.loading.catch.band_meshes)

    def touching_at(self, position: Floats) -> "Problem":
        """The problem with what is near what in a shape; itself where it has no contact."""
        if self.surface is None:
            return self
        return replace(self, loading=self.loading._replace(contact=self.surface.near(position)))

    def touching_by(self, law: ContactLaw, sheet: Sheet | None = None) -> "Problem":
        """The problem with contact by a law, of which nothing acts yet.

        ``sheet`` is the surface as it was divided into triangles where the net was built: by where it has been moved to
        since, other diagonals may be the longer ones.
        """
        return replace(self, surface=Surface.of(self.net, law) if sheet is None else Surface(sheet, law))

    def cannot_strain(self, positions: Floats) -> NDArray[np.bool_]:
        """Bars that no move of what is free makes longer, held lengthwise at both ends, (m,)."""
        net = self.net
        along = positions[net.bars[:, 1]] - positions[net.bars[:, 0]]
        free = ~net.fixed[net.bars].all(axis=1)
        return np.asarray((net.bar_image == 0) & (np.abs(along * free).max(axis=1) <= 1e-9 * net.bar_length))

    @classmethod
    def of(
        cls,
        net: Net,
        *,
        nodal_force_n: Floats | None = None,
        water: Water | None = None,
        weight: bool = True,
        catch: Catch | None = None,
        seabed: Seabed | None = None,
        contact: ContactLaw | None = None,
        body: Body | None = None,
    ) -> "Problem":
        """A net under its own loads.

        Args:
            net: the net.
            nodal_force_n: forces that are the same wherever the nodes go, (n, 3); none by default.
            water: the water and its flow, see ``uniform_flow``; sea water at rest by default.
            weight: whether bars and points have their weight in water.
            catch: what presses on the facets; nothing by default.
            seabed: what carries the nodes that lie on it; none by default.
            contact: how facets and bars of the net press on each other, without friction; not at all by default.
            body: a rigid body afloat; none by default.
        """
        water = uniform_flow(SEA_WATER_KG_M3, np.zeros(3)) if water is None else water
        dead = wet_weight(net, water.density) if weight else np.zeros_like(net.positions)
        if nodal_force_n is not None:
            dead = dead + nodal_force_n
        catch = no_catch(net) if catch is None else catch
        seabed = no_seabed() if seabed is None else seabed
        loading = Loading(dead, water, points_of(net), catch, seabed, no_contact(), at_rest())
        rings = rings_of(net.positions, loading.catch.node_row, net.order)
        surface = None if contact is None else Surface.of(net, contact)
        return cls(net, structure_of(net), loading, rings, tube_of(net), surface, body)


SEA_WATER_KG_M3 = 1025.0


def no_catch(net: Net) -> Catch:
    """A catch that fills nothing: the net is one band, empty."""
    return Catch(
        bar_band=np.zeros(len(net.bars), dtype=np.int32),
        facet_band=np.zeros(len(net.facets), dtype=np.int32),
        band_meshes=np.ones(1),
        node_row=np.full(len(net.positions), -1, dtype=np.int32),
        row_size=np.zeros(2),
        kind=FILLED_MESHES,
        size=0.0,
        stagnation_pressure=0.0,
        angles=np.array([0.0, np.pi]),
        coefficients=np.zeros((4, 1)),
    )
