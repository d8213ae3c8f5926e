"""Three L50s told apart, the error of the openings in their intervals, and none where there is none."""

import numpy as np
import pytest

from codend.report.selectivity_words import answers, notes
from codend.selectivity.escape.haul import hauls_of, shares_until, terms_of_catches, terms_of_haul
from codend.selectivity.escape.haul_ends import moved_by_opening_error
from codend.selectivity.escape.meshes_met import Catch
from codend.selectivity.escape.penetration import Holes
from codend.selectivity.escape.predict import Prediction, predict_haul
from codend.selectivity.escape.species import example_species_path, load_species
from codend.selectivity.escape.tables import HAUL, selectivity_table

SPECIES = load_species(example_species_path())


def catch(case: int, volume_m3: float, opening_deg: float, error_deg: float) -> Catch:
    holes = Holes.of("diamond", 0.05, np.full(8, opening_deg))
    return Catch(case, 1.5, volume_m3, opening_deg, holes, 1.0 + np.arange(8), np.ones(8), opening_error_deg=error_deg)


def predicted(error_deg: float = 0.0, wider_deg: float = 0.0, species=SPECIES) -> Prediction:
    sizes = ((0.1, 20.0), (0.4, 30.0), (1.0, 45.0))
    catches = [catch(i, v, o + wider_deg, error_deg) for i, (v, o) in enumerate(sizes, start=1)]
    return predict_haul(species, hauls_of(catches)[0], n_bootstrap=200, samples=0)


def test_a_haul_that_ends_with_a_catch_has_the_l50_of_its_catches_up_to_it():
    found = predicted()
    terms = terms_of_catches(found.haul, SPECIES)
    for i, volume in enumerate(found.haul.volume_m3):
        whole = terms_of_haul(found.haul, terms, SPECIES, shares_until(found.haul, SPECIES, float(volume)))
        np.testing.assert_allclose(found.end_l50_sr[i], whole.l50_sr(), rtol=1e-3)
    np.testing.assert_allclose(found.end_l50_sr[0], found.l50_sr[0], rtol=1e-3)
    np.testing.assert_allclose(found.end_l50_sr[-1], found.l50_sr[-1], rtol=1e-3)
    np.testing.assert_allclose(found.end_logit[-1], found.logit[-1], rtol=1e-6)


def test_the_table_names_three_l50s_and_those_of_hauls_lag_behind_those_of_fish_that_meet_the_catch():
    table = selectivity_table([predicted()]).set_index("case")
    assert (table.loc[["2", "3"], "haul_l50_cm"] < table.loc[["2", "3"], "l50_cm"]).all()
    assert table.loc[HAUL, "haul_l50_logit_cm"] == table.loc[HAUL, "l50_logit_cm"]
    assert table.loc[HAUL, "haul_l50_cm"] == table.loc[HAUL, "l50_cm"]


def test_the_error_of_the_openings_is_what_wider_meshes_change_and_widens_the_interval():
    moved = moved_by_opening_error(predicted(2.0).haul, SPECIES)
    change = [predicted(wider_deg=w).l50_sr[:, 0] - predicted().l50_sr[:, 0] for w in (2.0, -2.0)]
    np.testing.assert_allclose(moved[:, 0], np.abs(change).max(axis=0), rtol=0.05)
    exact, off = predicted(), predicted(2.0)
    for i in (0, -1):
        width = np.hypot(exact.upper_95[i, 0] - exact.logit[i, 0], moved[i, 0])
        np.testing.assert_allclose(off.upper_95[i, 0] - off.logit[i, 0], width, rtol=1e-9)
    assert "no error estimate" in " ".join(notes([predicted(np.nan)]))


def test_the_answer_is_that_of_a_trial_and_the_notes_say_that_meshes_are_rigid_without_a_push():
    found = predicted()
    (answer,) = answers([found])
    assert f"L50 {found.logit[-1, 0]:.1f} cm (95 % {found.lower_95[-1, 0]:.1f} to" in answer
    assert "as a trial would report it" in answer
    assert "every mesh is taken as rigid" in " ".join(notes([found]))


@pytest.mark.parametrize(("to_cm", "word"), [(8.0, "longest tabled"), (60.0, "")])
def test_an_l50_lies_within_the_lengths_or_is_none_with_a_word(to_cm, word):
    lengths = SPECIES.lengths.model_copy(update={"to_cm": to_cm})
    found = predicted(species=SPECIES.model_copy(update={"lengths": lengths}))
    inside = found.l50_sr[np.isfinite(found.l50_sr[:, 0]), 0]
    assert ((inside >= 5.0) & (inside <= to_cm)).all()
    assert np.isnan(found.logit[-1]).all() == bool(word)
    assert word in answers([found])[0]


def test_a_haul_of_many_catches_retains_no_more_than_all_fish_of_a_length():
    """Shares of the haul's time add to one but for round-off, whatever their number."""
    volumes = np.linspace(0.1, 1.0, 13)
    catches = [catch(i, v, 25.0, 0.0) for i, v in enumerate(volumes, start=1)]
    found = predict_haul(SPECIES, hauls_of(catches)[0], n_bootstrap=20, samples=0)
    assert found.retention.max() == 1.0
    assert np.isfinite(found.lower_95[-1]).all()
