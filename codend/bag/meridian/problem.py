"""What the meridian method is asked and what it answers."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from catch_models.pressure import PressureLaw
from codend.bag.meridian.shell import Shell
from codend.mechanics.drag_laws import DRAG_LAWS
from codend.plan.kinds import KINDS, MeshName
from codend.solvers.outcome import Outcome

Floats = NDArray[np.float64]
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(16)  # here, for they take a millisecond: a tenth of a first guess


@dataclass(frozen=True)
class MeridianProblem:
    """One bag of one kind of netting, the same all round, with its catch; SI units.

    Raises:
        ValueError: a number out of range, a name unknown, or rows too short to reach from the entry to the axis.
    """

    meshes_round: int
    half_mesh_rows: int
    """2 M; rows are counted 0 (entry) to 2 M (codline)."""
    bar_m: float
    entry_radius_m: float
    front_row: float
    """Half-mesh row of the catch's front, from 0 up to but not including ``half_mesh_rows``; need not be whole."""
    stagnation_pressure_pa: float
    """rho V^2 / 2: scales both the catch's pressure and the twine drag."""
    pressure_law: PressureLaw
    mesh: MeshName = "diamond"
    knot_m: float = 0.0
    drag_width_m: float = 0.0
    """Width of a bar that meets the flow; 0 switches twine drag off. Knots carry no drag."""
    drag_law: str = "le-bris-1999"
    """One of ``drag_laws.DRAG_LAWS``."""
    normal_drag: float = 1.36
    tangential_drag: float = 0.07
    """The law's second coefficient, such as f or Cf."""
    speed_m_s: float = 1.0
    """Of the tow, for laws that depend on it."""
    reynolds_per_speed: float = np.nan
    """d / nu, s/m, likewise."""
    axial_stiffness_n: float | None = None
    """EA of a bar, None if inextensible."""
    knot_axial_stiffness_n: float | None = None
    """EA of a knot, None if inextensible."""

    def __post_init__(self) -> None:
        positive = ("bar_m", "entry_radius_m", "stagnation_pressure_pa")
        for name in (*positive, "knot_m", "drag_width_m", "normal_drag", "tangential_drag"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value >= 0.0 and (value > 0.0 or name not in positive)):
                raise ValueError(f"{name} = {value} must be {'above 0' if name in positive else '0 or more'}")
        if self.meshes_round < 3 or self.half_mesh_rows < 2:
            raise ValueError("meshes_round must be 3 or more and half_mesh_rows 2 or more")
        if not 0.0 <= self.front_row < self.half_mesh_rows:
            raise ValueError(f"front_row = {self.front_row} must lie in 0 <= front_row < {self.half_mesh_rows}")
        if self.mesh not in KINDS or not KINDS[self.mesh].membrane or self.drag_law not in DRAG_LAWS:
            raise ValueError(f"unknown mesh {self.mesh!r} or drag law {self.drag_law!r}")
        for name in ("axial_stiffness_n", "knot_axial_stiffness_n"):
            if (value := getattr(self, name)) is not None and not value > 0.0:
                raise ValueError(f"{name} = {value} must be above 0, or None")
        if (
            self.axial_stiffness_n is None
            and self.knot_axial_stiffness_n is None
            and self.rows_to_axis() >= self.half_mesh_rows
        ):
            raise ValueError(
                f"{self.half_mesh_rows} half-mesh rows cannot reach from entry_radius_m = {self.entry_radius_m} to the "
                f"axis, even as a flat disc: {self.rows_to_axis():.1f} are needed"
            )

    @property
    def knots_lie_across(self) -> bool:
        """Whether knots lie across the meridian, not along it."""
        return KINDS[self.mesh].knots == "across"

    @property
    def spread_radius_m(self) -> float:
        """Radius of a ring of fully spread bars, N b / pi, knots apart."""
        return self.meshes_round * self.bar_m / np.pi

    def rows_to_axis(self) -> float:
        """Half-mesh rows of a flat disc from the entry to the axis; infinite if the entry is wider than the netting."""
        knot = self.knot_m / self.bar_m
        across = knot if self.knots_lie_across else 0.0
        sine = self.entry_radius_m / self.spread_radius_m - across
        if sine >= 1.0:
            return np.inf
        if across > 0.0:
            return self.meshes_round / np.pi * (np.arcsin(max(sine, 0.0)) + min(across, across + sine))
        phi = 0.5 * np.arcsin(sine) * (1.0 + _NODES)
        share = np.cos(phi) / (np.cos(phi) + knot)
        return float(self.meshes_round / np.pi * 0.5 * np.arcsin(sine) * (share @ _WEIGHTS))

    def shell(self) -> Shell:
        """The problem without dimensions: lengths over N b / pi, rows times pi / N, forces over pi (N b / pi)^2 q."""
        per_row = np.pi / self.meshes_round
        force = np.pi * self.spread_radius_m**2 * self.stagnation_pressure_pa

        def compliance(stiffness: float | None) -> float:
            return 0.0 if stiffness is None else force / (2.0 * self.meshes_round * stiffness)

        knot = self.knot_m / self.bar_m
        return Shell(
            rows=self.half_mesh_rows * per_row,
            front=self.front_row * per_row,
            entry_radius=self.entry_radius_m / self.spread_radius_m,
            knot=knot,
            knot_across=self.knots_lie_across,
            pressure=self.pressure_law,
            drag_law=DRAG_LAWS.index(self.drag_law),
            speed_m_s=self.speed_m_s,
            reynolds_per_speed=self.reynolds_per_speed,
            normal=self.normal_drag,
            tangential=self.tangential_drag,
            drag_width=2.0 * self.drag_width_m / self.bar_m,
            compliance=compliance(self.axial_stiffness_n),
            knot_compliance=2.0 * knot * compliance(self.knot_axial_stiffness_n),
        )


@dataclass(frozen=True)
class MeridianShape:
    """Equilibrium of the bag: row by row (row 0 at the entry, shapes (2 M + 1,)) and in sum; SI units."""

    x_m: Floats
    """Distance aft of the entry along the axis."""
    radius_m: Floats
    slope_rad: Floats
    """Slope a of the meridian, -pi/2 at the codline."""
    half_angle_rad: Floats
    """Half opening angle phi of the meshes; 0 where T90 knots are slack."""
    bar_tension_n: Floats
    """Tension of one real bar."""
    front_row: float
    """Half-mesh row of the front, that of the problem."""
    front_x_m: float
    front_radius_m: float
    largest_radius_m: float
    """Over the rows and the front."""
    length_m: float
    """Entry to codline along the axis."""
    catch_volume_m3: float
    """Between the front's plane and the netting aft of it."""
    drag_n: float
    """Catch load plus twine drag, each integrated along the meridian."""
    catch_drag_n: float
    twine_drag_n: float
    entry_reaction_n: float
    """Axial pull of the bars on the entry: the drag again, from the bars' tension."""
    axial_imbalance: float
    """|entry reaction - drag| over the drag: what the discretisation leaves."""
    residual: float
    """Largest defect of an equation, without dimensions."""
    iterations: int
    method: str
    """How the answer was found."""
    outcome: Outcome

    @property
    def converged(self) -> bool:
        """False when the numbers here must not be used."""
        return self.outcome.converged
