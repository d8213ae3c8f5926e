"""Bars of a scene while its net is written: ropes first, then netting, each with its own law and sizes."""

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from codend.mechanics.drag_laws import drag
from codend.net.net import Floats, Ints, Net
from codend.scenes.netting_tables import SheetTable
from codend.scenes.tables import RopeTable

Counts = NDArray[np.int64]
_COLUMNS = (
    "length",
    "flexibility",
    "drag_diameter",
    "solid_diameter",
    "density",
    "diameter",
    "drag_law",
    "normal_drag",
    "tangential_drag",
    "is_rope",
)
_OTHERS = ("added_mass", "sheet", "lines")


class BarTable:
    """Ends of bars and, a column each, what a ``Net`` keeps of them, added mass, sheet and real bars side by side."""

    def __init__(self) -> None:
        self._ends: list[Counts] = []
        self._columns: dict[str, list[Floats]] = {name: [] for name in (*_COLUMNS, *_OTHERS)}

    @property
    def count(self) -> int:
        """Bars so far."""
        return sum(map(len, self._ends))

    @property
    def added_mass(self) -> Floats:
        """Cm of every bar, (m,)."""
        return np.concatenate(self._columns["added_mass"])

    @property
    def sheet(self) -> Counts:
        """Number of the sheet a bar is of, -1 of ropes, (m,)."""
        return np.concatenate(self._columns["sheet"]).astype(np.int64)

    @property
    def lines(self) -> Floats:
        """Real bars side by side that a bar stands for, (m,)."""
        return np.concatenate(self._columns["lines"])

    def _add(self, ends: Counts, **columns: ArrayLike) -> None:
        self._ends.append(ends)
        for name, values in columns.items():
            self._columns[name].append(np.array(np.broadcast_to(np.asarray(values, dtype=float), (len(ends),))))

    def add_rope(self, rope: RopeTable, ends: Counts) -> None:
        """Add the bars of a rope, (b, 2)."""
        diameter = 0.001 * rope.diameter_mm
        law, normal, tangential = drag(*rope.drag)
        self._add(
            ends,
            length=rope.length_m / len(ends),
            flexibility=0.0 if rope.axial_stiffness_n is None else 1.0 / rope.axial_stiffness_n,
            drag_diameter=diameter,
            solid_diameter=diameter,
            density=rope.mass_kg_m / (0.25 * np.pi * diameter**2),
            diameter=diameter,
            drag_law=law,
            normal_drag=normal,
            tangential_drag=tangential,
            is_rope=1.0,
            added_mass=rope.added_mass,
            sheet=-1,
            lines=1.0,
        )

    def add_sheet(self, table: SheetTable, number: int, nodes: Counts, speed_share: float) -> None:
        """Add the bars of a sheet whose knots are ``nodes``, (k,), in water at a share of the current's speed.

        Drag, which goes as the square of the speed, is that of bars thinner by the square of the share.
        """
        sheet, twine, lines = table.sheet, table.twine, table.lines
        law, normal, tangential = drag(*table.drag)
        softness = 0.0 if twine.axial_stiffness_n is None else 1.0 / twine.axial_stiffness_n
        self._add(
            nodes[sheet.bars],
            length=table.globalisation * twine.bar_m,
            flexibility=softness / lines,
            drag_diameter=speed_share**2 * lines * twine.drag_width_m,
            solid_diameter=np.sqrt(lines) * twine.solid_diameter_m,
            density=np.nan if twine.density_kg_m3 is None else twine.density_kg_m3,
            diameter=twine.twine_m,
            drag_law=law,
            normal_drag=normal,
            tangential_drag=tangential,
            is_rope=0.0,
            added_mass=table.added_mass,
            sheet=number,
            lines=lines,
        )

    def net(self, place: Counts, positions: Floats, held: NDArray[np.bool_], facets: Ints, weight: Floats) -> Net:
        """The net of all bars but those that join a node to itself; the columns are then those of its bars.

        Args:
            place: node of every end, (n',).
            positions: of the nodes, (n, 3).
            held: coordinates that are held, (n, 3).
            facets: corners of triangles, (f, 3), of which those with no area are left out.
            weight: of these, (f,).
        """
        ends = place[np.concatenate(self._ends)]
        kept = self._kept(ends)
        self._ends = [ends[kept]]
        self._columns = {name: [np.concatenate(parts)[kept]] for name, parts in self._columns.items()}
        whole = (facets[:, 0] != facets[:, 1]) & (facets[:, 1] != facets[:, 2]) & (facets[:, 2] != facets[:, 0])
        net = Net.from_bars(positions, ends[kept], held, facets=facets[whole])
        columns: dict[str, Any] = {}
        for name in _COLUMNS:
            field = f"bar_{name}"
            columns[field] = self._columns[name][0].astype(getattr(net, field).dtype)
        return replace(net, facet_weight=weight[whole], **columns)

    def _kept(self, ends: Counts) -> NDArray[np.bool_]:
        """Bars that join two nodes; of equal ones of netting between the same two one is kept, for both, (m,)."""
        kept = ends[:, 0] != ends[:, 1]
        column = {name: np.concatenate(parts) for name, parts in self._columns.items()}
        of_netting = np.flatnonzero(kept & (column["sheet"] >= 0.0))
        same = ("length", "density", "diameter", "drag_law", "normal_drag", "tangential_drag", "added_mass")
        keys = np.column_stack(
            [np.sort(ends[of_netting], axis=1), *(np.nan_to_num(column[n][of_netting]) for n in same)]
        )
        _, first, group = np.unique(keys, axis=0, return_index=True, return_inverse=True)
        group = group.ravel()
        if len(first) == len(of_netting):
            return np.asarray(kept)
        gives = column["flexibility"][of_netting] > 0.0
        stiffness = np.divide(1.0, column["flexibility"][of_netting], out=np.zeros(len(gives)), where=gives)
        rigid = np.bincount(group, ~gives) > 0.0
        summed = {
            "flexibility": np.where(rigid, 0.0, 1.0 / np.maximum(np.bincount(group, stiffness), 1e-300)),
            "drag_diameter": np.bincount(group, column["drag_diameter"][of_netting]),
            "solid_diameter": np.sqrt(np.bincount(group, column["solid_diameter"][of_netting] ** 2)),
            "lines": np.bincount(group, column["lines"][of_netting]),
        }
        for name, values in summed.items():
            column[name][of_netting[first]] = values
            self._columns[name] = [column[name]]
        kept[of_netting] = False
        kept[of_netting[first]] = True
        return np.asarray(kept)
