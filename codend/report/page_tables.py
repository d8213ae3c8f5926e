"""Tables of the report page: numbers rounded for reading, each column with its name and unit."""

from dataclasses import dataclass, replace

import numpy as np

from codend.bag.measures import ROWS_AHEAD, WANTED_OPENING_DEG
from codend.equilibrium.stability import ranges_text
from codend.io.columns import ERRORS, error_of
from codend.report.style import column_text, worth
from codend.studies.case_result import CaseResult
from codend.studies.study import Study


@dataclass(frozen=True)
class Head:
    """Head of a column."""

    name: str
    unit: str = ""
    words: bool = False
    """Whether the column holds words, which are set to the left."""


@dataclass(frozen=True)
class PageRow:
    """Cells of a row, as text."""

    cells: tuple[str, ...]
    failed: bool
    outcome: str
    attempts: tuple[str, ...]


@dataclass(frozen=True)
class PageTable:
    """A table ready to be shown."""

    heads: tuple[Head, ...]
    rows: tuple[PageRow, ...]
    remarks: tuple[str, ...]


RESULT_HEADS = {
    "speed_m_s": Head("Speed", "m/s"),
    "filled_meshes": Head("Filled meshes"),
    "catch_volume_m3": Head("Catch volume", "m³"),
    "catch_mass_kg": Head("Catch mass", "kg"),
    "front_from_codline_m": Head("Front from codline", "m"),
    "front_radius_m": Head("Radius at front", "m"),
    "max_radius_m": Head("Largest radius", "m"),
    "length_m": Head("Length", "m"),
    "drag_n": Head("Drag", "N"),
    "catch_drag_n": Head("Drag by the catch", "N"),
    "twine_drag_n": Head("Drag by the twine", "N"),
    "opening_ahead_deg": Head("Opening ahead", "degrees"),
    "opening_force_ahead_n": Head("Opening force ahead", "N"),
    "max_bar_tension_n": Head("Largest bar tension", "N"),
    "max_strap_tension_n": Head("Largest strap tension", "N"),
    "max_rope_tension_n": Head("Largest rope tension", "N"),
    "inside_mesh_mm": Head("Inside mesh ahead", "mm"),
    "full_mesh_mm": Head("Full mesh ahead", "mm"),
}
SECOND_TABLE = "drag_n"
"""From this column on a second table: so both fit on a printed page."""
DIGITS = {"speed_m_s": 3, "filled_meshes": 3}
"""Of the largest value in the column; 4 elsewhere."""


def results_tables(study: Study) -> tuple[PageTable, ...]:
    """``results.csv`` for readers, in two tables; columns that no case has a number for are named in a remark."""
    table = study.table
    told = [name for name in RESULT_HEADS if name in table]
    shown = [name for name in told if table[name].notna().any()]
    columns = {name: _column(study, name) for name in shown}
    cut = list(RESULT_HEADS).index(SECOND_TABLE)
    parts = [[name for name in shown if (list(RESULT_HEADS).index(name) >= cut) is later] for later in (False, True)]
    remarks = [
        f"Ahead: mean over the {ROWS_AHEAD} rows of meshes just ahead of the catch. Opening force: the extra pull "
        f"across the short diagonal that brings a mesh, taken as isolated, to an opening of {WANTED_OPENING_DEG:g}°; "
        "negative where it is wider open already. Length: from the entry to the codline along the axis. "
        "What follows ± is the estimated error, where it shows in four digits; all digits are in results.csv."
    ]
    if study.plan.strap:
        weightless = any(strap.density_kg_m3 is None for strap in study.plan.strap)
        weight = "; those without density_kg_m3 weigh nothing in water" if weightless else ""
        remarks.append(f"Straps: a slack one keeps the drag of its whole length{weight}.")
    if study.plan.window:
        remarks.append("Windows: openings ahead are of the netting around them; their own meshes are in meshes.csv.")
    missing = [RESULT_HEADS[name].name.lower() for name in told if name not in shown]
    if missing:
        remarks.append(f"Not computed: {'; '.join(missing)}.")
    cases = [_case_text(result) for result in study.cases]
    return tuple(
        PageTable(
            (Head("Case"), *(columns[name][0] for name in names)),
            _rows(study, [cases, *(columns[name][1] for name in names)]),
            tuple(remarks) if names is parts[-1] else (),
        )
        for names in parts
        if names
    )


def _column(study: Study, name: str) -> tuple[Head, list[str]]:
    """Head and cells of a column, a number with its error where one is computed."""
    values = study.table[name].to_numpy(dtype=float)
    scale, unit = _in_thousands(name, values)
    head = replace(RESULT_HEADS[name], unit=unit)
    if name not in ERRORS:
        return head, column_text(values / scale, digits=DIGITS.get(name, 4))
    errors = study.table[error_of(name)].to_numpy(dtype=float)
    both = [worth(value, error) for value, error in zip(values / scale, errors / scale, strict=True)]
    return head, [f"{value} ± {error}" if error else value for value, error in both]


def _in_thousands(name: str, values: np.ndarray) -> tuple[float, str]:
    """What a column is divided by, and its unit then: masses from a tonne on are told in tonnes."""
    unit = RESULT_HEADS[name].unit
    return (1000.0, "t") if unit == "kg" and np.nanmax(values) >= 1000.0 else (1.0, unit)


def solving_table(study: Study) -> PageTable:
    """How each case was solved, and how well its forces balance."""
    reports = [result.report for result in study.cases]
    drag, reaction = (study.table[name].to_numpy(dtype=float) for name in ("drag_n", "entry_reaction_n"))
    cells = [
        [str(result.case.number) for result in study.cases],
        [report.method for report in reports],
        [f"{report.iterations}" for report in reports],
        column_text(np.array([report.solve_ms for report in reports]), digits=3),
        [_small(report.residual) for report in reports],
        column_text(reaction, digits=6),
        column_text(drag, digits=6),
        [_small(difference) for difference in reaction - drag],
        [_small(result.measures.sideways_imbalance) for result in study.cases],
        [_small(report.length_error) for report in reports],
        [_stable(result) for result in study.cases],
        column_text(100.0 * study.table["folded_share"].to_numpy(dtype=float), digits=3),
    ]
    heads = (
        Head("Case"),
        Head("Method", words=True),
        Head("Iterations"),
        Head("Time", "ms"),
        Head("Residual"),
        Head("Pull at the entry", "N"),
        Head("Drag", "N"),
        Head("Pull less drag", "N"),
        Head("Sideways"),
        Head("Length error"),
        Head("Stable", words=True),
        Head("In folds", "%"),
    )
    remark = (
        "Residual: largest force out of balance on a free node, over the resultant of the loads. Pull at the entry: "
        "the axial reaction, which must equal the drag. Sideways: what the entry's reactions leave of the loads "
        "across the axis and as a moment, over the resultant load and the bag's length. Length error: largest "
        "departure of a bar from the law of its twine, over its length. Stable: of a sector yes where no change grows, "
        "however often it varies round the net, and in brackets how often those do that grow; of a full net yes where "
        "no eigenvalue of the tangent grows. In folds: netting on the catch that faces inward, where the pressure is "
        "right in sum over the layers of a fold only."
    )
    return PageTable(heads, _rows(study, cells), (remark,))


def _rows(study: Study, columns: list[list[str]]) -> tuple[PageRow, ...]:
    reports = [result.report for result in study.cases]
    return tuple(
        PageRow(cells, not report.outcome.converged, report.outcome.value, report.attempts)
        for cells, report in zip(zip(*columns, strict=True), reports, strict=True)
    )


def _stable(result: CaseResult) -> str:
    if result.stability is None:
        return ""
    growing = ranges_text(result.stability.growing)
    said = "not sure" if result.stability.stable == "unknown" else result.stability.stable
    return f"{said} ({growing})" if growing else said


def _case_text(result: CaseResult) -> str:
    return str(result.case.number) if result.converged else f"{result.case.number} (not solved)"


def _small(value: float) -> str:
    """Two digits in scientific notation; nothing for nan and infinity."""
    return f"{value:.1e}" if np.isfinite(value) else ""
