"""The look that all plots share, and numbers as readers expect them."""

import math
from collections.abc import Sequence
from io import BytesIO
from typing import TYPE_CHECKING, Literal

import numpy as np

from codend.net.net import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

INK = "#22303c"
PALE = "#c9d2da"
ORANGE, BLUE = "#d55e00", "#0072b2"
"""Of the palette for the colour-blind by Okabe and Ito."""
DOTS_PER_INCH = 150
MARGIN_IN = 0.1
PANEL_SIDES_IN = {"left": 0.95, "right": 2.7, "bottom": 0.6, "top": 0.3}
"""Room round panels: for the numbers and names of their axes, and for a legend at the right."""
PANEL_GAP_IN = 0.4


def new_figure(width_in: float, height_in: float, layout: Literal["constrained"] | None = "constrained") -> "Figure":
    """A figure that draws into memory and to files, without a window and without pyplot's global state.

    Without ``layout`` its axes stay where they are placed.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width_in, height_in), dpi=DOTS_PER_INCH, layout=layout)
    FigureCanvasAgg(figure)
    return figure


def new_panels(count: int, width_in: float, height_in: float) -> tuple["Figure", list["Axes"]]:
    """A figure of panels one above the other with the same axes, ``height_in`` each, room for a legend at right.

    They are placed by hand: to find the same places by measuring all texts takes as long as to draw the figure.
    """
    side = PANEL_SIDES_IN
    total_in = side["bottom"] + side["top"] + count * height_in + (count - 1) * PANEL_GAP_IN
    figure = new_figure(width_in, total_in, layout=None)
    places = {
        "left": side["left"] / width_in,
        "right": 1.0 - side["right"] / width_in,
        "bottom": side["bottom"] / total_in,
        "top": 1.0 - side["top"] / total_in,
        "hspace": PANEL_GAP_IN / height_in,
    }
    axes = figure.subplots(count, squeeze=False, sharex=True, sharey=True, gridspec_kw=places)[:, 0]
    return figure, list(axes)


def png(figure: "Figure") -> bytes:
    """A figure of ``new_figure`` as a PNG picture, its empty margins cut.

    Drawn once and cut as pixels: ``savefig`` goes through all a figure holds three times to find its margins.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from PIL import Image

    canvas = figure.canvas
    assert isinstance(canvas, FigureCanvasAgg)
    canvas.draw()
    drawn = np.asarray(canvas.buffer_rgba())
    pixels = drawn.view(np.uint32)[:, :, 0]
    inked = pixels != pixels[0, 0]
    (top, *_, bottom), (left, *_, right) = (np.flatnonzero(inked.any(axis=axis)) for axis in (1, 0))
    margin = round(MARGIN_IN * figure.dpi)
    height, width = bottom + 1 - top, right + 1 - left
    picture = np.empty((height + 2 * margin, width + 2 * margin, 3), dtype=np.uint8)
    picture[:] = drawn[0, 0, :3]
    picture[margin : margin + height, margin : margin + width] = drawn[top : bottom + 1, left : right + 1, :3]
    written = BytesIO()
    # a level beyond 3 takes half as long again for pictures a few per cent smaller
    Image.fromarray(picture).save(written, "PNG", compress_level=3, dpi=(figure.dpi, figure.dpi))
    return written.getvalue()


def dress(axes: "Axes") -> None:
    """Quiet axes: a pale grid behind the data, no frame but the two axes."""
    axes.grid(color=PALE, linewidth=0.6, alpha=0.6)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
    axes.spines[["left", "bottom"]].set_color(INK)
    axes.tick_params(colors=INK)


def ordered_colours(count: int) -> list[tuple[float, float, float, float]]:
    """Colours from dark to light for a rising quantity, without the yellow that is lost on white."""
    from matplotlib import colormaps

    return [colormaps["viridis"](0.88 * i / max(count - 1, 1)) for i in range(count)]


def spread(count: int, most: int) -> list[int]:
    """At most ``most`` of the numbers 0 .. count - 1, evenly spread and with both ends."""
    if count <= most:
        return list(range(count))
    return [round(i * (count - 1) / (most - 1)) for i in range(most)]


def number_text(value: float, digits: int = 3) -> str:
    """A number to ``digits`` significant digits without exponent, the digits before the point always whole.

    >>> number_text(1813.37), number_text(0.0352021), number_text(1.0)
    ('1813', '0.0352', '1')
    """
    if value == 0.0 or not math.isfinite(value):
        return "0" if value == 0.0 else ""
    decimals = max(0, digits - 1 - math.floor(math.log10(abs(value))))
    text = f"{value:.{decimals}f}"
    return text.rstrip("0").rstrip(".") if "." in text else text


def column_text(values: Floats, digits: int = 4) -> list[str]:
    """Numbers of a column, with decimals that give the largest ``digits`` digits; nan and infinity as nothing."""
    finite = [abs(float(v)) for v in values if math.isfinite(v)]
    largest = max(finite, default=0.0)
    decimals = max(0, digits - 1 - math.floor(math.log10(largest))) if largest > 0.0 else 0
    return [f"{float(v):.{decimals}f}" if math.isfinite(v) else "" for v in values]


def worth(value: float, error: float, digits: int = 4) -> tuple[str, str]:
    """A number with the digits its error leaves it, no more than ``digits``, and the error; both as text.

    >>> worth(29.7813, 0.21), worth(827.84, 1e-7), worth(7.413, 2.1)
    (('29.8', '0.2'), ('827.8', ''), ('7', '2'))
    """
    if not math.isfinite(value):
        return "", ""
    decimals = digits - 1 - math.floor(math.log10(abs(value))) if value else digits - 1
    told = ""
    if math.isfinite(error) and error > 0.5 * 10.0**-decimals:
        first = math.floor(math.log10(error))
        # of 13.9 one digit would tell a third less
        decimals = min(decimals, -first + (error < 2.0 * 10.0**first))
        told = f"{round(error, decimals):.{max(decimals, 0)}f}"
    return f"{round(value, decimals):.{max(decimals, 0)}f}", told


def listed(words: Sequence[object]) -> str:
    """Words one after the other, each once, "and" before the last."""
    *others, last = map(str, dict.fromkeys(words))
    return f"{', '.join(others)} and {last}" if others else last
