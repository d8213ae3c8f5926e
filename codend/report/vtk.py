"""Nets as VTK files (``.vtu``) for ParaView: the only module that knows meshio."""

import zlib
from collections.abc import Sequence
from functools import lru_cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np

from codend.bag.bag import all_round
from codend.bag.layer_measures import measure_layers
from codend.equilibrium.folds import contact_pushes
from codend.io.files import whole_file, write_text
from codend.net.net import Floats, Ints
from codend.report.polygons import joined_on_axis, mesh_polygons
from codend.studies.case_result import CaseResult

if TYPE_CHECKING:
    import meshio

COMPRESSION: Final = 1
"""Level of zlib: its own default takes three times as long, for files 3 % smaller."""
REMEMBERED: Final = 512
"""Blocks of 32 kB that are not compressed again: those of some hundred thousand bars and meshes."""
CELL_OF_CORNERS = {3: "triangle", 4: "quad"}
"""VTK cells of meshes by their number of corners; all others are polygons."""


def write_vtu(result: CaseResult, path: Path) -> None:
    """Write the whole net of a solved case, all round, compressed; see ``net_mesh`` for what is in it."""
    _write(net_mesh(result), path)


def write_bars(positions: Floats, bars: Ints, path: Path, **of_bars: Floats) -> None:
    """Write bars, (m, 2), between nodes, (n, 3), as lines with what is told of them, each (m,)."""
    import meshio

    mesh = meshio.Mesh(positions, [("line", bars)], cell_data={name: [values] for name, values in of_bars.items()})
    _write(mesh, path)


def _write(mesh: "meshio.Mesh", path: Path) -> None:
    from meshio.vtu import _vtu

    _vtu.zlib = _Zlib  # meshio asks for the default level, and takes no other
    with whole_file(path) as temporary:
        mesh.write(temporary, file_format="vtu")


class _Zlib:
    """What meshio takes of the module, at a level of our own, and of what was compressed before a copy."""

    # which nodes bars and meshes join is the same in all cases of a run
    compress = staticmethod(lru_cache(REMEMBERED)(partial(zlib.compress, level=COMPRESSION)))
    decompress = staticmethod(zlib.decompress)


def write_series(files: Sequence[str], times_s: Sequence[float], path: Path) -> None:
    """Write the list by which ParaView shows files as one motion."""
    lines = [f'    <DataSet timestep="{t:g}" part="0" file="{file}"/>' for t, file in zip(times_s, files, strict=True)]
    head = '<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1">\n  <Collection>'
    write_text("\n".join([head, *lines, "  </Collection>", "</VTKFile>"]) + "\n", path)


def read_nodes(path: Path) -> Floats:
    """Nodes of a file of ``write_bars``, (n, 3)."""
    import meshio

    nodes: Floats = np.asarray(meshio.read(path).points, dtype=np.float64)
    return nodes


def net_mesh(result: CaseResult) -> "meshio.Mesh":
    """The whole net of a solved case: bars as lines, then meshes as polygons.

    Cell data are those of the real netting: ``tension_n`` (of a bar; of a mesh, the mean of its sides), and of meshes
    ``opening_deg``, ``opening_force_n`` and ``pressure_pa``, which bars do not have (nan). Meshes under a second layer
    have its ``layer_opening_deg``, ``layer_tension_n`` of its bars and ``layer_hoop_share``, those under several the
    last one's. In a net with contact bars have ``contact_push_n``, the larger push of other netting on their ends,
    which meshes do not have.

    Raises:
        ValueError: the case was not solved.
    """
    import meshio

    if result.meshes is None:
        raise ValueError(f"case {result.case.number} was not solved: there is no shape to write")
    net = result.net
    whole = joined_on_axis(all_round(result.bag, result.positions))
    polygons = mesh_polygons(whole)
    of_meshes = {
        "tension_n": result.meshes.bar_tension_n,
        "opening_deg": result.meshes.opening_deg,
        "opening_force_n": result.meshes.opening_force_n,
        "pressure_pa": result.meshes.pressure_pa,
    }
    of_meshes |= _of_layers(result)
    no_value = np.full(len(whole.bars), np.nan)
    cell_data = {
        name: [no_value] + [np.tile(values, net.sectors)[which] for which, _ in polygons]
        for name, values in of_meshes.items()
    }
    cell_data["tension_n"][0] = np.tile(result.bar_tension_n, net.sectors)
    if result.problem.surface is not None:
        push = contact_pushes(result.problem, result.solution)[net.bars].max(axis=1)
        cell_data["contact_push_n"] = [np.tile(push, net.sectors)] + [np.full(len(c), np.nan) for _, c in polygons]
    cells = [("line", whole.bars)]
    cells += [(CELL_OF_CORNERS.get(corners.shape[1], "polygon"), corners) for _, corners in polygons]
    return meshio.Mesh(whole.positions, cells, cell_data=cell_data)


def _of_layers(result: CaseResult) -> dict[str, Floats]:
    """What the layer over every mesh of a sector does; nan where there is none, and nothing without layers."""
    bag, found = result.bag, dict[str, Floats]()
    _, band = bag.mesh_bands
    for rows in measure_layers(bag, result.problem, result.solution):
        of_layer = {"opening_deg": rows.opening_deg, "tension_n": rows.bar_tension_n, "hoop_share": rows.hoop_share}
        for name, values in of_layer.items():
            of_bands = np.full(bag.bands, np.nan)
            of_bands[rows.band.astype(int)] = values
            own = found.setdefault(f"layer_{name}", np.full(len(band), np.nan))
            np.copyto(own, of_bands[band], where=np.isfinite(of_bands[band]))
    return found
