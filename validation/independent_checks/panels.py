"""Panel of netting on a frame: its closed form against the drag kernel, and the fit of Cd and f on data made up.

Le Bris et al. (1999), section 4.2, equations 6 and 7; they print no measured coefficients, only what they fitted:
Cd = 1.36 and f = 0.07. So the data fitted here are MADE UP: those coefficients with noise added.
"""

from functools import cache

import numpy as np
import pandas as pd

from codend.mechanics import drag
from codend.mechanics.drag_laws import BESSONNEAU_1997, LE_BRIS_1999
from codend.report.style import BLUE, INK, ORANGE, dress, new_figure
from codend.scenes.panel import PanelFit, fit_panel, panel_coefficients
from validation.independent_checks.check import Check, Floats, Theme
from validation.section import Picture

CD, F = 1.36, 0.07
OPENINGS_DEG = (30.0, 60.0, 90.0)
INCIDENCE_DEG = np.arange(0.0, 91.0, 15.0)
NOISE, SEED, SAMPLES = 0.03, 1999, 400
LAWS: dict[str, tuple[int, float, float]] = {
    "le-bris-1999": (LE_BRIS_1999, CD, F),
    "bessonneau-1997": (BESSONNEAU_1997, 1.2, 0.1),
}


def summed(incidence_deg: float, opening_deg: float, law: str) -> tuple[float, float]:
    """Lift and drag coefficient of a panel: the kernel's loads on the four sides of a mesh laid out in space."""
    turn = np.radians(incidence_deg)
    axes = np.array([[np.cos(turn), np.sin(turn), 0.0], [0.0, 0.0, 1.0]])  # the two diagonals
    half = 0.5 * np.radians(opening_deg)
    corners = np.array([[np.cos(half), 0.0], [0.0, np.sin(half)], [-np.cos(half), 0.0], [0.0, -np.sin(half)]]) @ axes
    total = np.zeros(3)
    for side in np.roll(corners, -1, axis=0) - corners:
        total += drag.bar_drag(*LAWS[law], 1.0, 1.0, 0.0, 0.0, *side)
    return -total[1] / 4.0, total[0] / 4.0


def _summed_error(law: str) -> float:
    _, normal, tangential = LAWS[law]
    worst = 0.0
    for opening in OPENINGS_DEG:
        for incidence in (*INCIDENCE_DEG, 120.0, 165.0):
            formula = panel_coefficients(incidence, opening, normal, tangential, law)
            off = np.abs(np.array(formula) - summed(incidence, opening, law)).max()
            worst = float(np.maximum(worst, off))
    return worst


def made_up(seed: int) -> tuple[Floats, Floats, Floats, Floats]:
    """Incidence, opening, lift and drag of made-up measurements: the formula with normal noise added."""
    incidence, opening = map(np.ravel, np.meshgrid(INCIDENCE_DEG, OPENINGS_DEG, indexing="ij"))
    random = np.random.default_rng(seed)
    lift, dragged = panel_coefficients(incidence, opening, CD, F)
    return (
        incidence,
        opening,
        lift + random.normal(0.0, NOISE, lift.shape),
        dragged + random.normal(0, NOISE, lift.shape),
    )


def _fit_error_without_noise(law: str) -> float:
    _, normal, tangential = LAWS[law]
    lift, dragged = panel_coefficients(INCIDENCE_DEG, 60.0, normal, tangential, law)
    fit = fit_panel(INCIDENCE_DEG, 60.0, lift, dragged, law)
    return max(abs(fit.normal / normal - 1.0), abs(fit.tangential / tangential - 1.0))


@cache
def _fits() -> tuple[PanelFit, ...]:
    return tuple(fit_panel(*made_up(seed)) for seed in range(SEED, SEED + SAMPLES))


def _bias() -> float:
    """Mean of the fits less the truth, the larger of both coefficients, in standard deviations of that mean."""
    fits = _fits()
    found = np.array([(fit.normal - CD, fit.tangential - F) for fit in fits])
    return float(np.abs(found.mean(axis=0) / (found.std(axis=0) / np.sqrt(len(fits)))).max())


def _standard_error_error() -> float:
    """Standard errors claimed over the spread of the fits, less one, the larger of both coefficients."""
    fits = _fits()
    claimed = np.sqrt(np.mean([(fit.normal_error**2, fit.tangential_error**2) for fit in fits], axis=0))
    spread = np.std([(fit.normal, fit.tangential) for fit in fits], axis=0, ddof=1)
    return float(np.abs(claimed / spread - 1.0).max())


CHECKS = (
    *(
        Check(
            f"Lift and drag of a panel by formula are the drag kernel's loads on its four sides, summed ({law})",
            "Le Bris et al. 1999, eq. 7",
            1e-12,
            lambda _, law=law: _summed_error(law),
        )
        for law in LAWS
    ),
    *(
        Check(
            f"The fit gives back the coefficients that its data were computed with ({law})",
            "identity",
            1e-8,
            lambda _, law=law: _fit_error_without_noise(law),
        )
        for law in LAWS
    ),
    Check(
        f"Fits to {SAMPLES} sets of noisy MADE-UP data have no bias",
        "statistics: beyond 3.5 by chance once in 1000",
        3.5,
        lambda _: _bias(),
        "{error:.1f} standard deviations of their mean, allowed {tolerance:g}",
    ),
    Check(
        f"The standard errors of the fit are the spread of {SAMPLES} fits to MADE-UP data",
        "statistics: 4 standard deviations of a spread of 400 numbers",
        4.0 / np.sqrt(2.0 * SAMPLES),
        lambda _: _standard_error_error(),
        "{error:.2f} off relatively, allowed {tolerance:.2f}",
    ),
)


def pictures() -> tuple[Picture, ...]:
    """Lift and drag against incidence, with one set of made-up data and the fit to it."""
    figure = new_figure(10.0, 4.0)
    panels = figure.subplots(1, 2)
    incidence, opening, *made = made_up(SEED)
    fit = fit_panel(incidence, opening, *made)
    fine = np.linspace(0.0, 90.0, 181)
    for axes, name, part in zip(panels, ("lift", "drag"), (0, 1), strict=True):
        for beta, colour in zip(OPENINGS_DEG, (BLUE, ORANGE, INK), strict=True):
            axes.plot(fine, panel_coefficients(fine, beta, CD, F)[part], "-", color=colour, lw=1.2, label=f"{beta:g}°")
            axes.plot(
                fine, panel_coefficients(fine, beta, fit.normal, fit.tangential)[part], "--", color=colour, lw=1.0
            )
            chosen = opening == beta
            axes.plot(incidence[chosen], made[part][chosen], "o", color=colour, ms=4, mfc="none")
        axes.set(xlabel="incidence (degrees, 90 across the flow)", ylabel=f"coefficient of {name}")
        axes.set_xticks(INCIDENCE_DEG)
        dress(axes)
    panels[1].legend(title="opening", frameon=False, loc="lower right")
    caption = (
        f"Lines: formula with Cd = {CD:g}, f = {F:g}. Circles: MADE-UP data, that formula with normal noise of "
        f"{NOISE:g}; nobody measured them. Dashes: fitted to them, Cd = {fit.normal:.3f} ± {fit.normal_error:.3f}, "
        f"f = {fit.tangential:.3f} ± {fit.tangential_error:.3f} (standard errors)."
    )
    return (Picture("panels", figure, caption),)


def data() -> dict[str, pd.DataFrame]:
    """The made-up data of the picture."""
    incidence, opening, lift, dragged = made_up(SEED)
    columns = {"incidence_deg": incidence, "opening_deg": opening, "lift_made_up": lift, "drag_made_up": dragged}
    return {"panels_made_up": pd.DataFrame(columns)}


THEME = Theme(
    "Panel of netting on a frame",
    "Le Bris et al. (1999, section 4.2) turned panels of netting in a current and fitted Cd = 1.36 and f = 0.07 to "
    "their lift and drag, which they show as points in a figure without printing numbers. `codend.panel` has their "
    "formula (7) and the fit by least squares, for users with panels of their own. Here the formula is held against "
    "loads summed over a mesh laid out in space, and the fit against data that were MADE UP with known coefficients.",
    CHECKS,
    pictures,
    data,
)
