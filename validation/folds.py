"""Turned codends in folds, with contact between their layers: a section of the validation report.

``python -m validation --only folds``. Beside the symmetric rows stand those that following found by itself; then one
codend on sectors of several widths and on a net of merged meshes, each from a few starts along what grows.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import process_time
from typing import Any

import numpy as np
import pandas as pd

from codend.bag.loads import problem_of
from codend.bag.measures import measure_all
from codend.equilibrium import solve as equilibrium
from codend.equilibrium.bag_model import model_of
from codend.equilibrium.folds import fold_count, follow_under_contact, in_contact_share
from codend.equilibrium.growing_starts import along
from codend.equilibrium.stability import stability_of
from codend.mechanics.surface import Surface
from codend.plan.plan import Plan
from codend.solvers import newton
from codend.solvers.gentle import End
from codend.solvers.refusal import passage
from codend.studies.study import solve
from validation.report import markdown_table
from validation.section import Picture, Section, Verdict
from validation.wrinkles import rings_figure
from validation.wrinkles.matrix import BENDING_N_M2, CATCH_KG, MERGED, MESHES_ROUND, commercial

WIDTHS = (5, 10, 20)
"""Real meshes that the sectors beside each other are wide."""
STARTS = 3
"""Of each of them."""
WITHIN, WITHIN_DEG = 5e-3, 2.0
SECONDS = 15.0


@contextmanager
def _timed() -> Iterator[list[float]]:
    """Processor time spent in search for contact and in cutting steps, s, added up in the list."""
    spent, kept = [0.0], {name: getattr(Surface, name) for name in ("on_the_way", "nearest_of", "free_part")}

    def around(call: Callable) -> Callable:
        def timed(*arguments: Any) -> Any:
            began = process_time()
            found = call(*arguments)
            spent[0] += process_time() - began
            return found

        return timed

    for name, call in kept.items():
        setattr(Surface, name, around(call))
    try:
        yield spent
    finally:
        for name, call in kept.items():
            setattr(Surface, name, call)


def row_of(meshes_round: int, bending: float, catch: float) -> dict[str, object]:
    """One codend, symmetric and as following left it."""
    symmetric = solve(commercial("t90", meshes_round, bending, catch, wrinkles=False)).cases[0]
    began = process_time()
    with _timed() as spent:
        result = solve(commercial("t90", meshes_round, bending, catch, wrinkles=True)).cases[0]
    seconds = process_time() - began
    followed = result.followed
    return {
        "meshes_round": meshes_round,
        "bending_n_m2": bending,
        "catch_kg": catch,
        "drag_n": symmetric.measures.drag_n,
        "opening_deg": symmetric.measures.opening_ahead_deg,
        "contact": "yes" if result.problem.surface is not None else "no",
        "sector_meshes": 1 if followed.shape is None else followed.shape.meshes,
        "contact_drag_n": result.measures.drag_n,
        "contact_drag_error_n": result.errors.drag_error_n,
        "contact_opening_deg": result.measures.opening_ahead_deg,
        "contact_opening_error_deg": result.errors.opening_ahead_error_deg,
        "drag_spread_n": followed.drag_spread_n,
        "opening_spread_deg": followed.opening_spread_deg,
        "shapes_found": followed.shapes_found,
        "fold_count": followed.fold_count,
        "contact_share": followed.contact_share,
        "stable": result.stability.stable if result.stability else "unknown",
        "residual": result.report.residual,
        "pierced": "no" if passage(result.problem, result.positions) is None else "yes",
        "seconds": seconds,
        "search_share": spent[0] / seconds,
        "reason": followed.reason,
    }


def width_rows(plan: Plan, meshes: int, merged: int) -> Iterator[dict[str, object]]:
    """A codend on a sector so many real meshes wide, ``merged`` each way into one: a row a start.

    The starts are along the strongest ``STARTS`` harmonics that fit.
    """
    case = plan.cases()[0]
    model = model_of(plan, merged, 1)
    problem, solution = equilibrium.solve(model, case, (), None)
    stability = stability_of(model, newton.tangent_at(problem, solution, model.prepared))
    width, order = meshes // merged, model.bag.net.sectors
    fitting = [growth for growth in stability.growths if growth.harmonic * width % order == 0]
    wide = model_of(plan, merged, width)
    for growth in sorted(fitting, key=lambda growth: growth.eigenvalues[0].real)[:STARTS]:
        began = process_time()
        rest, start = along(model, wide, solution, growth)
        row: dict[str, object] = {"title": plan.title, "meshes": meshes, "merged": merged, "harmonic": growth.harmonic}
        found = follow_under_contact(wide, problem_of(wide.bag, plan, case), rest, start, None)
        row["seconds"] = process_time() - began
        if found is None or found[1].end is not End.SETTLED:
            yield row | {"ends": "not settled"}
            continue
        touching, motion = found
        shape, measures = motion.solution, measure_all(wide.bag, touching, motion.solution)[2]
        tangent = newton.tangent_at(touching, shape, wide.prepared)
        yield row | {
            "ends": "settled",
            "steps": motion.steps,
            "drag_n": measures.drag_n,
            "opening_deg": measures.opening_ahead_deg,
            "residual": shape.report.residual,
            "stable": stability_of(wide, tangent).stable,
            "pierced": "no" if passage(touching, shape.positions) is None else "yes",
            "fold_count": fold_count(shape.positions, touching.rings, wide.bag.net.order),
            "contact_share": in_contact_share(touching, shape),
        }


def widths_of(plan: Plan, widths: tuple[int, ...]) -> list[dict[str, object]]:
    """Rows of a codend: sectors of its net, and of one merged by 2 that is the widest of them."""
    models = [*((meshes, 1) for meshes in widths), (max(widths), MERGED)]
    return [row for meshes, merged in models for row in width_rows(plan, meshes, merged)]


def means_of(widths: pd.DataFrame) -> pd.DataFrame:
    """Of each model the mean drag and opening of the shapes that last, or of all that settled where none does."""
    settled = widths[widths["ends"] == "settled"]
    means = {}
    for model, rows in settled.groupby(["meshes", "merged"]):
        lasting = rows[rows["stable"] == "yes"]
        means[model] = (lasting if len(lasting) else rows)[["drag_n", "opening_deg"]].mean()
    return pd.DataFrame(means).T


def section(quick: bool) -> Section:
    """Tables, verdicts, and a codend in folds seen along its axis."""
    rounds, catches, bendings = ((50,), (50.0,), (0.0,)) if quick else (MESHES_ROUND, CATCH_KG, BENDING_N_M2)
    table = pd.DataFrame([row_of(n, ei, kg) for n in rounds for ei in bendings for kg in catches])
    plan = commercial("t90", 50 if quick else 100, 0.0, 50.0 if quick else 300.0)
    widths = pd.DataFrame(widths_of(plan, WIDTHS[:2] if quick else WIDTHS))
    picture = () if quick else (_picture(),)
    return Section(
        "Folds", _text(table, widths), picture, {"folds": table, "folds_widths": widths}, _verdicts(table, widths)
    )


def _text(table: pd.DataFrame, widths: pd.DataFrame) -> str:
    headers = (
        "round", "EI N m²", "kg", "symmetric: drag N", "opening °", "contact", "meshes wide", "drag N", "opening °",
        "spread N", "spread °", "shapes", "folds", "knots pressed %", "stable", "residual", "s", "search %",
    )  # fmt: skip
    rows = [
        (
            str(r.meshes_round), f"{r.bending_n_m2:g}", f"{r.catch_kg:g}", f"{r.drag_n:.1f}", f"{r.opening_deg:.2f}",
            r.contact, str(r.sector_meshes), f"{r.contact_drag_n:.1f} ± {r.contact_drag_error_n:.2g}",
            f"{r.contact_opening_deg:.2f} ± {r.contact_opening_error_deg:.2g}", _number(r.drag_spread_n),
            _number(r.opening_spread_deg), str(r.shapes_found), str(r.fold_count),
            _number(100.0 * r.contact_share), r.stable, f"{r.residual:.0e}", f"{r.seconds:.1f}",
            f"{100.0 * r.search_share:.0f}",
        )
        for r in table.itertuples()
    ]  # fmt: skip
    beside = [
        tuple("" if pd.isna(v) else f"{v:.5g}" if isinstance(v, float) else str(v) for v in r)
        for r in widths.to_numpy()
    ]
    return "\n\n".join(
        [
            "T90 codends of the matrix above. Where wrinkles grow until layers of netting meet, contact without "
            "friction acts between them (`model.contact`), from several starts; of the shapes found the one that "
            "lasts all round stands, and their spread is its error. The catch presses on the inner layers of a fold "
            "as on the outer: a choice, said to change 0.05 % of the drag and 0.3 degrees. The sum of the pushes of "
            "contact depends on the model and is not given. Seconds are of processor time, the symmetric answer and "
            "stability included; `search` is what finding near parts and cutting steps takes of them.",
            markdown_table(headers, rows),
            "One codend on sectors of several widths, and on a net of merged meshes, each from starts along the "
            "strongest harmonics that fit. They are held to each other by the means of the shapes that last.",
            markdown_table(tuple(widths.columns), beside),
        ]
    )


def _number(value: float) -> str:
    return "" if np.isnan(value) else f"{value:.2g}"


def _verdicts(table: pd.DataFrame, widths: pd.DataFrame) -> tuple[Verdict, ...]:
    touching = table[table["contact"] == "yes"]
    sound = (touching["residual"] <= 1e-6) & (touching["pierced"] == "no")
    limp = touching[touching["bending_n_m2"] == 0.0]
    lasting = limp["stable"] == "yes"
    means = means_of(widths)
    drag = float(np.ptp(means["drag_n"]) / means["drag_n"].mean())
    opening = float(np.ptp(means["opening_deg"]))
    spread = float(np.ptp(widths["drag_n"].dropna()) / means["drag_n"].mean())
    return (
        Verdict(
            "Codends in contact are in balance to 1e-6, and nothing passes through anything",
            bool(sound.all()),
            f"{len(touching)} codends, largest residual {touching['residual'].max():.1e}",
        ),
        Verdict(
            "Nothing grows of those of limp twine, all round",
            bool(lasting.all()),
            f"{int(lasting.sum())} of {len(limp)}; of all twines {int((touching['stable'] == 'yes').sum())} of "
            f"{len(touching)}",
        ),
        Verdict(
            f"Sectors of several widths and merged nets agree within {100 * WITHIN:g} % and {WITHIN_DEG:g} degrees",
            bool(len(means) == len(widths.groupby(["meshes", "merged"])) and drag <= WITHIN and opening <= WITHIN_DEG),
            f"{int((widths['ends'] == 'settled').sum())} of {len(widths)} starts settled, {100.0 * drag:.3f} % in drag "
            f"and {opening:.2f} degrees between the means, {100.0 * spread:.3f} % in drag between all",
        ),
        Verdict(
            f"Codends of limp twine with contact take less than {SECONDS:g} s of processor time from nothing",
            bool(limp["seconds"].max() < SECONDS),
            f"largest {limp['seconds'].max():.1f} s; of all twines {touching['seconds'].max():.1f} s",
        ),
    )


def _picture() -> Picture:
    result = solve(commercial("t90", 100, 0.0, 300.0, wrinkles=True)).cases[0]
    caption = (
        "Rings of knots near the codline of a T90 codend of limp twine, 100 meshes round, with 300 kg, seen along the "
        f"axis: {result.followed.reason}. Drag {result.measures.drag_n:.1f} N, {result.followed.fold_count} folds."
    )
    return Picture("folds_t90", rings_figure(result), caption)
