"""Everything ``codend selectivity`` leaves in a study's folder: tables, plots and a section of ``report.html``."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from codend.io.files import SELECTIVITY_TABLES, TRIAL_TABLES, whole_file, write_bytes, write_table
from codend.report.answer import small_plot
from codend.report.html import PageFigure, rendered_part
from codend.report.own_look import own_look
from codend.report.page_parts import put_into
from codend.report.selectivity_plots import catch_plot, history_plot, mesh_plot, retention_plot, sensitivity_plot
from codend.report.selectivity_words import answers, field_notes, l50_and_sr, notes, why_none
from codend.report.style import column_text, png
from codend.report.together_plot import together_plot
from codend.selectivity.escape.predict import Prediction
from codend.selectivity.escape.species import species_toml
from codend.selectivity.escape.tables import HAUL, retention_table, selectivity_table, sensitivity_table
from codend.selectivity.predicted_and_observed.together import Together, calibration_table, together_table
from codend.selectivity.predicted_and_observed.together_l50 import together_l50_table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PLOTS: dict[str, tuple[Callable[[Sequence[Prediction]], Figure], str]] = {
    "retention": (
        retention_plot,
        "Retention by length for each catch and over the haul. Grey: 95 % of hauls when all numbers with a range vary "
        "over it. Orange: 95 % of logit curves fitted to hauls with a finite number of fish; a logit curve goes to "
        "zero for small fish, the computed one to the share that never tries a mesh, so that the logit's SR is wider.",
    ),
    "l50_sr": (
        catch_plot,
        "L50 and SR of fish that meet each catch: of the computed curve, and of a logit curve as a trial would fit it.",
    ),
    "haul_history": (history_plot, "The haul: opening of the meshes ahead of the catch, and L50 of fish that arrive."),
    "meshes": (
        mesh_plot,
        "The mesh just ahead of the catch, to scale, and the section of the longest mean fish that passes it at its "
        "best orientation. The outline is the clear hole: twine lies outside it.",
    ),
    "sensitivity": (
        sensitivity_plot,
        "What each number does to the haul's L50 over its range: alone, and as a share of the variance of L50 and SR "
        "when all vary together. A number whose own value is an end of its range has a bar for the other end only.",
    ),
}
COLUMNS = {
    "catch_volume_m3": ("Catch volume", "m³"),
    "opening_ahead_deg": ("Opening ahead", "degrees"),
    "haul_l50_logit_cm": ("L50 of a trial: logit of a haul that ends with it", "cm"),
    "haul_sr_logit_cm": ("SR of such a trial", "cm"),
    "haul_l50_cm": ("L50 of that haul, computed curve", "cm"),
    "haul_sr_cm": ("SR of that haul", "cm"),
    "l50_cm": ("L50 of fish that meet it, computed curve", "cm"),
    "sr_cm": ("SR of those fish", "cm"),
}
TOGETHER = (
    "Predicted and fitted together. Left: retention of the computed haul, the curve fitted to the trial and the shares "
    "observed (paired gear: test over control, scaled by the split; what exceeds 1.25 is not drawn). Right: L50 "
    "against the catch at the end of a haul. Alike are the L50 of curves fitted in the same way, to the trial's fish "
    "and to computed retention at the same catches and lengths; lines are L50 read off the computed curves, which do "
    "not go to zero for small fish."
)
FILES = (
    *(*SELECTIVITY_TABLES, *TRIAL_TABLES, "report.html"),
    *(f"plots/selectivity_{name}.png" for name in ("together", *PLOTS)),
)
"""Every file that ``write_selectivity`` may write or remove."""
SECTION, CARD = ("selectivity", "sections"), ("card of selectivity", "card")
"""Names of the parts of the page, and their places."""

_SECTION = """<h2 id="selectivity">Selectivity</h2>
<p class="quiet">Predicted from the computed openings of the meshes ahead of the catch and the sections of fish; no
trial enters but where it is said.</p>
{% for answer in answers %}<p><strong>{{ answer }}</strong></p>
{% endfor %}{% for figure in figures[:1] %}<figure><img src="{{ figure.source }}" alt="{{ figure.caption }}">
<figcaption>{{ figure.caption }}</figcaption></figure>
{% endfor %}<div class="notes"><ul>{% for note in notes %}<li>{{ note }}</li>{% endfor %}</ul></div>
<div class="wide"><table><thead><tr><th class="words">Species</th><th>Case</th>
{% for name, unit in heads %}<th>{{ name }}<span class="unit">{{ unit }}</span></th>{% endfor %}</tr></thead><tbody>
{% for row in rows %}<tr><td class="words">{{ row[0] }}</td>
{% for cell in row[1:] %}<td>{{ cell }}</td>{% endfor %}</tr>
{% endfor %}</tbody></table></div>
{% for note in field_notes %}<p>{{ note }}</p>
{% endfor %}{% for figure in figures[1:] %}<figure><img src="{{ figure.source }}" alt="{{ figure.caption }}">
<figcaption>{{ figure.caption }}</figcaption></figure>
{% endfor %}"""
_CARDS = """{% for card in cards %}<section class="card"><h2>L50 of {{ card.name }}</h2>
<ul>{% for name, value, within in card.said %}<li><strong>{{ value }} cm</strong> <span class="of">{{ name }}
{% if within %}(95 %: {{ within }}){% endif %}</span></li>{% endfor %}</ul>
{% if card.why %}<p class="quiet">No L50: {{ card.why }}.</p>{% endif %}
{% if card.plot %}<img src="{{ card.plot }}" alt="L50 of hauls that end with each catch">{% endif %}
<p class="quiet">As a trial would report it. <a href="#selectivity">How, and what is assumed</a></p></section>
{% endfor %}"""


def write_selectivity(predictions: Sequence[Prediction], folder: Path, together: Sequence[Together] = ()) -> list[Path]:
    """Write selectivity.csv, retention.csv, sensitivity.csv and plots/selectivity_*.png and a section into report.html.

    With a trial, together.csv and together_l50.csv and their plot, which comes first; with a calibration,
    calibration.csv and, where it explains the trial, calibrated_species.toml. What an earlier call left of those is
    removed. The section and files of an earlier call go first; where there is no report.html none is made.

    Raises:
        OSError: a file cannot be written.
    """
    report = folder / "report.html"
    if report.exists():
        put_into(report, {SECTION: "", CARD: ""})
    for name in FILES:
        if name != report.name:
            (folder / name).unlink(missing_ok=True)
    written = []
    tables = {
        "selectivity.csv": selectivity_table(predictions),
        "retention.csv": retention_table(predictions),
        "sensitivity.csv": sensitivity_table(predictions),
    }
    if together:
        tables |= {"together.csv": together_table(together), "together_l50.csv": together_l50_table(together)}
    calibration = together[0].calibration if together else None
    if calibration is not None:
        tables["calibration.csv"] = calibration_table(calibration)
        if calibration.explains:
            written.append(folder / "calibrated_species.toml")
            with whole_file(written[-1]) as temporary:
                temporary.write_text(species_toml(calibration.species), encoding="utf-8")
    for name, table in tables.items():
        write_table(table, folder / name)
        written.append(folder / name)
    (folder / "plots").mkdir(exist_ok=True)
    figures: list[PageFigure] = []
    drawn = {name: (lambda draw=draw: draw(predictions), caption) for name, (draw, caption) in PLOTS.items()}
    plots = {"together": (lambda: together_plot(together), TOGETHER), **drawn}
    for name, (draw, caption) in plots.items():
        path = folder / "plots" / f"selectivity_{name}.png"
        if (name == "sensitivity" and tables["sensitivity.csv"].empty) or (name == "together" and not together):
            continue
        with own_look():
            figures.append(PageFigure(png(draw()), caption))
        write_bytes(figures[-1].png, path)
        written.append(path)
    if report.exists():
        put_into(report, {SECTION: section_html(predictions, figures, together), CARD: card_html(predictions)})
        written.append(report)
    return written


def section_html(
    predictions: Sequence[Prediction], figures: Sequence[PageFigure], together: Sequence[Together] = ()
) -> str:
    """The section of the report, everything from species files escaped."""
    import pandas as pd

    table = selectivity_table(predictions)
    table = pd.concat([table[table["case"] == HAUL], table[table["case"] != HAUL]])
    columns = [column_text(table[name].to_numpy(dtype=float), digits=4) for name in COLUMNS]
    cases = ["whole haul" if case == HAUL else case for case in table["case"]]
    return rendered_part(
        _SECTION,
        answers=answers(predictions),
        notes=notes(predictions),
        field_notes=field_notes(together),
        heads=list(COLUMNS.values()),
        rows=list(zip(table["species"], cases, *columns, strict=True)),
        figures=figures,
    )


def card_html(predictions: Sequence[Prediction]) -> str:
    """Cards of the page's answer: L50 and SR that a trial would report, and L50 against the catch."""
    cards = []
    for one in predictions:
        said = l50_and_sr(one)
        volume, ends = one.haul.volume_m3, one.end_logit[:, 0]
        good = np.isfinite(ends)
        plot = small_plot(volume[good], ends[good], np.full(good.sum(), np.nan), "m³")
        cards.append({"name": one.species.name, "said": said, "why": "" if said else why_none(one), "plot": plot})
    return rendered_part(_CARDS, cards=cards)
