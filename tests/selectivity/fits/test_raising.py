"""Raised totals, and counts with factors, are told apart, and it is said why their answers differ."""

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner

from codend.cli.main import main
from codend.errors import InputError
from codend.selectivity.fits.analysis import fit_field_data

LENGTH_CM = np.arange(22.0, 46.0, 2.0)


def hauls(cover_factor: float = 1.0, raised: bool = False) -> pd.DataFrame:
    """Four hauls, their cover counted to one part in ``cover_factor``, and if asked its counts raised."""
    rng, frames = np.random.default_rng(1), []
    for haul in range(4):
        met = rng.poisson(60.0, len(LENGTH_CM))
        kept = rng.binomial(met, 1.0 / (1.0 + np.exp(-0.5 * (LENGTH_CM - 33.0))))
        counted = rng.binomial(met - kept, 1.0 / cover_factor)
        cover = counted * int(cover_factor) if raised else counted
        frames.append(pd.DataFrame({"haul": haul, "length_cm": LENGTH_CM, "codend": kept, "cover": cover}))
    return pd.concat(frames, ignore_index=True)


def said(table: pd.DataFrame) -> str:
    return " ".join(fit_field_data(table, "covered").data.notes)


def test_counts_with_factors_say_what_they_stand_for_and_whose_the_errors_are():
    text = said(hauls(10.0).assign(cover_raising=10.0))
    assert "raised by 10" in text
    assert "errors are those of the fish counted" in text
    assert "multiples" not in text


def test_raised_totals_without_factors_are_seen_and_it_is_said_why_their_answers_differ():
    text = said(hauls(10.0, raised=True))
    assert "cover: all counts are multiples of 10" in text
    assert "errors too small" in text
    assert "codend" not in text.split("multiples")[0]


def test_fish_raised_twice_are_seen():
    assert "raised twice" in said(hauls(10.0, raised=True).assign(cover_raising=10.0))


def test_plain_counts_are_not_suspected():
    assert "multiples" not in said(hauls())


def test_raised_totals_taken_for_counts_have_errors_too_small_by_about_the_root_of_the_factor():
    def errors(table: pd.DataFrame) -> float:
        pooled = fit_field_data(table, "covered", random="none", overdispersion="none").pooled.estimates
        return float(pooled.standard_errors[pooled.names.index("l50_cm")])

    assert errors(hauls(10.0, raised=True)) < 0.8 * errors(hauls(10.0).assign(cover_raising=10.0))


def test_raised_numbers_that_are_not_whole_are_refused_with_the_reason():
    with pytest.raises(InputError, match=r"cover_raising; fitted as counts they make errors too small"):
        fit_field_data(hauls().assign(cover=lambda t: 1.5 * t["cover"] + 0.25), "covered")


def test_the_command_says_unit_and_place_of_lengths_and_what_raising_does(tmp_path):
    hauls(10.0).assign(cover_raising=10.0).to_csv(tmp_path / "hauls.csv", index=False)
    asked = ["fit", str(tmp_path / "hauls.csv"), "--design", "covered", "--out", str(tmp_path / "out")]
    output = CliRunner().invoke(main, asked).output
    assert "(in cm)" in output
    assert "middle of each class" in output
    assert "raised by 10" in output
