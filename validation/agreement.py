"""The same plans by four methods that share as little as they can: two solvers, two nets, and no net at all.

Newton's method and dynamic relaxation find the equilibrium of the same sector with the same loads by other equations;
the full net has another numbering, other images and another factorisation; the meridian method knows no net, only the
membrane that a net of many meshes tends to. What each claims is what is held against it: solutions of one net may
differ by the error estimates that stand beside them in ``results.csv``, the membrane by a bound of second order in the
meshes round, which the second half of the section measures.
"""

from dataclasses import dataclass
from math import pi
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from codend.bag.loads import problem_of
from codend.bag.measures import Measures, measure_all
from codend.equilibrium import accuracy
from codend.equilibrium.accuracy import Errors
from codend.equilibrium.bag_model import model_of
from codend.plan.plan import Plan, plan_from_dict
from codend.report.style import BLUE, INK, ORANGE, dress, new_figure
from codend.solvers import interior_point, newton
from codend.studies.case_result import CaseResult
from codend.studies.study import solve
from validation.report import markdown_table
from validation.section import Picture, Section, Verdict

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MEMBRANE = 15.0
"""Bound on N^2 times the relative difference in drag between net and membrane, N meshes round (measured below)."""
ORDERS = (1.7, 2.3)
"""Between which the order of that difference in 1/N must lie."""
LEAST_FILLED = 0.25
"""Share of the netting in the catch from which the order is clear: with fewer rows higher orders have their say."""
FINEST_DRAWN = 1e-13
GREEN, GREY = "#009e73", "#7a8791"


@dataclass(frozen=True)
class Scene:
    """A codend as shares of its size, so that it can be made of any number of meshes round."""

    mesh: str = "diamond"
    knot: float = 0.0
    """Knot length over bar length."""
    stiffness_n: float | None = None
    """EA of a bar of a net of 100 meshes round; it grows with the bar, for the mean stress stays the same."""
    filled: float = 1 / 3
    """Share of the meshes long, or with ``volume`` of the cube of the radius of a fully open net."""
    volume: bool = False
    pressure: str = "sphere"
    drag_law: str = "le-bris-1999"
    drag: bool = True
    length: float = 0.75
    """Meshes long over meshes round."""
    entry: float = 0.35
    girth_m: float = 8.0
    """N (b + l): stretched meshes round times half their size."""
    speed_m_s: float = 1.2

    def plan(self, meshes_round: int, **model: object) -> Plan:
        """The plan with a number of meshes round."""
        pitch = self.girth_m / meshes_round
        bar = pitch / (1.0 + self.knot)
        across = pitch if self.mesh == "t90" else bar
        meshes_long = round(self.length * meshes_round)
        netting: dict[str, object] = {
            "mesh": self.mesh,
            "meshes_round": meshes_round,
            "meshes_long": meshes_long,
            "bar_mm": 1000.0 * bar,
            "knot_mm": 1000.0 * self.knot * bar,
            "twine_mm": 40.0 * bar,
        }
        if self.stiffness_n is not None:
            netting["axial_stiffness_n"] = self.stiffness_n * 100.0 / meshes_round
        radius = meshes_round * across / pi
        catch = {"volume_m3": self.filled * radius**3} if self.volume else {"filled_meshes": self.filled * meshes_long}
        return plan_from_dict(
            {
                "title": "agreement",
                "tow": {"speed_m_s": self.speed_m_s, "water_density_kg_m3": 1026.0},
                "entry": {"radius_m": self.entry * radius},
                "netting": [netting],
                "catch": {**catch, "pressure": self.pressure},
                "drag": {"law": self.drag_law, **({} if self.drag else {"normal": 0.0, "tangential": 0.0})},
                "model": model,
            }
        )


SCENES = {
    "diamond, uniform pressure, no twine drag": (48, Scene(pressure="uniform", drag=False)),
    "diamond": (48, Scene()),
    "knotted elastic": (48, Scene(knot=0.12, stiffness_n=1000.0)),
    "knotted T90": (40, Scene(mesh="t90", knot=0.15)),
    "diamond, no twine drag": (48, Scene(drag=False)),
    "diamond, drag of Bessonneau and Marichal": (48, Scene(drag_law="bessonneau-1997")),
    "diamond, small catch": (60, Scene(filled=1 / 9)),
    "diamond, large catch": (48, Scene(filled=5 / 6)),
    "diamond, catch by volume": (48, Scene(volume=True, filled=0.6)),
    "knotted": (48, Scene(knot=0.12)),
    "stiff elastic": (48, Scene(stiffness_n=3e4)),
    "T90 without knot length": (48, Scene(mesh="t90")),
    "knotted elastic T90, small catch": (48, Scene(mesh="t90", knot=0.12, stiffness_n=1000.0, filled=1 / 9)),
    "commercial diamond, 100 mm mesh": (90, Scene(knot=0.14, girth_m=4.5, length=0.5, filled=0.5, speed_m_s=1.6)),
    "commercial T90, 130 mm mesh": (48, Scene("t90", 0.1, girth_m=3.12, length=1.0, filled=0.375, speed_m_s=1.8)),
}
"""Meshes round and scene by name; the first four are the quick ones. Lengths and speeds are ASSUMED."""
QUICK = 4
MANY = (24, 48, 96, 192)
"""Meshes round over which the distance to the membrane is followed."""


def section(quick: bool) -> Section:
    """Drag of many plans by four methods, and how net and membrane draw together as meshes grow in number."""
    names = list(SCENES)[:QUICK] if quick else list(SCENES)
    table = pd.DataFrame([_row(name, *SCENES[name]) for name in names])
    counts = MANY[:2] if quick else MANY
    limit = pd.DataFrame([_distances(name, SCENES[name][1], counts) for name in names])
    pictures = (
        Picture(
            "agreement",
            _figure(table),
            "Relative differences in drag. Filled: what was found; hollow, in the same colour: what the two answers "
            f"claim together, or {MEMBRANE:g}/N² for the membrane. Differences below {FINEST_DRAWN:.0e} stand there.",
        ),
        Picture(
            "membrane_limit",
            _limit_figure(limit, counts),
            "The same scenes, made of more and more meshes round: net and membrane draw together with the square.",
        ),
    )
    verdicts = (
        _verdict(table, "Newton's method and relaxation agree on the drag of a sector", "relaxation"),
        _verdict(table, "The full net has the drag of its sector", "full"),
        _verdict(table, f"The membrane's drag is the net's within {MEMBRANE:g}/N²", "meridian"),
        _limit_verdict(limit, counts),
    )
    return Section(
        "Agreement of the methods",
        _text(table, limit, counts),
        pictures,
        {"agreement": table, "membrane_limit": limit},
        verdicts,
    )


def _solved(plan: Plan) -> CaseResult:
    (result,) = solve(plan).cases
    return result


def _full_from_nothing(plan: Plan) -> CaseResult:
    """The full net from a crude bag: ``solve`` would set the equilibrium of a sector all round, which shows nothing."""
    (case,) = plan.cases()
    model = model_of(plan, 1, None)
    problem = problem_of(model.bag, plan, case)
    solution = interior_point.solve(problem, plan.model.tolerance, None, prepared=model.prepared)
    if not solution.report.outcome.converged:
        return CaseResult(case, model.bag, problem, solution, Measures.unknown(), Errors.unknown(), None, None, None)
    meshes, rows, measures = measure_all(model.bag, problem, solution)
    errors = accuracy.estimate(model, case, newton.tangent_at(problem, solution, model.prepared), measures)
    return CaseResult(case, model.bag, problem, solution, measures, errors, None, rows, meshes)


def _row(name: str, meshes_round: int, scene: Scene) -> dict[str, object]:
    """Drag by four methods; differences from the sector by Newton's method and what is claimed, relative."""
    tight = {"method": "newton", "tolerance": 1e-9}
    reference = _solved(scene.plan(meshes_round, fidelity="sector", **tight))
    found = {
        "relaxation": _solved(scene.plan(meshes_round, fidelity="sector", method="dynamic-relaxation")),
        "full": _full_from_nothing(scene.plan(meshes_round, fidelity="full", **tight)),
        "meridian": _solved(scene.plan(meshes_round, fidelity="meridian")),
    }
    drag, own = reference.measures.drag_n, reference.errors.drag_error_n
    row: dict[str, object] = {
        "plan": name,
        "meshes_round": meshes_round,
        "nodes_full": len(found["full"].net.positions),
    }
    row["newton_drag_n"] = drag
    for method, result in found.items():
        claimed = (own + result.errors.drag_error_n) / drag if method != "meridian" else MEMBRANE / meshes_round**2
        row[f"{method}_drag_n"] = result.measures.drag_n
        row[f"{method}_difference"] = result.measures.drag_n / drag - 1.0
        row[f"{method}_claimed"] = claimed
    return row


def _distances(name: str, scene: Scene, counts: tuple[int, ...]) -> dict[str, object]:
    """Relative difference in drag between membrane and sector for each number of meshes round, and its order."""
    row: dict[str, object] = {"plan": name}
    found = []
    for count in counts:
        sector = _solved(scene.plan(count, fidelity="sector", method="newton", tolerance=1e-9))
        membrane = _solved(scene.plan(count, fidelity="meridian"))
        found.append(membrane.measures.drag_n / sector.measures.drag_n - 1.0)
        row[f"difference_{count}"] = found[-1]
    row["order"] = -float(np.polyfit(np.log(counts), np.log(np.abs(found)), 1)[0])
    row["order_is_clear"] = scene.filled >= LEAST_FILLED and not scene.volume
    row["bound_times_n2"] = float(np.max(np.abs(found) * np.square(counts)))
    return row


def _verdict(table: pd.DataFrame, claim: str, method: str) -> Verdict:
    difference, claimed = table[f"{method}_difference"].abs(), table[f"{method}_claimed"]
    worst = (difference / claimed).fillna(np.inf).idxmax()
    return Verdict(
        f"{claim}, on {len(table)} plans",
        bool((difference <= claimed).all()),
        f"largest {difference.max():.1e}; nearest to its claim: {table['plan'][worst]}, {difference[worst]:.1e} "
        f"of {claimed[worst]:.1e}",
    )


def _limit_verdict(limit: pd.DataFrame, counts: tuple[int, ...]) -> Verdict:
    order, bound = limit["order"][limit["order_is_clear"]], limit["bound_times_n2"]
    return Verdict(
        "Net and membrane draw together with the square of the meshes round",
        bool(order.between(*ORDERS).all() and (bound <= MEMBRANE).all()),
        f"orders {order.min():.2f} to {order.max():.2f} from N = {counts[0]} to {counts[-1]}; N² times the difference "
        f"at most {bound.max():.1f}",
    )


def _text(table: pd.DataFrame, limit: pd.DataFrame, counts: tuple[int, ...]) -> str:
    rows = [
        [
            str(r.plan),
            str(r.meshes_round),
            f"{r.newton_drag_n:.6g}",
            *(f"{r[f'{m}_difference']:+.1e} ({r[f'{m}_claimed']:.0e})" for m in ("relaxation", "full", "meridian")),
        ]
        for _, r in table.iterrows()
    ]
    orders = [
        [str(r["plan"]), *(f"{r[f'difference_{n}']:+.1e}" for n in counts), _order_text(r)] for _, r in limit.iterrows()
    ]
    headers = ("plan", "N", "drag N", "relaxation", "full net", "meridian method")
    return "\n\n".join(
        [
            "Drag of a sector by Newton's method (residual 1e-9), and relative differences from it: of the same sector "
            "by relaxation (1e-6), of the full net by the interior-point method (1e-9), and of the membrane. In "
            "brackets, what the two answers claim together: the error estimates of `results.csv`, or for the membrane "
            f"{MEMBRANE:g}/N². All lengths and speeds are assumed.",
            markdown_table(headers, rows),
            "![agreement]",
            "The meridian method has no meshes, so it differs from the net by what a membrane leaves out: chords for "
            "arcs round the bag, of order (π/N)², and steps for a curve along it. To see the order, each scene is made "
            "of more and more meshes of the same netting, the bag and its catch staying as they are. Catches are whole "
            "numbers of meshes, so that the front stands at a row of knots; a catch given by its volume fills a band "
            "in part, another part in every net. There, and where the catch is a few meshes long, the differences are "
            "small and change sign, and no order is read from them (in brackets); the bound holds for them too. With "
            "knots along the netting the order is somewhat below 2: a small term of first order shows, whose cause has "
            "not been traced.",
            markdown_table(("plan", *(f"N = {n}" for n in counts), "order in 1/N"), orders),
            "![membrane_limit]",
        ]
    )


def _order_text(row: pd.Series) -> str:
    return f"{row['order']:.2f}" if row["order_is_clear"] else f"({row['order']:.2f})"


METHODS = (("relaxation", "relaxation", BLUE), ("full", "full net", GREEN), ("meridian", "meridian method", ORANGE))


def _figure(table: pd.DataFrame) -> "Figure":
    figure = new_figure(9.0, 1.4 + 0.32 * len(table))
    axes = figure.add_subplot()
    place = np.arange(len(table))
    for shift, (method, label, colour) in zip((-0.2, 0.0, 0.2), METHODS, strict=True):
        found = np.maximum(table[f"{method}_difference"].abs(), FINEST_DRAWN)
        axes.hlines(place + shift, found, table[f"{method}_claimed"], color=colour, lw=0.7, alpha=0.6)
        axes.plot(found, place + shift, "o", ms=5, color=colour, label=label)
        axes.plot(table[f"{method}_claimed"], place + shift, "o", ms=5, mfc="white", color=colour)
    axes.set_xscale("log")
    axes.set_yticks(place, table["plan"])
    axes.invert_yaxis()
    axes.set_xlabel("relative difference in drag from the sector by Newton's method")
    _finish(axes)
    return figure


def _limit_figure(limit: pd.DataFrame, counts: tuple[int, ...]) -> "Figure":
    figure = new_figure(9.0, 4.8)
    axes = figure.add_subplot()
    drawn = set()
    for _, row in limit.iterrows():
        scene = SCENES[row["plan"]][1]
        if not row["order_is_clear"]:
            kind = ("short catch, or by volume", GREY, "^")
        elif scene.knot > 0.0 and scene.mesh == "diamond":
            kind = ("knots along the netting", ORANGE, "s")
        else:
            kind = ("all others", BLUE, "o")
        label, colour, marker = kind
        found = [abs(row[f"difference_{n}"]) for n in counts]
        axes.plot(counts, found, marker, ls="-", ms=4, lw=1.0, color=colour, label=None if label in drawn else label)
        drawn.add(label)
    axes.plot(counts, MEMBRANE / np.square(counts), color=INK, ls="--", lw=1.2, label=f"{MEMBRANE:g}/N²")
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xticks(counts, [str(n) for n in counts])
    axes.minorticks_off()
    axes.set(xlabel="meshes round, N", ylabel="relative difference in drag, membrane and net")
    _finish(axes)
    return figure


def _finish(axes: "Axes") -> None:
    dress(axes)
    axes.legend(frameon=False, loc="center left", bbox_to_anchor=(1.01, 0.5), fontsize=8)
