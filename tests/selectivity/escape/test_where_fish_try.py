"""Zones, distributions along the codend, and shut meshes."""

from dataclasses import replace

import numpy as np
import pytest

from catch_models.fish import Along, Sourced, Zone
from codend.errors import InputError
from codend.report.selectivity_words import notes
from codend.selectivity.escape.haul import hauls_of, many_hauls, terms_of_catches, terms_of_haul, trying_of
from codend.selectivity.escape.meshes_met import Catch, Part
from codend.selectivity.escape.penetration import Holes
from codend.selectivity.escape.predict import predict_haul
from codend.selectivity.escape.retention import crowd_of, escape_terms, nodes_of
from codend.selectivity.escape.sensitivity import COARSE
from codend.selectivity.escape.species import example_species_path, load_species, species_toml

SPECIES = load_species(example_species_path())
LENGTH_CM = np.linspace(8.0, 40.0, 65)


def number(value: float) -> Sourced:
    return Sourced[float](value=value, source="assumed: test")


def crowd(*openings: float, rows_ahead: tuple[float, ...] | None = None):
    ahead = np.array(rows_ahead or 1.0 + np.arange(len(openings)))
    return crowd_of([(Holes.of("diamond", 0.05, np.array(openings)), ahead, np.ones(len(openings)))])


def catch(parts: dict[Part, tuple[float, float]]) -> Catch:
    """Meshes of parts, each with its opening and its distance from the front in rows."""
    opening, ahead = (np.array(values) for values in zip(*parts.values(), strict=True))
    holes = Holes.of("diamond", 0.05, opening, load_n=5.0)
    return Catch(1, 1.5, 0.4, float(opening[0]), holes, ahead, np.ones(len(ahead)), tuple(parts))


UPPER, LOWER, WINDOW = Part("codend", "upper"), Part("codend", "lower"), Part("window", "upper")


def l50(parts: dict[Part, tuple[float, float]], *zones: Zone) -> float:
    (haul,) = hauls_of([catch(parts)])
    return terms_of_catches(haul, SPECIES.model_copy(update={"zone": zones}))[0].l50_sr()[0]


def test_shut_meshes_take_no_attempts_from_open_ones():
    open_alone = escape_terms(crowd(41.0, 37.0), SPECIES.values)[0].retention(LENGTH_CM)
    with_shut = escape_terms(crowd(41.0, 37.0, 1.0, 0.5), SPECIES.values)[0].retention(LENGTH_CM)
    np.testing.assert_allclose(with_shut, open_alone, atol=1e-12)


def test_a_mesh_that_shuts_leaves_its_attempts_to_others_little_by_little():
    values = np.array([escape_terms(crowd(40.0, o), SPECIES.values)[0].l50_sr()[0] for o in np.linspace(0, 40, 81)])
    assert np.abs(np.diff(values)).max() < 0.2 * np.ptp(values)


def test_a_window_of_its_own_raises_l50_and_the_more_the_more_fish_try_it():
    bare = {UPPER: (25.0, 1.0), LOWER: (25.0, 1.0)}
    with_window = bare | {WINDOW: (70.0, 12.0)}
    assert l50(with_window) == pytest.approx(l50(bare), rel=1e-9), "beyond the rows that fish try"
    few, many = (Zone(section="window", contact=number(c), attempts=number(2.0)) for c in (0.6, 0.95))
    assert l50(bare) < l50(with_window, few) < l50(with_window, many)


def test_a_zone_takes_nothing_from_the_rest_and_holds_the_panel_it_names():
    parts = {UPPER: (40.0, 1.0), LOWER: (20.0, 1.0), WINDOW: (1.0, 3.0)}
    shut = Zone(section="window", contact=number(1.0), attempts=number(50.0))
    assert l50(parts, shut) == pytest.approx(l50({p: v for p, v in parts.items() if p != WINDOW}), rel=1e-9)
    upper = Zone(section="codend", panel="upper", contact=number(0.95), attempts=number(4.0))
    assert l50(parts, upper) > l50(parts)


def test_fish_escape_from_zones_one_after_the_other():
    parts = {UPPER: (40.0, 1.0), WINDOW: (60.0, 9.0)}
    zone = Zone(section="window", contact=number(0.5), attempts=number(1.0))
    (haul,) = hauls_of([catch(parts)])
    both = terms_of_catches(haul, SPECIES.model_copy(update={"zone": (zone,)}))[0].retention([0.5])
    np.testing.assert_allclose(both, 0.05 * 0.5, atol=1e-9)  # small fish: those that try neither


def test_a_distribution_along_the_codend_says_which_meshes_are_tried():
    (haul,) = hauls_of([catch({UPPER: (40.0, 1.0), LOWER: (30.0, 2.0), WINDOW: (20.0, 3.0)})])

    def found(*weight: float) -> float:
        along = Along(rows_ahead=(1.0, 2.0, 3.0), weight=weight, source="assumed: test")
        return terms_of_catches(haul, SPECIES.model_copy(update={"along": along}))[0].l50_sr()[0]

    assert found(1.0, 0.0, 0.0) > found(1.0, 1.0, 0.0) > found(1.0, 1.0, 1.0) > found(0.0, 0.0, 1.0)
    alone = escape_terms(crowd(30.0), SPECIES.values)[0].l50_sr()[0]
    np.testing.assert_allclose(found(0.0, 1.0, 0.0), alone, rtol=1e-9)


def test_tabled_lengths_give_the_l50_of_exact_ones():
    (haul,) = hauls_of([catch({UPPER: (25.0, 1.0), LOWER: (14.0, 2.0), WINDOW: (60.0, 3.0)})])
    nodes = nodes_of(3, 8, 14)
    for push in (0.0, 0.5, 3.0, 100.0):
        values = SPECIES.values.copy()
        values[11] = push
        exact, _ = many_hauls(haul, values[None], nodes, LENGTH_CM, trying_of(haul, SPECIES))
        tabled, _ = many_hauls(haul, values[None], COARSE, LENGTH_CM, trying_of(haul, SPECIES))
        np.testing.assert_allclose(tabled, exact, rtol=4e-3)


def test_many_hauls_try_as_one_does():
    zone = Zone(section="window", contact=number(0.5), attempts=number(2.0))
    species = SPECIES.model_copy(update={"zone": (zone,)})
    (haul,) = hauls_of([catch({UPPER: (40.0, 1.0), WINDOW: (60.0, 9.0)})])
    whole = terms_of_haul(haul, terms_of_catches(haul, species), species)
    many, _ = many_hauls(haul, species.values[None], nodes_of(), LENGTH_CM, trying_of(haul, species))
    np.testing.assert_allclose(many[0], whole.l50_sr(), rtol=2e-3)


def test_a_species_with_zones_and_a_distribution_is_read_back_equal_and_its_mistakes_are_told(tmp_path):
    zone = Zone(section="window", panel="upper", contact=number(0.5), attempts=number(2.0))
    along = Along(rows_ahead=(0.0, 4.0), weight=(1.0, 0.0), source="assumed: test")
    species = SPECIES.model_copy(update={"zone": (zone,), "along": along})
    path = tmp_path / "species.toml"
    path.write_text(species_toml(species), encoding="utf-8")
    assert load_species(path) == species
    assert {"zone.window.contact", "along"} <= set(species.assumed)
    for bad in ({"rows_ahead": (4.0, 0.0)}, {"weight": (1.0,)}, {"weight": (0.0, 0.0)}):
        wrong = species.model_copy(update={"along": along.model_copy(update=bad)})
        path.write_text(species_toml(wrong), encoding="utf-8")
        with pytest.raises(InputError, match="along"):
            load_species(path)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"along": Along(rows_ahead=(2.0, 4.0), weight=(1.0, 0.0), source="assumed: test")}, "first row of 0 to 1"),
        (
            {"zone": (Zone(section="a", contact=number(0.5).model_copy(update={"low": 0.4}), attempts=number(1.0)),)},
            r"zone\.0\.contact\.low.* left out",
        ),
    ],
)
def test_what_would_go_unheard_in_a_species_is_refused(changes, said, tmp_path):
    path = tmp_path / "species.toml"
    path.write_text(species_toml(SPECIES.model_copy(update=changes)), encoding="utf-8")
    with pytest.raises(InputError, match=said):
        load_species(path)


def test_a_zone_without_effect_is_told():
    (haul,) = hauls_of([catch({UPPER: (25.0, 1.0), LOWER: (25.0, 1.0)})])
    zones = tuple(Zone(section=s, contact=number(0.5), attempts=number(2.0)) for s in ("codend", "nosuch", "codend"))
    found = predict_haul(SPECIES.model_copy(update={"zone": zones}), haul, n_bootstrap=0, samples=0)
    idle = [note for note in notes([found]) if "has no effect" in note]
    assert len(idle) == 2
    assert "[[zone]] nosuch has no effect: of the codend's parts (codend upper, codend lower)" in idle[0]
    assert not any("no effect" in note for note in notes([predict_haul(SPECIES, haul, n_bootstrap=0, samples=0)]))


def test_it_is_told_that_smeared_ropes_leave_only_mean_openings():
    parts = {UPPER: (40.0, 1.0), LOWER: (40.0, 1.0)}
    told = []
    for smeared in (False, True):
        (haul,) = hauls_of([replace(catch(parts), smeared=smeared)])
        told.append(" ".join(notes([predict_haul(SPECIES, haul, n_bootstrap=0, samples=0)])))
    assert ["smeared" in words for words in told] == [False, True]
