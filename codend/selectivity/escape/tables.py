"""Predicted selectivity as tables: ``selectivity.csv``, ``retention.csv`` and ``sensitivity.csv``."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd

from codend.selectivity.escape.meshes_met import Catch
from codend.selectivity.escape.predict import Prediction

HAUL = "haul"
"""Name in the column ``case`` of the row for the whole haul."""


def selectivity_table(predictions: Sequence[Prediction]) -> pd.DataFrame:
    """A row a case and species, and one for the whole haul; ``assumed`` names the numbers nobody measured.

    ``l50_cm`` is of fish that meet the catch of a row, ``haul_l50_cm`` of a whole haul that ends with it, both off the
    computed curve; ``l50_logit_cm`` and ``haul_l50_logit_cm`` are of logit curves fitted to those. What a trial would
    report is ``haul_l50_logit_cm``; in the row of the haul ``l50_logit_cm`` is the same, and has an interval, in which
    the error of the openings is (``l50_opening_error_cm``).

    The volume of a haul is that of its last catch, its opening the mean over time. ``largest_share_l50`` names the
    number that makes most of the variance of L50, by total Sobol index, and ``share_l50`` is that index; likewise SR.
    """
    frames = []
    for found in predictions:
        share = found.haul.time_shares(found.species)
        opening = np.array([catch.opening_ahead_deg for catch in found.haul.catches])
        inside_mm = np.array([_inside_mesh_mm(catch) for catch in found.haul.catches])
        volume = found.haul.volume_m3
        frame = pd.DataFrame(
            {
                "case": _cases(found),
                "species": found.species.name,
                "catch_volume_m3": np.append(volume, volume[-1]),
                "l50_cm": found.l50_sr[:, 0],
                "sr_cm": found.l50_sr[:, 1],
                "speed_m_s": found.haul.speed_m_s,
                "opening_ahead_deg": np.append(opening, share @ opening),
                "l50_logit_cm": found.logit[:, 0],
                "l50_lower_95_cm": found.lower_95[:, 0],
                "l50_upper_95_cm": found.upper_95[:, 0],
                "sr_logit_cm": found.logit[:, 1],
                "sr_lower_95_cm": found.lower_95[:, 1],
                "sr_upper_95_cm": found.upper_95[:, 1],
                "haul_l50_cm": np.append(found.end_l50_sr[:, 0], found.l50_sr[-1, 0]),
                "haul_sr_cm": np.append(found.end_l50_sr[:, 1], found.l50_sr[-1, 1]),
                "haul_l50_logit_cm": np.append(found.end_logit[:, 0], found.logit[-1, 0]),
                "haul_sr_logit_cm": np.append(found.end_logit[:, 1], found.logit[-1, 1]),
                "l50_opening_error_cm": found.opening_reach[:, 0],
                "sr_opening_error_cm": found.opening_reach[:, 1],
                "contact": found.contact,
                "inside_mesh_mm": np.append(inside_mm, share @ inside_mm),
            }
        )
        of_haul = frame["case"] == HAUL
        for q, quantity in enumerate(("l50", "sr")):
            total = np.empty(0) if found.sensitivity is None else found.sensitivity.total[:, q]
            known = bool(total.size) and bool(np.isfinite(total).all())
            name = found.sensitivity.parameters[int(total.argmax())] if known and found.sensitivity else ""
            frame[f"largest_share_{quantity}"] = np.where(of_haul, name, "")
            frame[f"share_{quantity}"] = np.where(of_haul, total.max() if known else np.nan, np.nan)
        frame["assumed"] = " ".join(found.species.assumed)
        frames.append(frame)
    return pd.concat(frames, ignore_index=True)


def retention_table(predictions: Sequence[Prediction]) -> pd.DataFrame:
    """A row a case, species and length; the haul with the bands of its finite number of fish and of the assumptions."""
    frames = []
    for found in predictions:
        rows, classes = found.retention.shape
        frame = pd.DataFrame(
            {
                "case": np.repeat(np.array(_cases(found), dtype=object), classes),
                "species": found.species.name,
                "length_cm": np.tile(found.length_cm, rows),
                "retention": found.retention.ravel(),
                "speed_m_s": found.haul.speed_m_s,
            }
        )
        bands = {"fish": found.fish_band, "ranges": found.sensitivity.band if found.sensitivity else None}
        for name, band in bands.items():
            for i, end in enumerate(("lower", "upper")):
                frame[f"{name}_{end}_95"] = np.nan
                if band is not None:
                    frame.loc[frame["case"] == HAUL, f"{name}_{end}_95"] = band[i]
        frames.append(frame)
    return pd.concat(frames, ignore_index=True)


def sensitivity_table(predictions: Sequence[Prediction]) -> pd.DataFrame:
    """A row a species, speed and number with a range: the haul's L50 and SR at both its ends, and its Sobol indices."""
    columns = ["species", "speed_m_s", "parameter", "value", "low", "high", "source"]
    for quantity in ("l50", "sr"):
        columns += [f"{quantity}_at_low_cm", f"{quantity}_at_high_cm"]
        columns += [f"{quantity}_first_order", f"{quantity}_total"]
    rows = []
    for found in predictions:
        effects = found.sensitivity
        for i, name in enumerate(effects.parameters if effects else ()):
            number = found.species.number(name)
            assert effects is not None
            assert number is not None
            row = [found.species.name, found.haul.speed_m_s, name, number.value, *effects.ranges[i], number.source]
            for q in range(2):
                row += [*effects.one_at_a_time[i, :, q], effects.first_order[i, q], effects.total[i, q]]
            rows.append(row)
    return pd.DataFrame(rows, columns=columns)


def _inside_mesh_mm(catch: Catch) -> float:
    """Inside mesh 2 b + l of the row of meshes nearest to the front, mean over the row, as fish meet it."""
    nearest = catch.rows_ahead == catch.rows_ahead.min()
    return 1000.0 * float(np.mean((2.0 * catch.holes.bar_m + catch.holes.knot_m)[nearest]))


def _cases(found: Prediction) -> list[str]:
    return [*(str(catch.case) for catch in found.haul.catches), HAUL]
