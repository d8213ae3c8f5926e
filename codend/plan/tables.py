"""The tables of a plan: tow, entry, netting, catch, drag and model, each with the checks that need no other table.

Every number keeps the name and unit of its key in the file; properties without ``mm`` are the same in SI.
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Annotated, Any, Literal, Self

from annotated_types import Ge, Gt, Le, Lt, MinLen
from pydantic import AllowInfNan, BaseModel, BeforeValidator, ConfigDict, Strict, model_validator

from codend.plan.cuts import Cut, cut_of, cut_that_loses
from codend.plan.kinds import KINDS, Kind, MeshName
from codend.plan.messages import Contradiction
from codend.plan.overrides import CATCH_QUANTITIES, ENTRY_SIZES, MESH_SIZES, STRAP_LENGTHS, TITRES, CatchKind
from codend.plan.twines import DENSITY_KG_M3, THICKNESS_MM, MaterialName, rtex_of_number, solid_diameter_m, thickness_mm

Number = Annotated[float, Strict(), AllowInfNan(False)]
Whole = Annotated[int, Strict()]
Text = Annotated[str, MinLen(1)]
Several = (MinLen(1), BeforeValidator(lambda found: found if isinstance(found, list | tuple) else (found,)))

PanelName = Literal["upper", "port", "lower", "starboard"]
PANELS: dict[int, tuple[PanelName, ...]] = {2: ("upper", "lower"), 4: ("upper", "port", "lower", "starboard")}
"""Panels sewn together round, from the seam on the starboard side on over the top."""
TUBE = "tube"
"""What tables call the netting of a section that is no panel."""

SEA_WATER_KG_M3 = 1025.0
"""Assumed where a plan says nothing of its water: sea water, as it is commonly reckoned."""

HAIR_MM = 1e-3
"""Thinner is no twine; thickness that is missing has a stand-in below it while other mistakes are looked for."""

DRAG_COEFFICIENTS = {"le-bris-1999": (1.36, 0.07), "bessonneau-1997": (1.2, 0.1), "choo-casarella-1971": (1.0, 1.0)}
"""Normal and tangential coefficients each drag law takes when the plan names none (LB99 4.2; BM97 2.1.2)."""


class Table(BaseModel):
    """A TOML table: immutable, and with no key but its own."""

    model_config = ConfigDict(frozen=True, extra="forbid")


class Tow(Table):
    """Speed of the codend through the water, and the water."""

    speed_m_s: Annotated[tuple[Annotated[Number, Ge(1e-4), Le(10)], ...], *Several]
    """As slow as the methods are mapped in ``validation.stability``; slower is a slip, not a tow."""
    water_density_kg_m3: Annotated[Number, Ge(900), Le(1300)] = SEA_WATER_KG_M3
    """Left out: sea water, and the run says so."""


class Entry(Table):
    """The rigid hoop, or the end of the section ahead, that holds the front row of meshes."""

    radius_m: Annotated[Number, Gt(0), Le(100)] | None = None
    """See ``Plan.entry_radius_m``, which holds however the entry is given."""
    hanging_ratio: Annotated[Number, Gt(0), Lt(1)] | None = None
    """E1 of the front row: the way round the entry over the stretched meshes of the row."""

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        _exactly_one(self, ENTRY_SIZES)
        return self


class Netting(Table):
    """One section of netting. ``bar_mm`` is twine from knot to knot, without the knot.

    With ``twines = 2`` a bar is two twines of diameter ``twine_mm`` side by side: twice the projected width and twice
    the volume of one. The stiffnesses EA and EI are those of one *bar*, both twines together, and are never doubled.
    """

    mesh: MeshName
    """Kind of netting: diamond (T0), turned by 90 degrees, or square."""
    meshes_round: Annotated[Whole, Ge(3), Le(10_000)]
    """Whole meshes all round."""
    meshes_long: Annotated[Whole, Ge(1), Le(10_000)]
    """Whole meshes along."""
    name: Text | None = None
    """What tables call the section; None: its number."""
    bar_mm: Annotated[Number, Gt(0), Le(10_000)] | None = None
    """Twine from one knot to the next, without the knot. Exactly one of the three sizes is given."""
    mesh_mm: Annotated[Number, Gt(0), Le(20_000)] | None = None
    """The full stretched mesh, knot centre to knot centre: 2 (bar + knot)."""
    inside_mesh_mm: Annotated[Number, Gt(0), Le(20_000)] | None = None
    """What a gauge measures: the full mesh less one knot."""
    knot_mm: Annotated[Number, Ge(0), Le(1000)] = 0.0
    """0: knots are points, and the knot that a gauge does not measure is taken as two twines wide."""
    twine_mm: Annotated[Number, Gt(0), Le(100)] | None = None
    """None: by Rtex and material."""
    rtex: Annotated[Number, Ge(1), Le(1e6)] | None = None
    """Of one twine, g/km."""
    runnage_m_kg: Annotated[Number, Ge(1), Le(1e6)] | None = None
    """Length of a kilogram of one twine."""
    twine_number: Text | None = None
    """Denier of a yarn and number of yarns, as in 210/24."""
    material: MaterialName | None = None
    """What the twine is of: gives its density, and its thickness where that is left out."""
    twines: Annotated[Whole, Ge(1), Le(2)] = 1
    """2: double twine."""
    twine_density_kg_m3: Annotated[Number, Ge(500), Le(10_000)] | None = None
    """None: that of the material; without one, the twine is taken as neutrally buoyant and wet weight is left out."""
    axial_stiffness_n: Annotated[Number, Gt(0), Le(1e9)] | None = None
    """EA of one bar, N; None: inextensible."""
    knot_axial_stiffness_n: Annotated[Number, Gt(0), Le(1e9)] | None = None
    """EA of a knot, N; None: knots do not stretch, however soft the twine."""
    knot_compression: bool = False
    """Whether knots resist being shortened as they do being stretched; else they give way, as twine does."""
    bending_stiffness_n_m2: Annotated[Number, Ge(0), Le(100)] = 0.0
    """EI of one bar, N m^2."""
    rest_opening_deg: Annotated[Number, Ge(0), Lt(180)] = 20.0
    """Opening angle at which bending is at rest; no effect without bending stiffness."""
    panels: Literal[1, 2, 4] = 1
    """Panels sewn together round; 1: a tube."""
    selvedge_meshes: Annotated[Whole, Ge(0), Le(1000)] = 0
    """Meshes of each edge of a panel that are taken up into the selvedge; ``meshes_round`` counts them."""
    meshes_round_aft: Annotated[Whole, Ge(3), Le(10_000)] | None = None
    """At the aft end of a section that tapers; see ``aft_meshes_round``, which holds however it is given."""
    cut: Text | None = None
    """Of each side edge of a panel, which narrows by it, such as "1N2B", "AB" or "1T2B"; beside ``meshes_round_aft``,
    by which a panel may widen as well, it must agree."""

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        _exactly_one(self, MESH_SIZES)
        Contradiction.raise_first(self._counts_that_do_not_fit())
        if self.name is not None and not (self.name.isprintable() and self.name == self.name.strip()):
            raise Contradiction("name", "a text of one line that neither begins nor ends with a blank")
        self._check_twine()
        if self.kind.knots == "none" and self.knot_m > 0:
            raise Contradiction("knot_mm", f"0 for {self.kind.words} mesh")
        if self.knot_axial_stiffness_n is not None and self.knot_mm == 0:
            raise Contradiction("knot_axial_stiffness_n", "only with knot_mm above 0, without which there is no knot")
        if self.knot_compression and self.knot_mm == 0:
            raise Contradiction("knot_compression", "only with knot_mm above 0, without which there is no knot")
        if self.bar_m <= 0:
            size, knots, many = ("mesh_mm", 2, "two knots") if self.mesh_mm else ("inside_mesh_mm", 1, "a knot")
            raise Contradiction(size, f"more than {many}, {1000 * knots * self.knot_m:g} mm")
        if self.knot_m > self.bar_m:
            raise Contradiction("knot_mm", f"at most the length of a bar, {1000 * self.bar_m:g} mm")
        if self.drag_width_m >= self.bar_m:
            side_by_side = ", both twines together" if self.twines == 2 else ""
            key = next(key for key in ("twine_mm", *TITRES) if getattr(self, key) is not None)
            a_twine = "" if self.twine_mm is not None else "a twine "
            raise Contradiction(key, f"{a_twine}thinner than a bar is long, {1000 * self.bar_m:g} mm{side_by_side}")
        return self

    def _counts_that_do_not_fit(self) -> Iterator[Contradiction]:
        """Cuts that are none or contradict the counts, counts that make no panels, and selvedges wider than panels."""
        given = None if self.cut is None else cut_of(self.cut, self._straight)
        if self.cut is not None and self.kind.straight_cut is None:
            yield Contradiction("cut", f"left out: {self.kind.words} mesh is cut along its bars, straight")
            return
        if self.cut is not None and given is None:
            straight = self.kind.straight_cut
            example = Cut(1, 0, 2).text(self._straight)
            yield Contradiction("cut", f'a cut as cutters write it: "A{straight}" (straight), "AB", "{example}" ...')
            return
        for key, count in (("meshes_round", self.meshes_round), ("meshes_round_aft", self.meshes_round_aft)):
            if count is not None and count % self.panels:
                yield Contradiction(key, f"a multiple of {self.panels}, the panels")
                return
        if self.meshes_round_aft is None and self.aft_meshes_round < 3 * self.panels:
            deep, width = self.meshes_long, self.meshes_round // self.panels
            allowed = f"a cut that leaves 3 meshes or more of a panel of {width}, {deep} deep"
            yield Contradiction("cut", allowed)
            return
        taken_up = 2 * self.panels * self.selvedge_meshes
        if self.selvedge_meshes and self.aft_meshes_round - taken_up < 3 * self.panels:
            widest = (min(self.meshes_round, max(self.aft_meshes_round, 0)) // self.panels - 3) // 2
            allowed = f"at most {max(widest, 0)}: 3 meshes of every panel stay open at its narrower end"
            yield Contradiction("selvedge_meshes", allowed)
        if self.meshes_round_aft is None:
            return
        if given is not None and not abs(given.rate * self.meshes_long - abs(self.edge_loss)) < 0.5:
            fits = cut_that_loses(round(2 * abs(self.edge_loss)), self.meshes_long).text(self._straight)
            lost = f"{abs(self.edge_loss):g} mesh{'' if abs(self.edge_loss) == 1 else 'es'}"
            allowed = f'"{fits}", by which an edge loses {lost} over {self.meshes_long}'
            yield Contradiction("cut", allowed, f"contradicts meshes_round_aft = {self.meshes_round_aft}")

    @property
    def _straight(self) -> Literal["N", "T"]:
        return self.kind.straight_cut or "N"

    @property
    def aft_meshes_round(self) -> int:
        """Meshes round at the aft end, selvedges included: given, or what the cut of the edges leaves."""
        given = None if self.cut is None else cut_of(self.cut, self._straight)
        if self.meshes_round_aft is not None or given is None:
            return self.meshes_round_aft or self.meshes_round
        # an edge loses whole half meshes
        half_meshes = round(min(2 * given.rate * self.meshes_long, 1e6))
        return self.meshes_round - self.panels * half_meshes

    @property
    def edge_loss(self) -> float:
        """Meshes by which each side edge of a panel narrows it from end to end; below 0 it widens it."""
        return (self.meshes_round - self.aft_meshes_round) / (2 * self.panels)

    @property
    def edge_cut(self) -> Cut:
        """The cut of each side edge: as given, or what fits the counts."""
        given = None if self.cut is None else cut_of(self.cut, self._straight)
        return given or cut_that_loses(round(2 * abs(self.edge_loss)), self.meshes_long)

    @property
    def edge_cut_text(self) -> str:
        """The cut of each side edge as cutters write it; straight edges of square mesh run along bars."""
        straight = self.kind.straight_cut is None and self.edge_loss == 0
        return "AB" if straight else self.edge_cut.text(self._straight)

    @property
    def tapers(self) -> bool:
        """Whether it has other meshes round at its aft end."""
        return self.aft_meshes_round != self.meshes_round

    @property
    def selvedged_meshes(self) -> int:
        """Meshes round that are taken up into selvedges, at either end."""
        return 2 * self.panels * self.selvedge_meshes

    @property
    def has_seams(self) -> bool:
        """Whether its seams show: panels that taper, or edges taken up into selvedges."""
        return self.selvedge_meshes > 0 or (self.panels > 1 and self.tapers)

    @property
    def open_meshes(self) -> tuple[int, int]:
        """Meshes round that are open, at the fore and at the aft end."""
        return self.meshes_round - self.selvedged_meshes, self.aft_meshes_round - self.selvedged_meshes

    @property
    def panel_names(self) -> tuple[str, ...]:
        """Of its panels, from the seam on the starboard side on over the top; of a tube one name for all of it."""
        return PANELS.get(self.panels, (TUBE,))

    def _check_twine(self) -> None:
        """Refuse twine of no thickness, of two titres, or of a titre without what makes a weight in water of it."""
        titres = [key for key in TITRES if getattr(self, key) is not None]
        if len(titres) > 1:
            raise Contradiction(titres[1], f"at most one of {', '.join(TITRES)}", f"contradicts {titres[0]}")
        if self.twine_number is not None and not self.rtex_g_km:
            raise Contradiction("twine_number", 'the denier of a yarn and the number of yarns, such as "210/24"')
        if titres and self.density_kg_m3 is None:
            allowed = f"one of {', '.join(DENSITY_KG_M3)}, or twine_density_kg_m3, beside {titres[0]}"
            raise Contradiction("material", allowed, "is missing")
        if self.twine_mm is not None:
            heaviest = 1e6 * math.pi / 4 * self.twine_m**2 * (self.density_kg_m3 or math.inf)
            twine = self.twine_mm >= HAIR_MM
            if titres and twine and self.rtex_g_km is not None and self.rtex_g_km > heaviest * (1 + 1e-9):
                allowed = f"of at most R{heaviest:.4g} tex, at least {1e6 / heaviest:.4g} m/kg: fibre that fits into it"
                raise Contradiction(titres[0], f"a twine of {1000 * self.twine_m:g} mm {allowed}")
            return
        if not titres:
            allowed = f"twine_mm, or one of {', '.join(TITRES)} with a material"
            raise Contradiction("twine_mm", allowed, "is missing")
        if thickness_mm(1.0, self.material) is None:
            allowed = f"twine_mm beside {titres[0]}: thickness follows from it only for {', '.join(THICKNESS_MM)}"
            raise Contradiction("twine_mm", allowed, "is missing")

    @property
    def kind(self) -> Kind:
        """What sets netting of this mesh apart."""
        return KINDS[self.mesh]

    @property
    def bar_m(self) -> float:
        """Bar length b: twine between two knots, m."""
        if self.bar_mm is not None:
            return self.bar_mm / 1000
        if self.inside_mesh_mm is not None:
            return self.inside_mesh_mm / 2000 - self.knot_m / 2 + self.crossing_m
        assert self.mesh_mm is not None
        return self.mesh_mm / 2000 - self.knot_m

    @property
    def knot_m(self) -> float:
        """Knot length l along the netting's N-direction, m."""
        return self.knot_mm / 1000

    @property
    def stretches(self) -> bool:
        """Whether its twine or its knots do."""
        return self.axial_stiffness_n is not None or self.knot_axial_stiffness_n is not None

    @property
    def crossing_m(self) -> float:
        """Length that knots of which the plan says nothing take of a bar, at both its ends together, m.

        Bars then run from crossing to crossing and lose half a bar's width at either end: exact for a square of
        crossing twines.
        """
        return self.drag_width_m if self.knot_mm == 0.0 else 0.0

    @property
    def inside_mesh_m(self) -> float:
        """Stretched inside length of a mesh, as a gauge measures it: the full mesh less one knot, 2 b + l, m."""
        return 2 * self.clear_bar_m + self.knot_m

    @property
    def clear_bar_m(self) -> float:
        """Length of a bar that no twine crosses, m."""
        return self.bar_m - self.crossing_m

    @property
    def rtex_g_km(self) -> float | None:
        """Mass of a kilometre of one twine, g; None where the plan has none of ``TITRES``."""
        if self.runnage_m_kg is not None:
            return 1e6 / self.runnage_m_kg
        return self.rtex if self.twine_number is None else rtex_of_number(self.twine_number)

    @property
    def density_kg_m3(self) -> float | None:
        """Density of the twine's fibres; None where the plan gives none."""
        if self.twine_density_kg_m3 is None and self.material is not None:
            return DENSITY_KG_M3[self.material]
        return self.twine_density_kg_m3

    @property
    def mass_kg_m(self) -> float | None:
        """Mass of a metre of bar, all its twines together; None where the plan gives neither titre nor density."""
        if self.rtex_g_km is not None:
            return 1e-6 * self.twines * self.rtex_g_km
        if self.density_kg_m3 is None:
            return None
        return self.density_kg_m3 * math.pi / 4 * self.solid_diameter_m**2

    @property
    def knot_along_m(self) -> float:
        """Length that a knot takes along the netting, m."""
        return self.knot_m if self.kind.knots == "along" else 0.0

    @property
    def knot_across_m(self) -> float:
        """Length that a knot takes across the netting, m."""
        return self.knot_m if self.kind.knots == "across" else 0.0

    @property
    def full_mesh_m(self) -> float:
        """Stretched full mesh 2 (b + l), knot centre to knot centre, m."""
        return 2 * (self.bar_m + self.knot_m)

    @property
    def mean_meshes_round(self) -> float:
        """Meshes round, mean over the length, selvedges included."""
        return 0.5 * (self.meshes_round + self.aft_meshes_round)

    @property
    def twine_m(self) -> float:
        """Diameter of one twine, m."""
        thickness = self.twine_mm
        if thickness is None and self.rtex_g_km is not None:
            thickness = thickness_mm(self.rtex_g_km, self.material)
        return 0.0 if thickness is None else thickness / 1000

    @property
    def drag_width_m(self) -> float:
        """Projected width of a bar, the diameter its drag is reckoned with: all twines side by side, m."""
        return self.twines * self.twine_m

    @property
    def solid_diameter_m(self) -> float:
        """Diameter of the one round bar with the volume of all twines, m: of their fibres where a titre is given."""
        if self.rtex_g_km is not None and self.density_kg_m3 is not None:
            return math.sqrt(self.twines) * solid_diameter_m(1e-6 * self.rtex_g_km, self.density_kg_m3)
        return math.sqrt(self.twines) * self.twine_m

    @property
    def rest_half_angle_rad(self) -> float:
        """Half opening angle phi0 at which bending is at rest, rad."""
        return math.radians(self.rest_opening_deg) / 2

    @property
    def bending_n(self) -> float:
        """24 EI / b^2, what the four clamped bars of a mesh resist opening with, over an angle, N."""
        return 24.0 * self.bending_stiffness_n_m2 / self.bar_m**2

    @property
    def stretched_radius_m(self) -> float:
        """Radius with the open meshes pulled fully open, at the wider end, m.

        N b / pi (diamond), N (b + l) / pi (T90), N b / 2 pi (square).
        """
        return max(self.open_meshes) * self.stretched_radius_per_mesh_m

    @property
    def stretched_radius_per_mesh_m(self) -> float:
        """What each mesh round adds to the radius with meshes pulled fully open, m."""
        return (self.kind.across_bars * self.bar_m + self.knot_across_m) / math.pi

    @property
    def rows_per_mesh(self) -> int:
        """Rows of knots that a mesh is long: 2, in square mesh 1."""
        return self.kind.rows_per_mesh

    def merged_rows(self, globalisation: float) -> int:
        """Rows that so many meshes merged into one leave of its own: the nearest whole number of them."""
        return max(round(self.rows_per_mesh * self.meshes_long / globalisation), 1)

    @property
    def stretched_length_m(self) -> float:
        """Length of the section pulled fully straight, knots included where they lie along it, m."""
        return self.rows_per_mesh * self.meshes_long * (self.bar_m + self.knot_along_m)


class Strap(Table):
    """A round strap: a rope ring on a row of knots that bounds its radius and is slack where the net is narrower.

    It is laid through the knots and does not slide. Its drag is that of its whole length, slack or tight.
    """

    meshes_from_codline: Annotated[Number, Gt(0)]
    """A row of knots: half meshes count in diamond and T90 netting."""
    length_m: Annotated[Number, Gt(0), Le(1000)] | None = None
    """The whole way round; ``around_m`` of the straps of ``Plan.straps``, however the plan gives it."""
    circumference_share: Annotated[Number, Gt(0), Le(1)] | None = None
    """The same over the stretched meshes round the netting there."""
    spacing_meshes: Annotated[Number, Ge(0.5)] | None = None
    """Distance to the next such strap, and so on as far as the entry; None: a single one."""
    axial_stiffness_n: Annotated[Number, Gt(0), Le(1e9)] | None = None
    """EA of the rope, N; None: inextensible."""
    diameter_mm: Annotated[Number, Gt(0), Le(500)] | None = None
    """None: no drag of its own."""
    density_kg_m3: Annotated[Number, Ge(100), Le(20_000)] | None = None
    """Of its material; None: that of the water."""

    @model_validator(mode="after")
    def _has_a_size(self) -> Self:
        if self.density_kg_m3 is not None and self.diameter_mm is None:
            raise Contradiction("density_kg_m3", "only with diameter_mm, without which the strap has no weight")
        return self

    @model_validator(mode="after")
    def _has_one_length(self) -> Self:
        _exactly_one(self, STRAP_LENGTHS)
        return self

    @property
    def around_m(self) -> float:
        """Length the whole way round, m."""
        assert self.length_m is not None
        return self.length_m

    @property
    def diameter_m(self) -> float:
        """Diameter of the rope, 0 where the plan gives none, m."""
        return 0.0 if self.diameter_mm is None else self.diameter_mm / 1000


class Catch(Table):
    """How much is in the bag, by exactly one measure, and how it presses on the netting."""

    filled_meshes: Annotated[tuple[Annotated[Number, Gt(0)], ...], *Several] | None = None
    """Meshes from the codline to the front. Exactly one of the four sizes is given."""
    volume_m3: Annotated[tuple[Annotated[Number, Gt(0)], ...], *Several] | None = None
    """What the netting encloses behind the front."""
    mass_kg: Annotated[tuple[Annotated[Number, Gt(0)], ...], *Several] | None = None
    """That volume times the density."""
    front_from_codline_m: Annotated[tuple[Annotated[Number, Gt(0)], ...], *Several] | None = None
    """Along the axis."""
    density_kg_m3: Annotated[Number, Ge(100), Le(5000)] | None = None
    """None: that of the water (LB99 5 takes the two as very close)."""
    pressure: Literal["sphere", "uniform"] = "sphere"
    """Stagnation pressure inside and that on a sphere outside, or the same everywhere."""
    coefficient: Annotated[Number, Gt(0), Le(10)] = 1.4
    """Net pressure over rho V^2 / 2 under the uniform law."""
    sphere_cp_csv: Text | None = None
    """The user's own Cp curve for the sphere law, relative to the plan's folder; see ``Plan.sphere_cp_path``."""
    sphere_cp: tuple[tuple[Number, Number], ...] | None = None
    """The same in the plan itself: pairs of an angle, in degrees, and Cp."""

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        _exactly_one(self, CATCH_QUANTITIES)
        default = type(self).model_fields["coefficient"].default
        if self.pressure == "sphere" and self.coefficient != default:
            # The default is let through: a plan may name it and still switch between the laws by one key.
            raise Contradiction("coefficient", f'{default:g}, or pressure = "uniform", which alone has a coefficient')
        for key in ("sphere_cp_csv", "sphere_cp"):
            if self.pressure == "uniform" and getattr(self, key) is not None:
                raise Contradiction(key, 'only with pressure = "sphere"')
        if self.sphere_cp is not None:
            if self.sphere_cp_csv is not None:
                raise Contradiction("sphere_cp", "either sphere_cp_csv or sphere_cp", "contradicts sphere_cp_csv")
            angles = [angle for angle, _ in self.sphere_cp]
            rising = all(first < second for first, second in pairwise(angles))
            if len(angles) < 2 or not rising or (angles[0], angles[-1]) != (0.0, 180.0):
                raise Contradiction("sphere_cp", "pairs [angle, Cp] whose angles rise from 0 to 180 degrees")
        return self

    @property
    def kind(self) -> CatchKind:
        """The key that gives the size of the catch."""
        return next(kind for kind in CATCH_QUANTITIES if getattr(self, kind) is not None)

    @property
    def sizes(self) -> tuple[float, ...]:
        """The sizes of catch to solve for, in the unit of ``kind``."""
        sizes: tuple[float, ...] = getattr(self, self.kind)
        return sizes


class Drag(Table):
    """The law of twine drag and its coefficients; left out, they are those of the law's paper.

    Coefficients a plan names stay when an override changes the law, and ``tangential`` then means another thing.
    """

    law: Literal["le-bris-1999", "bessonneau-1997", "choo-casarella-1971"] = "le-bris-1999"
    """That of the paper it is named after."""
    normal: Annotated[Number, Ge(0), Le(10)]
    """Coefficient across the twine; left out: that of the law. 0 switches the twine's drag off."""
    tangential: Annotated[Number, Ge(0), Le(10)]
    """Left out: that of the law. f, a fraction of ``normal``, in le-bris-1999; Cf, a coefficient of its own, in
    bessonneau-1997; in choo-casarella-1971 both numbers are factors on the law's coefficients, which depend on the
    Reynolds number."""

    @model_validator(mode="wrap")
    @classmethod
    def _filled_in(cls, data: Any, check: Callable[[Any], Self]) -> Self:
        if not isinstance(data, Mapping):
            return check(data)
        law = data.get("law", cls.model_fields["law"].default)
        # A law that is none gets any numbers: it is itself what will be refused.
        normal, tangential = DRAG_COEFFICIENTS.get(str(law), (0.0, 0.0))
        found = check({"normal": normal, "tangential": tangential, **data})
        found.model_fields_set.intersection_update(data)  # what the law gives the plan has not said
        return found

    @property
    def coefficients(self) -> tuple[float, float]:
        """Normal and tangential coefficient as the loads use them: both 0 when ``normal`` is, for either law."""
        return (self.normal, self.tangential) if self.normal > 0 else (0.0, 0.0)


class Model(Table):
    """How the plan is to be modelled and solved."""

    fidelity: Literal["auto", "meridian", "smeared", "sector", "globalised", "full"] = "auto"
    """What stands for the netting; `auto` takes the cheapest that keeps within the accuracy."""
    globalisation: Annotated[Whole, Ge(1), Le(1000)] = 1
    """Real meshes merged into one model mesh, each way."""
    bars_per_side: Annotated[Whole, Ge(1), Le(2)] = 1
    """2: a hinge in the middle of each bar, which matters only where twine is slack."""
    method: Literal["auto", "dynamic-relaxation", "newton", "rigid-bars"] = "auto"
    """How the equilibrium is found."""
    damping: Literal["kinetic", "viscous"] = "kinetic"
    """Of dynamic relaxation."""
    tolerance: Annotated[Number, Ge(1e-12), Le(0.1)] = 1e-6
    """Largest nodal residual over the total load."""
    accuracy: Annotated[Number, Gt(0), Le(0.5)] = 0.01
    """What ``fidelity = "auto"`` may cost: in drag by merging meshes, in openings by leaving weight out; relative."""
    opening_accuracy_deg: Annotated[Number, Gt(0), Le(90)] | None = None
    """What it may cost in the mean opening ahead of the catch, where that is what counts: lets ropes be smeared, or
    meshes be merged between them. An error above it has what grows followed."""
    wrinkles: Literal["auto"] | bool = "auto"
    """Whether shapes that are not the same all round are followed where the symmetric one is unstable: ``auto`` where
    the estimates would exceed the accuracy asked for."""
    contact: Literal["auto"] | bool = "auto"
    """Whether shapes in which layers of netting meet are followed on with contact between them: ``auto``, from as many
    starts as some twenty seconds have room for; ``true``, from all of them; ``false`` stops there. Bags that weight
    folds over their hoop are found by it too. Layers of ``[[layer]]`` bear on the netting below in any case; what it
    may change that they slide is asked of the net with its layer in contact, of wider sectors where ``true``, and
    taken from a wider law where ``false``."""

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if self.globalisation > 1 and self.fidelity != "globalised":
            raise Contradiction("globalisation", f'1, or fidelity = "globalised" instead of "{self.fidelity}"')
        return self


def _exactly_one(table: BaseModel, keys: Sequence[str]) -> None:
    given = [key for key in keys if getattr(table, key) is not None]
    if not given:
        raise Contradiction(keys[0], f"exactly one of {', '.join(keys)}", "is missing")
    if len(given) > 1:
        raise Contradiction(given[1], f"exactly one of {', '.join(keys)}", f"contradicts {given[0]}")
