"""Codends of many kinds under heave: ranges of openings and drag, and what halving the time step still changes.

``python -m validation.pulsing [NAME ...]`` prints a row a codend. Told besides: the range of the second period, which
is that of the third and last where the bag has come to its period.
"""

import sys
from time import process_time
from typing import Any

import codend
from codend.plan.plan import Plan, plan_from_dict
from codend.studies.pulse import pulse

DIAMOND = {"mesh": "diamond", "meshes_round": 40, "meshes_long": 24, "bar_mm": 50.0, "twine_mm": 4.0}
KNOTTED = DIAMOND | {"knot_mm": 10.0}
SECTOR, FULL = {"fidelity": "sector"}, {"fidelity": "full"}
Sections = list[dict[str, Any]]


def plan(netting: Sections, filled: float, heave_m: float, period_s: float, radius_m: float = 0.3, **more: Any) -> Plan:
    """A codend at 1.5 m/s under heave."""
    tables = {"title": "pulsing", "tow": {"speed_m_s": 1.5}, "entry": {"radius_m": radius_m}, "netting": netting}
    tables |= {"catch": {"filled_meshes": filled}, "vessel": {"heave_m": heave_m, "period_s": period_s}}
    return plan_from_dict({**tables, "time": {"periods": 3, "outputs_a_period": 20}, **more})


def plans() -> dict[str, Plan]:
    """Codends by name."""
    square = DIAMOND | {"mesh": "square", "meshes_long": 30}
    small_square = square | {"meshes_round": 16, "meshes_long": 14}
    stiff = KNOTTED | {"bending_stiffness_n_m2": 0.002, "rest_opening_deg": 30.0}
    heavy = DIAMOND | {"meshes_round": 20, "meshes_long": 14, "twine_density_kg_m3": 2500.0}
    turned = KNOTTED | {"mesh": "t90", "meshes_round": 20, "meshes_long": 15}
    small = DIAMOND | {"meshes_round": 24, "meshes_long": 16}
    strap = {"meshes_from_codline": 6, "circumference_share": 0.5}
    rope = {"number": 2, "shortening": 0.15, "diameter_mm": 24.0}
    dense = {"filled_meshes": 7, "density_kg_m3": 1060}
    stiff_t90 = turned | {"meshes_long": 24, "bending_stiffness_n_m2": 0.002, "rest_opening_deg": 30.0}
    snug = {"bar_mm": 100.0, "meshes_round": 16, "meshes_from_codline": [0, 12]}
    cover = DIAMOND | {"meshes_round": 24, "bar_mm": 100.0, "meshes_from_codline": [0, 20]}
    return {
        "knotted T0": plan([KNOTTED], 7, 0.5, 4),
        "small catch": plan([DIAMOND], 1.5, 1.0, 8, model=SECTOR),
        "large catch": plan([DIAMOND], 20, 1.0, 12, model=SECTOR),
        "dense catch": plan([DIAMOND], 7, 0.5, 6, model=SECTOR, catch=dense),
        "T90": plan([KNOTTED | {"mesh": "t90"}], 4, 0.5, 4),
        "square": plan([square], 6, 0.5, 6, 0.2, model=SECTOR),
        "square, full net": plan([small_square], 4, 0.3, 4, 0.08, model=FULL),
        "twine that stretches": plan([DIAMOND | {"axial_stiffness_n": 800.0}], 7, 0.8, 6),
        "knots that stretch": plan([KNOTTED | {"axial_stiffness_n": 3e3, "knot_axial_stiffness_n": 5e3}], 7, 0.5, 4),
        "stiff twine": plan([stiff], 7, 0.5, 4),
        "stiff twine, slow": plan([stiff], 7, 1.0, 20),
        "stiff T90": plan([stiff_t90], 6, 0.5, 6, 0.2),
        "two sections": plan([DIAMOND | {"meshes_long": 10}, turned], 6, 0.5, 6, 0.2, model=SECTOR),
        "strap": plan([DIAMOND], 10, 0.5, 6, model=SECTOR, strap=[strap]),
        "smeared ropes": plan([DIAMOND], 7, 0.5, 6, model={"fidelity": "smeared"}, rope=[rope]),
        "ropes": plan([DIAMOND], 7, 0.5, 6, model=SECTOR, rope=[rope]),
        "ropes, full net": plan([small], 5, 0.5, 6, 0.15, model=FULL, rope=[rope | {"number": 3, "shortening": 0.1}]),
        "full net": plan([small], 5, 0.5, 6, 0.15, model=FULL),
        "cover": plan([DIAMOND], 7, 0.5, 6, layer=[cover]),
        "snug layer": plan([DIAMOND], 7, 0.5, 6, layer=[DIAMOND | snug]),
        "snug layer, stiff": plan([stiff], 7, 0.5, 6, layer=[DIAMOND | snug]),
        "weight, full net": plan([heavy], 4, 0.3, 6, 0.15, model=FULL),
    }  # fmt: skip


def row(name: str, of: Plan) -> str:
    """What is told of a codend."""
    assert of.vessel is not None
    result, (period_s,) = codend.solve(of).cases[0], of.vessel.period_s
    if not result.converged:
        return f"{name:24s} not solved: {result.report.outcome.value}"
    began = process_time()
    try:
        found = pulse(of, result, period_s)
    except ArithmeticError as error:
        return f"{name:24s} {error}"
    time, last = found.table["time_s"], found.last_period
    before = found.table[(time >= period_s * (1.0 - 1e-9)) & (time <= 2.0 * period_s * (1.0 + 1e-9))]
    stands = "" if found.settled else ", not settled"
    ranges = [f"{t['opening_ahead_deg'].min():6.2f} to {t['opening_ahead_deg'].max():6.2f}" for t in (last, before)]
    return (
        f"{name:24s} {of.vessel.heave_m:g} m, {period_s:2g} s: opening {ranges[0]} ({ranges[1]} before, "
        f"{result.measures.opening_ahead_deg:.2f} at rest), drag {last['drag_n'].min():.0f} to "
        f"{last['drag_n'].max():.0f} N ({result.measures.drag_n:.0f}); halving to {1e3 * found.step_s:.2f} ms changed "
        f"{found.off['opening_ahead_deg']:.2f} degrees, {found.off['drag_n']:.1f} N{stands}; "
        f"{process_time() - began:.1f} s"
    )


def main() -> None:
    """Print the rows."""
    for name, of in plans().items():
        if not sys.argv[1:] or name in sys.argv[1:]:
            print(row(name, of), flush=True)


if __name__ == "__main__":
    main()
