"""What ``codend compare DIR TABLE.csv`` puts into the page of the run: the flume table beside the computed codend."""

from codend.report.html import PageFigure, rendered_part
from codend.report.style import number_text
from codend.studies.comparison.compare import Comparison

SECTION = ("comparison", "sections")
"""Name of the part of the page, and its place."""
_PART = """<h2 id="comparison">Beside {{ name }}</h2>
<p>{{ origin }}</p>
<figure><img src="{{ figure.source }}" alt="{{ figure.caption }}"><figcaption>{{ figure.caption }}</figcaption></figure>
<div class="wide"><table><thead><tr><th class="words">Quantity</th><th>Points</th><th>Bias</th><th>RMS</th>
<th>Largest</th><th>Bias<span class="unit">%</span></th><th>RMS<span class="unit">%</span></th>
<th>Largest<span class="unit">%</span></th></tr></thead><tbody>
{% for row in rows %}<tr><td class="words">{{ row[0] }}</td>
{% for cell in row[1:] %}<td>{{ cell }}</td>{% endfor %}</tr>
{% endfor %}</tbody></table></div>
<p class="quiet">Differences are computed less tabled. All values are in comparison.csv.</p>"""


def comparison_html(comparison: Comparison, name: str, picture: bytes) -> str:
    """The section, everything from the table escaped."""
    rows = []
    for row in comparison.summary.to_dict("records"):
        own = [number_text(float(row[key])) for key in ("bias", "rms", "largest")]
        relative = [number_text(100 * float(row[f"relative_{key}"])) for key in ("bias", "rms", "largest")]
        rows.append((row["quantity"], str(row["points"]), *own, *relative))
    figure = PageFigure(picture, "Computed (lines) and tabled (points).")
    return rendered_part(_PART, name=name, origin=comparison.table.origin, figure=figure, rows=rows)
