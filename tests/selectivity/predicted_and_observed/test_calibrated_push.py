"""Pushes, compression and several codends calibrated on simulated hauls with known truth; what is no calibration."""

import numpy as np
import pandas as pd
import pytest

from codend.errors import InputError
from codend.selectivity.escape.haul import Haul, hauls_of
from codend.selectivity.escape.meshes_met import Catch
from codend.selectivity.escape.penetration import Holes
from codend.selectivity.escape.predict import predict_haul
from codend.selectivity.escape.species import example_species_path, load_species
from codend.selectivity.fits.fielddata import FieldData, read_field_data
from codend.selectivity.predicted_and_observed.calibrate import Calibration, calibrate
from codend.selectivity.predicted_and_observed.retention_likelihood import Trialled
from codend.selectivity.predicted_and_observed.simulate import computed_trial
from codend.selectivity.predicted_and_observed.trial import read_trial, set_beside
from validation.calibration_study import changed

SPECIES = load_species(example_species_path())
LENGTH_CM = np.arange(4.0, 26.0, 0.5)
TRUTH = {"behaviour.push_force_n": 2.0, "spread.size": 0.06}


def haul(opening_deg: float, load_n: float, bending_n: float) -> Haul:
    """Catches whose meshes close away from the front, of no computed codend."""
    catches = []
    for case, (volume, wider) in enumerate(((0.01, 0.0), (0.03, 10.0), (0.08, 22.0)), start=1):
        rows = np.arange(1.0, 9.0)
        holes = Holes.of(
            "diamond", 0.02, opening_deg + wider - 1.5 * rows, load_n=load_n, bending_n=bending_n, rest_deg=20.0
        )
        catches.append(Catch(case, 1.0, volume, opening_deg + wider, holes, rows, np.ones(8)))
    return hauls_of(catches)[0]


LIMP, STIFF = haul(30.0, 3.0, 0.0), haul(24.0, 3.0, 10.0)


def trial(of: Haul, seed: int = 1, fish: float = 30.0, **truth: float) -> FieldData:
    table = computed_trial(
        of,
        changed(SPECIES, TRUTH | {f"behaviour.{name}": value for name, value in truth.items()}),
        "covered",
        volume_m3=np.array([0.3, 0.6, 1.0]) * of.volume_m3[-1],
        length_cm=LENGTH_CM,
        expected_fish=np.full(len(LENGTH_CM), fish),
        rng=np.random.default_rng(seed),
    )
    return read_field_data(table, "covered")


def volumes(of: Haul) -> np.ndarray:
    return np.array([0.3, 0.6, 1.0]) * of.volume_m3[-1]


def calibrated(data: FieldData, *names: str, also: tuple[Trialled, ...] = ()) -> Calibration:
    return calibrate(LIMP, SPECIES, data, names, volume_m3=volumes(LIMP), also=also)


@pytest.mark.parametrize("seed", [1, 2])
def test_a_push_is_found_on_hauls_that_were_drawn_with_it(seed):
    found = calibrated(trial(LIMP, seed), "push", "spread")
    assert found.explains, found.message
    assert found.identified.all()
    truth = np.array(list(TRUTH.values()))
    assert ((found.lower_95 <= truth) & (truth <= found.upper_95)).all()
    assert found.species.behaviour.push_force_n.source.startswith("calibrated on")


def test_two_codends_jointly_tell_a_push_better_than_either():
    one, other = trial(LIMP), trial(STIFF, 2)
    alone = calibrated(one, "push", "compression", "spread")
    joint = calibrated(one, "push", "compression", "spread", also=(Trialled(STIFF, other, volumes(STIFF)),))
    assert joint.explains, joint.message
    assert joint.degrees_of_freedom > alone.degrees_of_freedom
    assert joint.lower_95[0] <= TRUTH["behaviour.push_force_n"] <= joint.upper_95[0]
    assert joint.upper_95[0] / joint.lower_95[0] < alone.upper_95[0] / alone.lower_95[0]
    assert joint.species.section.height_compression == joint.species.section.width_compression


def test_a_number_at_the_end_of_its_range_is_not_identified_and_stays_assumed():
    """Of small fish all get out: contact is as large as it may be."""
    table = pd.DataFrame({"haul": 1, "length_cm": [1.0, 2.0], "codend": [0, 0], "cover": [120, 124]})
    found = calibrate(LIMP, SPECIES, read_field_data(table, "covered"), ["contact"])
    assert found.converged
    assert found.at_bound.tolist() == [True]
    assert found.identified.tolist() == [False]
    assert "at the end of what is allowed" in found.message
    assert "behaviour.contact" in found.species.assumed


def test_fish_that_no_numbers_explain_are_no_calibration_and_give_no_species(tmp_path):
    table = computed_trial(
        LIMP,
        changed(SPECIES, TRUTH),
        "covered",
        volume_m3=volumes(LIMP),
        length_cm=LENGTH_CM,
        expected_fish=np.full(len(LENGTH_CM), 100.0),
        rng=np.random.default_rng(1),
    )
    table[["codend", "cover"]] = table[["cover", "codend"]]  # the small are kept, the large get out
    file = tmp_path / "hauls.csv"
    table.to_csv(file, index=False)
    prediction = predict_haul(SPECIES, LIMP, n_bootstrap=0, samples=0)
    (found,) = set_beside([prediction], read_trial(file, 1000.0, "covered"), ["push", "contact"])
    assert found.calibration is not None
    assert not found.calibration.explains
    assert not found.calibration.identified.any()
    assert found.calibration.species == SPECIES
    assert found.calibrated is None


def test_the_splits_of_several_codends_are_not_estimated_together():
    with pytest.raises(InputError, match="jointly"):
        calibrate(LIMP, SPECIES, trial(LIMP), ["push"], estimate_split=True, also=[Trialled(STIFF, trial(STIFF))])
