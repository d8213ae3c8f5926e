"""A study as one page to read: no scripts, nothing fetched from anywhere, pictures inside it."""

import base64
import platform
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from importlib.metadata import PackageNotFoundError, version
from importlib.resources import files
from pathlib import Path
from typing import Any

from codend.equilibrium.fidelity import Choice, Reason
from codend.equilibrium.situation import MOST_HUNG
from codend.equilibrium.stability import ranges_text
from codend.io.names import as_text
from codend.plan.plan import Plan
from codend.report.answer import cards_of
from codend.report.choice_words import reason_text, width_and_count
from codend.report.layer_words import held_layers
from codend.report.net_plan import plan_svg
from codend.report.page_tables import results_tables, solving_table
from codend.report.size_words import size_sentences
from codend.report.strap_words import slack_straps
from codend.studies.case_result import CaseResult
from codend.studies.study import Study

FIDELITIES = {
    "sector": "One rotational sector of the real net",
    "globalised": "The full net, globalised",
    "full": "The full net, every mesh",
    "meridian": "The meridian of a smooth shell of netting",
}

FOLDS_WORTH_TELLING = 0.01
"""Share of the netting on the catch in folds, from which a case is named for it."""


@dataclass(frozen=True)
class PageFigure:
    """A picture of the page."""

    png: bytes
    caption: str

    @property
    def source(self) -> str:
        """The picture itself as an address."""
        return "data:image/png;base64," + base64.b64encode(self.png).decode("ascii")


def page_html(study: Study, figures: Sequence[PageFigure], run: str = "", turning: str = "") -> str:
    """The page as HTML, everything from the plan escaped.

    Args:
        study: what to write about, solved or not.
        figures: the first stands at the top of the page, the others after the table of results; none if nothing was
            solved.
        run: name of the run, as ``run.json`` has it; "" where the page stands alone.
        turning: file beside it in which the net turns under the mouse; "" where there is none.
    """
    plan = study.plan
    return rendered(
        "report.html",
        title=plan.title,
        summary=f"{_count(len(study.cases), 'case')}; written {datetime.now().astimezone():%d %B %Y, %H:%M %Z}"
        + (f"; run {run}, as run.json beside its tables says." if run else "."),
        notes=notes(study),
        fidelity=_fidelity(study.choice),
        why=reason_text(study.choice),
        cards=cards_of(study),
        tables=study.tables,
        turning=turning,
        sizes=size_sentences(plan),
        results=results_tables(study),
        solving=solving_table(study),
        opening_figures=figures[:1],
        figures=figures[1:],
        net_plan="data:image/svg+xml;base64," + base64.b64encode(plan_svg(plan).encode()).decode("ascii"),
        inputs=input_sections(plan.to_dict()),
        inputs_remark=f"All values of the plan ({as_text(Path(plan.source.name))}), with the defaults of keys it "
        "leaves out. Which of them were measured and which were assumed stands in the comments of the plan's file.",
    )


def rendered(template: str, **values: Any) -> str:
    """A page from a template of this room, in the frame and style that all share, everything escaped.

    Args:
        template: name of its file.
        values: what it asks for; title and summary of all, style and versions of none.
    """
    from jinja2 import Environment, FunctionLoader, StrictUndefined
    from markupsafe import Markup

    def text(name: str) -> str:
        return (files("codend.report") / name).read_text(encoding="utf-8")

    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, loader=FunctionLoader(text))
    return environment.get_template(template).render(style=Markup(text("page.css")), versions=made_with(), **values)


def rendered_part(template: str, **values: Any) -> str:
    """A part of a page from the text of a template, everything escaped."""
    from jinja2 import Environment, StrictUndefined

    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True)
    return environment.from_string(template).render(**values)


def notes(study: Study) -> list[str]:
    """What a reader must know before using the numbers."""
    found = []
    if failed := _named([result for result in study.cases if not result.converged], study):
        found.append(f"Not solved, and without numbers: {failed}. What was tried stands below.")
    found += cautions(study)
    if study.plan.water_is_assumed:
        found.append(f"{sea_water(study.plan)}.")
    catch = study.plan.catch
    if catch.pressure == "uniform":
        found.append(f"The catch presses with {catch.coefficient:g} times the stagnation pressure on all its netting.")
    elif catch.sphere_cp_csv is None:
        found.append(
            "The pressure outside the catch follows a Cp curve of a sphere that was reconstructed from descriptions of "
            "the subcritical curve; it is not a digitised measurement. The key catch.sphere_cp_csv names another one."
        )
    else:
        found.append(f"The pressure outside the catch follows the plan's own Cp curve, {catch.sphere_cp_csv}.")
    if len({section.meshes_round for section in study.plan.netting}) > 1:
        found.append(
            "Where sections of different mesh counts meet, knots are laced to knots in the ratio of the counts, "
            "without slack: the joint is no wider than the fewer meshes, with the shorter bar, pulled fully open."
        )
    if study.plan.catch_density_kg_m3 != study.plan.tow.water_density_kg_m3:
        acts = "presses on the netting" if study.choice.sees_weight else "is left out of this model, as its errors tell"
        found.append(f"The catch is not as dense as the water: its own weight in water {acts}.")
    if any(section.density_kg_m3 is None for section in study.plan.netting):
        found.append("Twine whose density the plan does not give is taken as neutrally buoyant.")
    rigid = [s for s in study.plan.netting if s.knot_m > 0.0 and s.knot_axial_stiffness_n is None]
    if any(section.axial_stiffness_n is not None for section in rigid):
        found.append("Knots do not stretch where the plan gives no knot_axial_stiffness_n, however soft the twine.")
    if any(section.knot_across_m > 0.0 and not section.knot_compression for section in study.plan.netting):
        found.append(
            "Knots that lie across the netting give way where it is narrower than they are, near the codline, as real "
            "knots do not; netting.knot_compression = true has them keep their length. The difference, below 1 % of "
            "drag in most codends and some degrees of opening ahead of small catches, is in no error stated here."
        )
    return found


def sea_water(plan: Plan) -> str:
    """That the water's density is assumed, and which it is."""
    return f"Sea water of {plan.tow.water_density_kg_m3:g} kg/m3 is assumed: the plan gives no tow.water_density_kg_m3"


def cautions(study: Study) -> list[str]:
    """Which cases are to be taken with care though they were solved, and why."""
    found = []
    of_sectors = [result for result in study.cases if result.unstable and result.net.order > 1]
    if waving := _named(of_sectors, study):
        growing = sorted({k for result in of_sectors if result.stability for k in result.stability.growing})
        found.append(
            f"In balance, but not stable in this shape, which is the same in all sectors: {waving}. What varies "
            f"{ranges_text(tuple(growing))} times round the net grows, so it lies in waves or folds. The estimates of "
            "drag, volume, radius and opening are widened to cover what these change."
        )
    of_full_nets = [result for result in study.cases if result.unstable and result.net.order == 1]
    if unstable := _named(of_full_nets, study):
        found.append(
            f"In balance, but not stable by the eigenvalues of the tangent: {unstable}. At a touch such a net takes "
            "another shape, often in folds. The estimates of drag, volume, radius and opening are widened by the "
            "strength of what grows."
        )
    for shapes in (True, False):
        led = [result for result in study.cases if result.followed.reason and (result.followed.shape is None) != shapes]
        for reason in dict.fromkeys(result.followed.reason for result in led):
            same = _named([result for result in led if result.followed.reason == reason], study)
            found.append(f"{'In waves' if shapes else 'Wrinkles'}: {same}: {reason}.")
    for near in dict.fromkeys(result.stands_in for result in study.cases if result.stands_in is not None):
        same = _named([result for result in study.cases if result.stands_in == near], study)
        wide, stands_for = width_and_count(near)
        found.append(
            f"No equilibrium was found with the meshes round that the plan has: {same}. In its place stands a sector "
            f"{wide} meshes wide, as of {stands_for} meshes round; the estimates cover what that changes."
        )
    of_smeared = [result for result in study.cases if result.smeared and study.choice.fidelity != "smeared"]
    if smeared := _named(of_smeared, study):
        found.append(
            f"No equilibrium was found with the ropes where they are: {smeared}. Between them netting hangs so slack "
            f"that it flutters, or lies in folds{_not_followed(study)}. In their place ropes are smeared "
            f"over all meshes{', and the wet weight is left out' if study.choice.sees_weight else ''}; "
            "the estimates cover what that changed on nets that were found both ways."
        )
    of_merged = [
        result
        for result in study.cases
        if result.bag.globalisation > 1 and study.choice.globalisation == 1 and result.followed.shape is None
    ]
    if merged := _named(of_merged, study):
        g = f"{of_merged[0].bag.globalisation:.3g}"
        found.append(
            f"No equilibrium was found with every mesh between the ropes: {merged}. In their place stand fewer, larger "
            f"ones, {g} x {g} merged into one{', and the wet weight is left out' if study.choice.sees_weight else ''}; "
            "the estimates cover what that changed on nets that were found both ways."
        )
    pressed = [result for result in study.cases if result.followed.contact_share > 0.0]
    if in_contact := _named(pressed, study):
        counts = sorted({result.followed.fold_count for result in pressed})
        found.append(
            f"Layers of netting press on each other ({ranges_text(tuple(counts))} folds round the net): {in_contact}. "
            "What they press with depends on the model of contact, what that changes in drag and openings stands in "
            "their errors, with the spread of the shapes found."
        )
    in_folds = [result for result in study.cases if result.measures.folded_share > FOLDS_WORTH_TELLING]
    if folded := _named(in_folds, study):
        most = 100.0 * max(result.measures.folded_share for result in in_folds)
        found.append(
            f"Netting on the catch lies in folds, up to {most:.2g} % of it: {folded}. The catch's pressure is right in "
            "sum over the layers of a fold, not on each; no error estimate covers that."
        )
    return found + held_layers(study, _named) + slack_straps(study, _named)


def _fidelity(choice: Choice) -> str:
    if choice.reason is Reason.BETWEEN_ROPES:
        return "One rotational sector, globalised"
    return FIDELITIES.get(choice.fidelity, choice.fidelity)


def input_sections(tables: Mapping[str, Any]) -> list[dict[str, Any]]:
    """The tables of a plan or a scene with all their values, each with a name and its entries."""
    sections: list[dict[str, Any]] = []
    for name, table in tables.items():
        if isinstance(table, dict):
            sections.append({"name": name, "entries": _entries(table)})
        elif isinstance(table, list):
            count = len(table)
            titles = [name] if count == 1 else [f"{name} {i} of {count}" for i in range(1, count + 1)]
            sections += [{"name": t, "entries": _entries(part)} for t, part in zip(titles, table, strict=True)]
    return sections


def made_with() -> str:
    """The program, the language and the libraries that numbers come from, with their versions."""
    found = [f"Python {platform.python_version()}"]
    for package in ("codend", "numpy", "scipy", "numba"):
        try:
            found.append(f"{package} {version(package)}")
        except PackageNotFoundError:
            found.append(f"{package} (not installed, run from its source)")
    return ", ".join(found[1:2] + found[:1] + found[2:]) + "."


def _entries(table: dict[str, Any]) -> list[tuple[str, str]]:
    lists = {key: value if isinstance(value, list) else [value] for key, value in table.items()}
    return [(key, ", ".join(map(str, values))) for key, values in lists.items()]


def _not_followed(study: Study) -> str:
    """Whether folds between ropes were followed at all."""
    knots = study.choice.knots
    if knots <= MOST_HUNG:
        return " to which no start led"
    return f", which are not followed in sectors of more than {MOST_HUNG} knots (here {knots})"


def _named(results: Sequence[CaseResult], study: Study) -> str:
    """How many cases of a study these are, and which; empty if none."""
    numbers = ", ".join(str(result.case.number) for result in results)
    return f"{_count(len(results), 'case')} of {len(study.cases)} ({numbers})" if results else ""


def _count(number: int, what: str) -> str:
    return f"{number} {what}" if number == 1 else f"{number} {what}s"
