"""Predicted beside fitted retention, and numbers of a species calibrated on simulated trials with known truth."""

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner
from matplotlib.axes import Axes
from matplotlib.collections import PathCollection, PolyCollection
from matplotlib.container import ErrorbarContainer
from matplotlib.lines import Line2D

from catch_models.fish import Species
from codend.cli.main import main
from codend.errors import InputError
from codend.report.selectivity_page import write_selectivity
from codend.report.together_plot import together_plot
from codend.selectivity.escape.haul import hauls_of, shares_until, time_shares
from codend.selectivity.escape.meshes_met import Catch
from codend.selectivity.escape.penetration import Holes
from codend.selectivity.escape.predict import Prediction, predict_haul
from codend.selectivity.escape.species import example_species_path, load_species, species_toml
from codend.selectivity.fits.fielddata import read_field_data
from codend.selectivity.fits.fit import fit_pooled
from codend.selectivity.fits.model import selection_model
from codend.selectivity.predicted_and_observed.calibrate import Calibration, calibrate
from codend.selectivity.predicted_and_observed.simulate import computed_trial
from codend.selectivity.predicted_and_observed.together import FieldTrial, together_table
from codend.selectivity.predicted_and_observed.together_l50 import as_counted, haul_l50_sr, together_l50_table
from codend.selectivity.predicted_and_observed.trial import check_selection, read_trial, set_beside
from validation.calibration_study import changed

SPECIES = load_species(example_species_path())
LENGTH_CM = np.arange(4.0, 22.0, 0.5)
TRUTH = {"behaviour.contact": 0.8, "spread.size": 0.08}


def catch(case: int, volume_m3: float, opening_deg: float) -> Catch:
    """Ten rows of meshes that close away from the front; openings of no computed codend."""
    rows = np.arange(1.0, 11.0)
    holes = Holes.of("diamond", 0.02, opening_deg - 1.5 * rows, knot_m=0.004, load_n=3.0)
    return Catch(case, 1.0, volume_m3, opening_deg, holes, rows, np.ones(10))


HAUL = hauls_of([catch(1, 0.01, 35.0), catch(2, 0.03, 48.0), catch(3, 0.08, 60.0)])[0]
VOLUME_M3 = np.array([0.3, 0.6, 1.0]) * HAUL.volume_m3[-1]


def trial(
    design: str = "covered", seed: int = 1, *, fish: float = 30.0, split: float = 0.5, contact: float = 0.8
) -> pd.DataFrame:
    rng = np.random.default_rng(seed)
    return computed_trial(
        HAUL,
        changed(SPECIES, TRUTH | {"behaviour.contact": contact}),
        design,
        volume_m3=VOLUME_M3,
        length_cm=LENGTH_CM,
        expected_fish=np.full(len(LENGTH_CM), fish),
        rng=rng,
        split=split,
    )


def calibrated(table: pd.DataFrame, design: str = "covered", *names: str, split: bool = False) -> Calibration:
    data = read_field_data(table, design)
    return calibrate(HAUL, SPECIES, data, names or ("contact", "spread"), estimate_split=split, volume_m3=VOLUME_M3)


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    path = tmp_path_factory.mktemp("field") / "hauls.csv"
    path.write_text("# SIMULATED fish\n" + trial().to_csv(index=False), encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def together(file):
    found = [predict_haul(SPECIES, HAUL, n_bootstrap=0, samples=8)]
    return set_beside(found, read_trial(file, 1000.0, "covered"), ["contact", "spread"])


# --- hauls that end early --------------------------------------------------------------------------------------------


def test_a_haul_that_ends_with_a_computed_catch_has_the_time_shares_of_the_catches_up_to_it():
    np.testing.assert_allclose(shares_until(HAUL, SPECIES, HAUL.volume_m3[-1]), HAUL.time_shares(SPECIES), rtol=1e-12)
    time = HAUL.time(SPECIES)[:2]
    shares = shares_until(HAUL, SPECIES, HAUL.volume_m3[1])
    np.testing.assert_allclose(shares, [*time_shares(time / time[-1]), 0.0], rtol=1e-12)


def test_a_haul_that_ends_before_the_smallest_catch_rests_on_it():
    np.testing.assert_allclose(shares_until(HAUL, SPECIES, 0.5 * HAUL.volume_m3[0]), [1.0, 0.0, 0.0])


# --- calibration -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("design", "split"), [("covered", 0.5), ("paired", 0.5), ("paired", 0.6)])
@pytest.mark.parametrize("seed", [1, 2])
def test_numbers_that_a_simulated_trial_was_drawn_with_lie_in_the_intervals(design, split, seed):
    fish = 30.0 if design == "covered" else 120.0
    found = calibrated(trial(design, seed, fish=fish, split=split), design, split=split != 0.5)
    assert found.converged, found.message
    truth = np.array([*TRUTH.values(), split])[: len(found.names)]
    assert found.identified.all()
    assert ((found.lower_95 <= truth) & (truth <= found.upper_95)).all()
    assert (np.abs(found.values - truth) < 0.5 * (found.upper_95 - found.lower_95)).all()


def test_many_more_fish_bring_the_truth_within_a_hundredth():
    found = calibrated(trial(fish=20_000.0))
    np.testing.assert_allclose(found.values, list(TRUTH.values()), rtol=0.01)
    assert (found.upper_95 - found.lower_95 < 0.05 * found.values).all()


def test_contact_alone_agrees_with_the_closed_form_where_every_fish_that_tries_gets_out():
    """Far below all meshes retention is 1 - contact: a binomial share with its own likelihood interval."""
    table = pd.DataFrame({"haul": 1, "length_cm": [1.0, 2.0], "codend": [30, 26], "cover": [120, 124]})
    found = calibrate(HAUL, SPECIES, read_field_data(table, "covered"), ["contact"])
    np.testing.assert_allclose(found.values, 244 / 300, rtol=1e-4)

    def fall(contact: float) -> float:
        return 2.0 * (56 * np.log(56 / 300 / (1 - contact)) + 244 * np.log(244 / 300 / contact))

    for end in (found.lower_95[0], found.upper_95[0]):
        np.testing.assert_allclose(fall(end), 3.8415, rtol=0.03)


def test_a_number_that_the_fish_do_not_tell_is_said_to_be_unknown_and_stays_assumed():
    """Fish far too small for any mesh: whatever their spread they get out."""
    table = pd.DataFrame({"haul": 1, "length_cm": [0.01, 0.02], "codend": [30, 26], "cover": [120, 124]})
    found = calibrate(HAUL, SPECIES, read_field_data(table, "covered"), ["contact", "shape"])
    assert found.converged
    assert found.identified.tolist() == [True, False]
    assert "not identified" in found.message
    assert "spread.shape" in found.message
    assert "spread.shape" in found.species.assumed
    assert "behaviour.contact" not in found.species.assumed


def test_a_catch_larger_than_any_computed_and_unknown_names_are_refused():
    data = read_field_data(trial(), "covered")
    with pytest.raises(InputError, match="add larger catches"):
        calibrate(HAUL, SPECIES, data, ["contact"], volume_m3=2.0 * VOLUME_M3)
    for names in (["luck"], ["contact", "behaviour.contact"], []):
        with pytest.raises(InputError, match="contact"):
            calibrate(HAUL, SPECIES, data, names)


def test_a_calibrated_species_is_read_back_equal_and_names_its_source(together, tmp_path):
    calibration = together[0].calibration
    path = tmp_path / "species.toml"
    path.write_text(species_toml(calibration.species), encoding="utf-8")
    again: Species = load_species(path)
    assert again == calibration.species
    assert again.behaviour.contact.source == "calibrated on hauls.csv (simulated fish)"
    assert again.ranges["behaviour.contact"] == (calibration.lower_95[0], calibration.upper_95[0])


# --- together --------------------------------------------------------------------------------------------------------


def test_the_table_has_the_prediction_the_fit_and_the_fish_of_every_length(together):
    table = together_table(together).set_index("length_cm")
    one = together[0]
    np.testing.assert_allclose(table.loc[SPECIES.length_cm, "predicted_retention"], one.prediction.retention[-1])
    counted = trial().groupby("length_cm")[["codend", "cover"]].sum()
    observed = (counted["codend"] / counted.sum(axis=1)).to_numpy()
    np.testing.assert_allclose(table.loc[counted.index, "observed_retention"], observed)
    assert table["observed_retention"].notna().sum() == len(LENGTH_CM)
    assert (table["fitted_lower_95"] <= table["fitted_retention"]).all()
    assert (table["fitted_retention"] <= table["fitted_upper_95"]).all()
    trial_mean = np.mean([_retention_until(one.prediction, volume, one.length_cm) for volume in VOLUME_M3], axis=0)
    np.testing.assert_allclose(table["predicted_trial_retention"], trial_mean, rtol=1e-9)
    assert (table["field_fish"] == "simulated").all()
    assert table["assumed"].str.contains("behaviour.contact").all()


def _retention_until(prediction: Prediction, volume_m3: float, length_cm: np.ndarray) -> np.ndarray:
    share = shares_until(prediction.haul, prediction.species, volume_m3)
    return share @ [terms.retention(length_cm) for terms in prediction.terms[:-1]]


def test_the_fitted_curve_is_one_half_at_its_l50_with_the_interval_of_a_logit(file):
    from codend.selectivity.fits.analysis import fit_field_data
    from codend.selectivity.predicted_and_observed.together import fitted_retention

    one_haul = pd.read_csv(file, comment="#").query("haul == 1")
    for curve in ("logit", "richards"):
        fit = fit_field_data(one_haul, "covered", curve)
        found, (lower, upper) = fitted_retention(
            FieldTrial(fit, simulated=True, volume_m3=None), np.array([fit.pooled.estimates["l50_cm"]])
        )
        np.testing.assert_allclose(found, 0.5, rtol=1e-9)
        i = fit.pooled.estimates.names.index("l50_cm")
        if curve == "logit":  # a + b L has standard error b se(L50) where it is zero
            width = 1.959964 * fit.pooled.estimates["b"] * fit.pooled.estimates.standard_errors[i]
            np.testing.assert_allclose([lower[0], upper[0]], 1.0 / (1.0 + np.exp([width, -width])), rtol=1e-6)


@pytest.mark.parametrize("split", ["equal", "estimated"])
def test_observed_retention_of_paired_gear_is_scaled_by_the_split(split, tmp_path):
    path = tmp_path / "paired.csv"
    path.write_text(trial("paired", fish=2000.0, split=0.6, contact=1.0).to_csv(index=False), encoding="utf-8")
    found = predict_haul(SPECIES, HAUL, n_bootstrap=0, samples=0)
    (one,) = set_beside([found], read_trial(path, 1000.0, "paired", split=split))
    p = one.trial.fit.pooled.estimates["split"]
    counted = pd.read_csv(path).groupby("length_cm")[["test", "control"]].sum()
    expected = (counted["test"] / counted["control"] * (1.0 - p) / p).to_numpy()
    np.testing.assert_allclose(one.observed[one.fish > 0.0], expected, rtol=1e-12)
    assert (p == 0.5) == (split == "equal")


def test_l50_against_the_catch_holds_every_haul_its_catch_and_both_kinds_of_computed_l50(together):
    table = together_l50_table(together)
    hauls = table[table["what"] == "field haul"]
    np.testing.assert_allclose(hauls["catch_volume_m3"], VOLUME_M3)
    one = together[0]
    np.testing.assert_allclose(table.loc[table["what"] == "predicted catch", "l50_cm"], one.prediction.l50_sr[:-1, 0])
    of_haul = haul_l50_sr(one.prediction)
    np.testing.assert_allclose(of_haul[-1], one.prediction.l50_sr[-1], rtol=1e-9)
    assert (of_haul[1:, 0] < one.prediction.l50_sr[1:-1, 0]).all()  # a haul holds its own beginning
    data = one.trial.data
    pooled = fit_pooled(data, selection_model(data, "logit"))
    np.testing.assert_allclose(one.trial.fit.pooled.estimates["l50_cm"], pooled.estimates["l50_cm"])


@pytest.mark.parametrize(("design", "split"), [("covered", 0.5), ("paired", 0.6)])
def test_fish_without_chance_are_fitted_with_the_l50_and_sr_predicted_for_their_hauls(design, split, tmp_path):
    """The trial's own numbers of fish as expected: the same fit at the same catches finds the same.

    But for the split of paired gear, which the trial estimates with a curve that is not the true one.
    """
    path = tmp_path / "hauls.csv"
    table = trial(design, fish=1e9, split=split, contact=0.95)  # Poisson numbers of so many are their means
    path.write_text(table.to_csv(index=False), encoding="utf-8")
    truth = predict_haul(changed(SPECIES, TRUTH | {"behaviour.contact": 0.95}), HAUL, n_bootstrap=0, samples=0)
    splits = "estimated" if design == "paired" else "equal"
    (one,) = set_beside([truth], read_trial(path, 1000.0, design, split=splits))
    rows = together_l50_table([one]).set_index("what")
    for end in ("haul", "mean"):
        computed, field = rows.loc[[f"predicted field {end}"]], rows.loc[[f"field {end}"]]
        assert computed["name"].tolist() == field["name"].tolist()
        np.testing.assert_allclose(computed["catch_volume_m3"], field["catch_volume_m3"])
        np.testing.assert_allclose(computed[["l50_cm", "sr_cm"]], field[["l50_cm", "sr_cm"]], rtol=3e-3)
    off_curve = rows.loc["predicted haul", "l50_cm"].iloc[-1]  # of the same catch as the last field haul's
    assert abs(off_curve - rows.loc["field haul", "l50_cm"].iloc[-1]) > 0.1


def test_raised_fish_are_shared_as_the_likelihood_has_it(file):
    """A covered haul counted in part: retained over all fish, raised, is the computed retention."""
    half = pd.read_csv(file, comment="#").assign(codend_raising=2.0, cover_raising=5.0)
    path = file.parent / "raised.csv"
    half.to_csv(path, index=False)
    found = predict_haul(SPECIES, HAUL, n_bootstrap=0, samples=0)
    field = read_trial(path, 1000.0, "covered")
    counted = as_counted(found, field)
    raised = counted.test_count * 2.0, counted.other_count * 5.0
    own = field.data.haul == 0
    expected = _retention_until(found, VOLUME_M3[0], field.data.length_cm[own])
    np.testing.assert_allclose((raised[0] / (raised[0] + raised[1]))[own], expected, rtol=1e-9)
    np.testing.assert_allclose(counted.test_count + counted.other_count, field.data.test_count + field.data.other_count)


def test_every_row_says_what_its_l50_is_of_and_a_catch_beyond_the_computed_has_no_prediction(together, file):
    table = together_l50_table(together)
    said = table.groupby("what")["l50_of"].unique().map(list).to_dict()
    assert said.pop("field haul") == said.pop("field mean") == ["logit fitted to the fish"]
    computed = {what for what, of in said.items() if of == ["computed curve"]}
    assert computed == {"predicted catch", "predicted haul", "calibrated haul"}
    fitted = {f"{kind} field {end}" for kind in ("predicted", "calibrated") for end in ("haul", "mean")}
    assert {what for what, of in said.items() if of == ["logit fitted to the computed curve"]} == fitted
    beyond = pd.read_csv(file, comment="#")
    beyond["catch_volume_m3"] *= 2.0
    path = file.parent / "beyond.csv"
    beyond.to_csv(path, index=False)
    (one,) = set_beside([together[0].prediction], read_trial(path, 1000.0, "covered"))
    assert not together_l50_table([one])["what"].str.startswith("predicted field").any()


def test_a_mass_becomes_a_volume_by_the_density_of_the_plan(tmp_path):
    path = tmp_path / "hauls.csv"
    table = trial().rename(columns={"catch_volume_m3": "catch_kg"})
    table["catch_kg"] *= 800.0
    path.write_text(table.to_csv(index=False), encoding="utf-8")
    np.testing.assert_allclose(read_trial(path, 800.0, "covered").volume_m3, VOLUME_M3)
    table["catch_kg"] = np.arange(len(table)) + 1.0
    path.write_text(table.to_csv(index=False), encoding="utf-8")
    with pytest.raises(InputError, match="changes within its haul"):
        read_trial(path, 800.0, "covered")


def test_what_is_written_goes_again_when_no_trial_is_given(together, tmp_path):
    predictions = [one.prediction for one in together]
    written = write_selectivity(predictions, tmp_path, together)
    names = {
        "together.csv",
        "together_l50.csv",
        "calibration.csv",
        "calibrated_species.toml",
        "selectivity_together.png",
    }
    assert names <= {path.name for path in written}
    again = write_selectivity(predictions, tmp_path)
    assert not names & {path.name for path in again}
    assert not any((tmp_path / name).exists() for name in names)


def drawn(axes: Axes) -> dict[str, bool]:
    """Whether there is anything to see of what the legend names."""
    seen = {}
    for artist, label in zip(*axes.get_legend_handles_labels(), strict=True):
        match artist:
            case Line2D():
                fits = np.isfinite(artist.get_xydata()).all(axis=1)
                marked = artist.get_marker() not in (None, "None", "")
                seen[label] = bool(fits.any() if marked else (fits[1:] & fits[:-1]).any())
            case PathCollection():
                seen[label] = bool(np.isfinite(artist.get_offsets().filled(np.nan)).all(axis=1).any())
            case PolyCollection():
                seen[label] = any(len(path.vertices) for path in artist.get_paths())
            case ErrorbarContainer():
                seen[label] = len(artist.lines[0].get_xdata()) > 0
    return seen


FITTED = ["fitted, 95 % interval", "fitted logit (pooled)"]


@pytest.mark.parametrize(
    ("rows", "fitted", "left_title", "right_title"),
    [
        ("1,8,3,30,0.02\n1,10,15,15,0.02\n1,12,28,2,0.02\n", FITTED, "field", "catch"),
        ("1,8,10,0,0.02\n1,10,10,0,0.02\n", [], "field, no curve fitted", "catch; no haul of the trial was fitted"),
    ],
)
@pytest.mark.parametrize("haul", [HAUL, hauls_of([catch(1, 0.03, 48.0)])[0]])
def test_the_legend_names_what_is_drawn_and_nothing_else(haul, rows, fitted, left_title, right_title, tmp_path):
    path = tmp_path / "hauls.csv"
    path.write_text(f"haul,length_cm,codend,cover,catch_volume_m3\n{rows}", encoding="utf-8")
    found = predict_haul(SPECIES, haul, n_bootstrap=0, samples=0)
    figure = together_plot(set_beside([found], read_trial(path, 1000.0, "covered")))
    for axes, title in zip(figure.axes, (left_title, right_title), strict=True):
        named = [text.get_text() for text in axes.get_legend().get_texts()]
        assert drawn(axes) == dict.fromkeys(named, True)
        assert axes.get_title(loc="left").endswith(title)
    assert [label for label in drawn(figure.axes[0]) if "fitted" in label] == fitted


def test_the_command_refuses_half_of_a_question(tmp_path):
    asked = ["selectivity", str(tmp_path), "--species", str(example_species_path())]
    for more, word in (
        (["--design", "covered"], "--field"),
        (["--field", "x.csv"], "--design"),
        (["--calibrate", "contact"], "--field"),
    ):
        result = CliRunner().invoke(main, [*asked, *more])
        assert result.exit_code == 2
        assert word in result.output


@pytest.mark.parametrize("share", [0.5, "falling"])
def test_hauls_that_tell_of_no_selection_are_refused_before_they_are_set_beside_anything(share, file, tmp_path):
    table = pd.read_csv(file, comment="#")
    met = table["codend"] + table["cover"]
    rising = np.linspace(0.05, 0.95, 1 + int(np.ptp(table["length_cm"])))
    falling = rising[::-1][(table["length_cm"] - table["length_cm"].min()).astype(int)]
    table["codend"] = np.round(met * (falling if share == "falling" else share))
    table["cover"] = met - table["codend"]
    table.to_csv(tmp_path / "hauls.csv", index=False)
    with pytest.raises(
        InputError, match=r"hauls\.csv: codend tells of no selection: .*the longer are retained the more"
    ):
        check_selection(read_trial(tmp_path / "hauls.csv", 1000.0, "covered"))
