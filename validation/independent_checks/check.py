"""What an independent check is: a claim with its source and tolerance, and the error found."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from codend.report.style import dress
from validation.section import Picture

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Check:
    """A claim that is true if the error found does not exceed the tolerance."""

    claim: str
    source: str
    """Paper, equation or derivation that gives the right answer."""
    tolerance: float
    error: Callable[[bool], float]
    """The error found; given whether a quick, coarser version will do."""
    words: str = "error {error:.1e}, tolerance {tolerance:.1e}"
    """How error and tolerance are told."""


@dataclass(frozen=True)
class Theme:
    """Checks that belong together, and how they are shown."""

    title: str
    text: str
    """Markdown that tells what is compared with what."""
    checks: tuple[Check, ...]
    pictures: Callable[[], tuple[Picture, ...]] = tuple
    data: Callable[[], Mapping[str, "pd.DataFrame"]] = dict


@dataclass(frozen=True)
class Convergence:
    """How the error of a model falls as it is given more parts."""

    label: str
    error_of: Callable[[int], float]
    """Error with a number of parts."""
    parts: tuple[int, ...]
    unit: str = "bars"
    """What is counted."""

    @cached_property
    def errors(self) -> Floats:
        """Error with every number of parts."""
        return np.array([self.error_of(parts) for parts in self.parts])

    @property
    def order(self) -> float:
        """Minus the slope of the errors over the parts, logarithms fitted by least squares."""
        return float(-np.polyfit(np.log(self.parts), np.log(self.errors), 1)[0])

    def checks(self, claim: str, source: str, tolerance: float, order_tolerance: float = 0.1) -> tuple[Check, Check]:
        """That the finest model is near enough, and that the error falls with the second order."""
        return (
            Check(f"{claim}, with {self.parts[-1]} {self.unit}", source, tolerance, lambda _: float(self.errors[-1])),
            Check(
                f"{claim}: the error falls with order 2",
                "the order is found by fit",
                order_tolerance,
                lambda _: abs(self.order - 2.0),
                "order off by {error:.2f}, allowed {tolerance:g}",
            ),
        )


def draw_convergence(axes: "Axes", families: tuple[Convergence, ...], parts: str) -> None:
    """Errors over the number of parts, both logarithmic, with the order found and a line of second order."""
    for family, marker in zip(families, "osv^DPX", strict=False):
        axes.loglog(family.parts, family.errors, marker=marker, ms=5, label=f"{family.label}: {family.order:.2f}")
    counts = np.unique([n for family in families for n in family.parts])
    most = max(float(family.errors[0]) for family in families)
    axes.loglog(counts, 2.0 * most * (counts[0] / counts) ** 2, "k:", lw=1, label="second order")
    axes.set(xlabel=parts, ylabel="relative error")
    axes.set_xticks(counts, [str(n) for n in counts])
    axes.minorticks_off()
    dress(axes)
    axes.legend(title="order found", fontsize="small", frameon=False, loc="center left", bbox_to_anchor=(1.01, 0.5))


def convergence_table(families: tuple[Convergence, ...], parts: str) -> "pd.DataFrame":
    """A row a model and number of parts."""
    import pandas as pd

    return pd.DataFrame(
        [
            {"case": family.label, parts: n, "relative_error": error, "order_found": family.order}
            for family in families
            for n, error in zip(family.parts, family.errors, strict=True)
        ]
    )
