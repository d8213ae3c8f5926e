"""A net under loads: what a solver is given, and all it knows."""

from dataclasses import dataclass

from codend.mechanics.arrays import Loading, Structure
from codend.net.net import Net


@dataclass(frozen=True)
class Problem:
    """A net, the same net as the kernels see it, and what acts on it."""

    net: Net
    structure: Structure
    loading: Loading

    @property
    def bands(self) -> int:
        """Bands of the net that a catch may fill."""
        return len(self.loading.catch.band_meshes)
