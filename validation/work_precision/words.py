"""The words of the section: what each error contains, and the tables under the charts."""

from collections.abc import Callable, Mapping, Sequence

import pandas as pd

from codend.report.style import number_text
from codend.studies.speed_accuracy.contenders import KINETIC, NEWTON
from codend.studies.speed_accuracy.measuring import QUANTITIES, REFERENCE_TOLERANCE, Measured
from validation.report import markdown_table

UNITS = {"drag_n": "N", "opening_ahead_deg": "°", "catch_volume_m3": "m³"}
CONTENTS = f"""\
The **reference** of each scene is the real net: one rotational sector of it, every mesh of its own, by Newton's method
to a residual of {REFERENCE_TOLERANCE:.0e}. Its finite number of meshes is real and no error. An error is the relative
distance to it, in drag, in mean opening of the five mesh rows ahead of the catch, and in catch volume. It contains

- for a **sector** and for the **full net** with every mesh: the solver's residual alone. Relaxation and rigid bars that
  are asked for a residual of 1e-2 arrive far below it, since every method must also bring its bars to their lengths
  within 1e-6: asking for less hardly saves time;
- for **merged meshes**: what g x g meshes in one do to the shape, which no tolerance takes away;
- for the **membrane** (the meridian method): the real number of meshes, which a membrane does not have. Refining its
  grid by 2 and 4 does not lower that error: the points lie side by side. (Openings of the method are those of the net
  laid out on the membrane, openings on the finer grids are the membrane's own, without knots);
- for the **closed form** (hollow): another scene, uniform pressure of 1.4 q without twine drag, for a rough answer.

Times are of the solve alone, compiled, from nothing, first guess included: the least of up to five runs. Building and
numbering the net and estimating the errors come on top. Newton's method on a full net, merged or not, starts from the
equilibrium of one of its sectors set all round, which without weight is its own: what is timed there is the sector, and
that the full net agrees confirms only that it is in balance so. Its relaxation starts from a crude bag.
"""
QUICK = """\
These are the scenes in brief: the same bags of fewer and larger meshes, on which everything takes milliseconds. Which
method is fastest there says nothing of real nets.
"""


def percent(accuracy: float) -> str:
    """An accuracy as people say it."""
    return f"{100 * accuracy:g} %" if accuracy >= 1e-3 else f"{accuracy:.0e}".replace("e-0", "e-")


def caption(quantity: str) -> str:
    """What to see in a chart."""
    of = {"drag": "the drag", "opening": "the mean opening ahead of the catch", "volume": "the catch volume"}[quantity]
    return (
        f"Relative error in {of} against solve time: colours are methods, shapes are models. Coloured lines join the "
        "tolerances of one method, from 1e-2 to 1e-10 or as far as it gets; pale ones join methods on the same merged "
        "net. Nothing lies below and left of the dark line. What merging meshes saves over the full net, a sector of "
        "the real net saves without the error."
    )


def text(
    everything: Sequence[Measured],
    chosen: pd.DataFrame,
    by_order: Mapping[str, pd.DataFrame],
    series_ms: Mapping[str, float],
    exponents: Mapping[str, Mapping[str, float]],
    slower: tuple[float, float],
    quick: bool,
) -> str:
    """Markdown of the section."""
    weighed = everything[-1]
    parts = [
        CONTENTS,
        *([QUICK] if quick else []),
        "### References and what confirms them\n",
        _references(everything),
        "### Which method for which accuracy, and what is chosen automatically\n",
        _choices(chosen[chosen["scene"] != weighed.scene.name]),
        "Where a scene is one of several catches, the equilibria before it lead to it, and the exact answer takes "
        + ", ".join(f"{ms:.1f} ms ({name})" for name, ms in series_ms.items())
        + ".\n",
        "### Twine that has weight\n",
        _weight(weighed),
        _choices(chosen[chosen["scene"] == weighed.scene.name]),
        f"The automatic choice agrees with the charts if it meets the accuracy and takes at most {slower[0]:g} "
        f"times as long as the fastest answer that does, or at most {slower[1]:g} ms longer.\n",
        "### Order of the error in merging, and growth of the cost\n",
        _orders(by_order),
        "Solve time grows with the knots of full nets to the power "
        + "; ".join(
            f"{found[NEWTON]:.2f} (Newton) and {found[KINETIC]:.2f} (relaxation) for {name}"
            for name, found in exponents.items()
        )
        + ".\n",
    ]
    return "\n".join(parts)


def _references(everything: Sequence[Measured]) -> str:
    rows = []
    for measured in everything:
        values = [f"{measured.reference[name]:.8g} {UNITS[name]}" for name in QUANTITIES]
        rows.append([f"**{measured.scene.name}**", "reference", *values])
        for _, row in measured.confirmations.iterrows():
            apart = [f"{row[short]:.1e}" for short in QUANTITIES.values()]
            rows.append(["", f"{row['model']}, {row['method']}", *apart])
    return markdown_table(["scene", "answer, or its relative distance", "drag", "opening ahead", "volume"], rows) + "\n"


def _choices(chosen: pd.DataFrame) -> str:
    columns: dict[str, Callable[[pd.Series], str]] = {
        "scene": lambda row: row["scene"],
        "error in drag": lambda row: percent(row["accuracy"]),
        "fastest": lambda row: row["fastest"],
        "ms": lambda row: number_text(row["fastest_ms"], 2),
        "its error": lambda row: f"{row['fastest_error']:.0e}",
        "chosen": lambda row: row["chosen"],
        "ms ": lambda row: number_text(row["chosen_ms"], 2),
        "its error ": lambda row: f"{row['chosen_drag_error']:.0e}",
        "time over fastest": lambda row: f"{row['ratio']:.1f}",
    }
    rows = [[tell(row) for tell in columns.values()] for _, row in chosen.iterrows()]
    return markdown_table([name.strip() for name in columns], rows) + "\n"


def _weight(weighed: Measured) -> str:
    sector = weighed.points[weighed.points["model"] == "sector"].iloc[0]
    return (
        f"The {weighed.scene.name} cannot be one sector all round: its weight pulls the bag down. In drag that hardly "
        f"matters: weight acts across it and changes it in the second order, here by {sector['drag_error']:.0e}, mean "
        f"opening by {sector['opening_error']:.0e}, volume by {sector['volume_error']:.0e}, less than merging meshes "
        "does. A full net is chosen for what a sector cannot show, openings that differ from top to bottom by up to "
        "the weight's share of the drag, once that share exceeds the accuracy. The fastest answer is sought among full "
        "nets where one is chosen. The reference is the full net with every mesh. Choosing took "
        f"{weighed.automatic['choosing_ms'].max():.0f} ms at most.\n"
    )


def _orders(by_order: Mapping[str, pd.DataFrame]) -> str:
    rows = []
    for name, table in by_order.items():
        for _, row in table.iterrows():
            order = [f"{row[short]:.2f}" for short in QUANTITIES.values()]
            rows.append([name, f"{row['from']:.0f} to {row['to']:.0f}", *order])
    return (
        "Order of the error of merging, counted in sqrt(g² - 1), because a net of N/g meshes is off the membrane by "
        "c (g/N)² and the real net by c/N²:\n\n" + markdown_table(["scene", "g", *QUANTITIES.values()], rows) + "\n"
    )
