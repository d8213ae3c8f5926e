"""The yielding mesh of the selectivity against a solved net in which the mesh is really pulled open.

Codends of assumed sizes, limp and stiff, knotted and turned, of twine that stretches more and less: a mesh some rows
ahead of the catch is pulled open by a little and by much with ``codend.pull_mesh``, its neighbours and all, and the
force set beside what the selectivity takes: that of a mesh alone, and that times what its neighbours hold.

Run as ``python -m validation.yielding_meshes``.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import click
import numpy as np

import codend
from codend.plan.plan import Plan, plan_from_dict
from codend.selectivity.escape.catches import catches_of, run_of
from codend.selectivity.escape.penetration import hole_of
from codend.selectivity.escape.yielding_kernels import force_to

WIDER_DEG = (5.0, 15.0, 30.0)
ROW_AHEAD = 6
NETTINGS: dict[str, dict[str, object]] = {
    "limp, EA 500 N": {"axial_stiffness_n": 500.0},
    "limp, EA 2000 N": {"axial_stiffness_n": 2000.0},
    "EI 1e-4 N m2, EA 1000 N": {"axial_stiffness_n": 1000.0, "bending_stiffness_n_m2": 1e-4},
    "EI 1e-3 N m2, EA 1000 N": {"axial_stiffness_n": 1000.0, "bending_stiffness_n_m2": 1e-3},
    "knots of 10 mm, EA 1000 N": {"axial_stiffness_n": 1000.0, "knot_mm": 10.0},
    "T90, knots of 10 mm, EA 1000 N": {"axial_stiffness_n": 1000.0, "knot_mm": 10.0, "mesh": "t90"},
    "T90, the same, EI 1e-4 N m2": {
        "axial_stiffness_n": 1000.0,
        "knot_mm": 10.0,
        "mesh": "t90",
        "bending_stiffness_n_m2": 1e-4,
        "rest_opening_deg": 160.0,
    },
}


@dataclass(frozen=True)
class Pulled:
    """One mesh pulled open by some degrees, forces in N."""

    netting: str
    opening_deg: float
    wanted_deg: float
    alone_n: float
    held: float
    in_net_n: float
    error_n: float

    @property
    def ratio(self) -> float:
        """Force the selectivity takes over that of the solved net."""
        return self.alone_n * self.held / self.in_net_n


def plan_of(netting: dict[str, object], filled_meshes: float = 10.0) -> Plan:
    """A codend of 60 x 40 meshes of 45 mm bars."""
    section = {"mesh": "diamond", "meshes_round": 60, "meshes_long": 40, "bar_mm": 45.0, "twine_mm": 4.0} | netting
    return plan_from_dict(
        {
            "title": "yielding meshes",
            "tow": {"speed_m_s": 1.5, "water_density_kg_m3": 1025.0},
            "entry": {"radius_m": 0.35},
            "netting": [section],
            "catch": {"filled_meshes": [filled_meshes]},
        }
    )


def pulls(name: str, wider_deg: tuple[float, ...] = WIDER_DEG, filled_meshes: float = 10.0) -> Iterator[Pulled]:
    """Pulls of one netting."""
    plan = plan_of(NETTINGS[name], filled_meshes)
    study = codend.solve(plan)
    (catch,) = catches_of(run_of(study), 15.0)
    mesh = int(np.argmin(np.abs(catch.rows_ahead - ROW_AHEAD)))
    hole, computed = hole_of(catch.holes, mesh), float(catch.holes.half_angle_rad[mesh])
    place = plan.netting[0].meshes_long - filled_meshes - 0.5 * catch.rows_ahead[mesh]
    for wider in wider_deg:
        opening = float(np.degrees(2.0 * computed))
        found = codend.pull_mesh(plan, plan.cases()[0], place, opening + wider)
        force = force_to(hole, computed, computed + np.radians(wider) / 2.0)
        alone, held = force / hole.held_across, hole.held_across
        in_net, error = found.opening_force_in_net_n, found.opening_force_in_net_error_n
        yield Pulled(name, opening, opening + wider, alone, held, in_net, error)


@click.command(help=__doc__)
def main() -> None:
    """Print the table."""
    heads = f"{'netting':32s} {'opening':>8s} {'to':>6s} {'alone N':>8s} {'H':>6s} {'N':>8s} {'in net N':>14s} ratio"
    click.echo(heads)
    ratios = []
    for name in NETTINGS:
        for one in pulls(name):
            net = f"{one.in_net_n:.2f} +- {one.error_n:.2f}"
            text = f"{name:32s} {one.opening_deg:8.1f} {one.wanted_deg:6.1f} {one.alone_n:8.2f} {one.held:6.2f}"
            click.echo(f"{text} {one.alone_n * one.held:8.2f} {net:>14s} {one.ratio:5.2f}")
            ratios.append(one.ratio)
    middle = np.exp(np.mean(np.log(ratios)))
    click.echo(f"ratio from {min(ratios):.2f} to {max(ratios):.2f}, geometric mean {middle:.2f}")


if __name__ == "__main__":
    main()
