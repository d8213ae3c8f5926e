"""The command ``codend compare``: a run beside a flume table, designs beside each other."""

import math
from pathlib import Path
from typing import TYPE_CHECKING

import click

from codend.cli.common import check_writable, table_options, written_into
from codend.cli.console import text_table
from codend.errors import OPTIONS, InputError

if TYPE_CHECKING:
    from codend.io.table_form import TableForm
    from codend.studies.comparison import Comparison

MOST_ROD_MM = 1000.0


def _rod_mm(_: click.Context, option: click.Parameter, text: str | None) -> float | None:
    """The thickness of a rod, mm, refused in the words of a plan's numbers."""
    if text is None:
        return None
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0.0 < value <= MOST_ROD_MM:
        shown = text if math.isnan(value) else value
        raise InputError(OPTIONS, option.opts[0], shown, f"a number above 0, at most {MOST_ROD_MM:g}, in mm")
    return value


@click.command()
@click.argument("folder", metavar="DIR", type=click.Path(path_type=Path))
@click.argument("others", metavar="TABLE.csv|DIR...", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option("--out", metavar="DIR", type=click.Path(path_type=Path), help="Where to write on designs compared.")
@table_options
@click.option(
    "--hoop-rod-mm",
    callback=_rod_mm,
    metavar="MM",
    help="Thickness you assume for the hoop's rod: its drag is computed and added, where TABLE.csv has an empty "
    "hoop_drag_n column.",
)
def compare(
    folder: Path, others: tuple[Path, ...], out: Path | None, hoop_rod_mm: float | None, form: "TableForm"
) -> None:
    """Set the results of a run in DIR beside a flume table, or designs in several DIR beside each other.

    Rows are matched on the catch and speed columns the table has, interpolated in catch size and never extrapolated.
    Differences are computed minus tabled. Writes comparison.csv (every value), comparison_summary.csv and
    comparison.png into DIR, and a section into its report.html.

    With --out, each DIR is a design: openings, drag and, where `codend selectivity` was run, L50 and SR against the
    catch, what differs in the plans, and differences from the first with their intervals, in tables and on a page.
    """
    if out is not None:
        for other in others:
            if other.is_file():
                allowed = "folders of runs with --out, or a table without it"
                raise InputError(OPTIONS, "--out", str(out), allowed, f"stands beside {other}, which is a table")
        _compare_designs([folder, *others], out)
        return
    if len(others) > 1 or others[0].is_dir():
        raise InputError(OPTIONS, "--out", None, "a folder to write to, where designs are compared", "is missing")
    (table,) = others
    from codend.io.files import COMPARISON_FILES, write_bytes, write_table
    from codend.io.run_tables import read_run_table
    from codend.plan.plan import load_plan
    from codend.report.comparison_page import SECTION, comparison_html
    from codend.report.comparison_plot import comparison_figure
    from codend.report.own_look import own_look
    from codend.report.page_parts import put_into
    from codend.report.style import png
    from codend.studies.comparison import Hoop, read_flume_table
    from codend.studies.comparison import compare as compare_with

    check_writable(folder, COMPARISON_FILES)
    results = folder / "results.csv"
    hoop = None
    if hoop_rod_mm is not None:
        plan = load_plan(folder / "plan.toml")
        hoop = Hoop(plan.entry_radius_m, hoop_rod_mm / 1000.0, plan.tow.water_density_kg_m3)
    comparison = compare_with(read_run_table(results), read_flume_table(table, form), results, hoop)
    with written_into(folder, COMPARISON_FILES):
        points, summary, picture = (folder / name for name in COMPARISON_FILES)
        write_table(comparison.points, points)
        write_table(comparison.summary, summary)
        with own_look():
            drawn = png(comparison_figure(comparison))
        write_bytes(drawn, picture)
        if (folder / "report.html").exists():
            put_into(folder / "report.html", {SECTION: comparison_html(comparison, table.name, drawn)})
    _print_comparison(comparison)


def _compare_designs(folders: list[Path], out: Path) -> None:
    from codend.report.designs_page import FILES, write_designs
    from codend.studies.comparison.designs import beside_each_other

    found = beside_each_other(folders)
    check_writable(out, FILES)
    with written_into(out, FILES):
        write_designs(found, out)
    click.echo(text_table(list(found.plans.columns), found.plans.itertuples(index=False)))
    shown = found.differences.drop(columns=["against", "interpolated"])
    click.echo(f"each less {found.names[0]}")
    click.echo(text_table([name.replace("_", " ") for name in shown.columns], shown.itertuples(index=False)))
    click.echo(f"{len(FILES)} files written into {out}; see {out / 'designs.html'}")
    for sentence in found.left_out:
        click.echo(sentence, err=True)


def _print_comparison(comparison: "Comparison") -> None:
    table, summary = comparison.table, comparison.summary
    click.echo(f"{table.path}: {table.origin}")
    matched = f"{comparison.matched_on} and speed" if comparison.matched_on else "speed"
    lines = comparison.compared["table_line"].nunique()
    click.echo(f"{lines} of {len(table.lines)} rows compared, matched on {matched}; differences are computed - tabled")
    percent = 100.0 * summary[["relative_bias", "relative_rms", "relative_largest"]]
    rows = [
        (row.quantity, row.points, row.bias, row.rms, row.largest, *relative)
        for row, relative in zip(summary.itertuples(), percent.to_numpy().tolist(), strict=True)
    ]
    click.echo(text_table(["quantity", "points", "bias", "RMS", "largest", "bias %", "RMS %", "largest %"], rows))
    if "hoop_drag_n" in table.columns:
        click.echo(f"drag_n: computed drag plus the hoop's ({table.hoop_origin}), beside the table's drag_n")
    left_out = comparison.points[comparison.points["computed"].isna()]
    for (line, note), points in left_out.groupby(["table_line", "note"], sort=True):
        click.echo(f"not compared, line {line}: {', '.join(points['quantity'])}: {note}")
