"""Turning points and forces between the images of a rotational sector, for kernels."""

from codend.compiled import njit
from codend.net.net import Floats


@njit(cache=True)
def turned(y: float, z: float, image: int, rotations: Floats) -> tuple[float, float]:
    """Components (y, z) turned forward by ``image`` sectors."""
    if image == 0:
        return y, z
    row = image + (rotations.shape[0] - 1) // 2
    cosine, sine = rotations[row, 0], rotations[row, 1]
    return cosine * y - sine * z, sine * y + cosine * z


@njit(cache=True)
def add_turned_back(force: Floats, node: int, x: float, y: float, z: float, image: int, rotations: Floats) -> None:
    """Add a force that acts on the image of a node to the node itself."""
    if image != 0:
        row = (rotations.shape[0] - 1) // 2 - image
        cosine, sine = rotations[row, 0], rotations[row, 1]
        y, z = cosine * y - sine * z, sine * y + cosine * z
    force[node, 0] += x
    force[node, 1] += y
    force[node, 2] += z
