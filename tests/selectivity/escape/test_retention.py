import re
from pathlib import Path

import numpy as np
import pytest

from catch_models.fish import PARAMETERS, FishSection, Species
from codend.selectivity.escape.haul import hauls_of, many_hauls, terms_of_catches, terms_of_haul
from codend.selectivity.escape.meshes_met import Catch
from codend.selectivity.escape.penetration import Holes, longest_fish
from codend.selectivity.escape.retention import Crowd, crowd_of, escape_terms, nodes_of
from codend.selectivity.escape.sensitivity import COARSE, sensitivity
from codend.selectivity.escape.species import example_species_path, load_species

SPECIES = load_species(example_species_path())
OPENINGS = np.array([41.0, 37.0, 33.0, 30.0, 28.0, 26.0])
LENGTH_CM = np.linspace(8.0, 40.0, 65)


def values(**changes: float) -> np.ndarray:
    found = SPECIES.values
    for name, value in changes.items():
        found[next(i for i, key in enumerate(PARAMETERS) if key.endswith("." + name))] = value
    return found


def crowd(openings: np.ndarray = OPENINGS, *, first: float = 1.0, knot_m: float = 0.012, load_n: float = 5.0) -> Crowd:
    holes = Holes.of("diamond", 0.05, openings, knot_m=knot_m, load_n=load_n)
    return crowd_of([(holes, first + np.arange(len(openings)), np.ones(len(openings)))])


# --- one catch -------------------------------------------------------------------------------------------------------


def test_fish_all_alike_in_meshes_all_alike_are_cut_at_the_longest_that_passes():
    alike = values(size=0.0, shape=0.0, contact=1.0, rotation_deg=0.0)
    terms = escape_terms(crowd(np.full(6, 40.0)), alike)[0]
    longest_cm = 100.0 * longest_fish(Holes.of("diamond", 0.05, 40.0, knot_m=0.012), FishSection.of(alike)).item()
    l50, sr = terms.l50_sr()
    np.testing.assert_allclose(l50, longest_cm, rtol=1e-6)
    assert sr < 1e-5
    np.testing.assert_allclose(terms.retention([0.999 * longest_cm, 1.001 * longest_cm]), [0.0, 1.0], atol=1e-12)


def test_fish_of_different_sizes_in_meshes_all_alike_follow_a_normal_distribution_of_ln_length():
    spread = 0.07
    varied = values(size=spread, shape=0.0, contact=1.0, rotation_deg=0.0, attempts=1.0)
    terms = escape_terms(crowd(np.full(6, 40.0)), varied)[0]
    longest_cm = 100.0 * longest_fish(Holes.of("diamond", 0.05, 40.0, knot_m=0.012), FishSection.of(varied)).item()
    l50, sr = terms.l50_sr()
    np.testing.assert_allclose(l50, longest_cm, rtol=1e-6)
    quartile = 0.6744897501960817 * spread
    np.testing.assert_allclose(sr, longest_cm * 2.0 * np.sinh(quartile), rtol=1e-5)


@pytest.mark.parametrize("push_force_n", [0.0, 0.5])
def test_retention_agrees_with_fish_sent_one_by_one(push_force_n):
    """Monte Carlo: every fish with its own size and shape tries meshes and rotations drawn for it."""
    rng = np.random.default_rng(5)
    fish, attempts, spread, shape, contact = 300, 3, 0.06, 0.05, 0.9
    asked = values(
        size=spread, shape=shape, contact=contact, attempts=attempts, rotation_deg=0.0, push_force_n=push_force_n
    )
    asked[PARAMETERS.index("behaviour.rows_ahead")] = 4.0
    holes = Holes.of("diamond", 0.05, OPENINGS[:4], knot_m=0.012, load_n=5.0)
    mean = FishSection.of(asked)
    let_through = np.zeros(len(LENGTH_CM))
    for _ in range(fish):
        size, turn = np.exp(spread * rng.standard_normal()), np.exp(0.5 * shape * rng.standard_normal())
        section = FishSection(mean.half_height * size * turn, mean.half_width * size / turn, mean.exponent)
        longest_cm = 100.0 * longest_fish(holes, section, push_force_n=push_force_n, push_exponent=2.0)
        p = (longest_cm >= LENGTH_CM[:, None]).mean(axis=1)
        let_through += contact * (1.0 - (1.0 - p) ** attempts)
    computed = escape_terms(crowd(), asked)[0].retention(LENGTH_CM)
    r = 1.0 - let_through / fish
    error = np.sqrt(np.maximum(r * (1.0 - r), 1e-3) / fish)
    assert np.abs(computed - r).max() < (4.0 * error).max()
    assert np.abs(computed - r).mean() < 0.01


@pytest.mark.parametrize("attempts", [1.0, 4.0, 10.0])
def test_quadrature_is_within_two_thousandths_in_l50_and_two_hundredths_in_sr(attempts):
    asked = values(attempts=attempts)
    l50, sr = escape_terms(crowd(), asked, nodes_of(15, 400, 40))[0].l50_sr()
    found = escape_terms(crowd(), asked)[0].l50_sr()
    np.testing.assert_allclose(found[0], l50, rtol=2e-3)
    np.testing.assert_allclose(found[1], sr, rtol=2e-2)


def test_retention_rises_with_length_from_the_share_that_never_tries_to_one():
    found = escape_terms(crowd(), values(contact=0.8))[0].retention(np.linspace(0.5, 80.0, 400))
    assert (np.diff(found) >= -1e-12).all()
    np.testing.assert_allclose(found[[0, -1]], [0.2, 1.0], atol=1e-9)


def test_more_attempts_and_wider_meshes_let_longer_fish_go_and_farther_rows_shorter_ones():
    def l50(**changes: float) -> float:
        return escape_terms(crowd(), values(**changes))[0].l50_sr()[0]

    assert l50(attempts=1.0) < l50(attempts=3.0) < l50(attempts=10.0)
    assert l50(rows_ahead=1.0) > l50(rows_ahead=3.0) > l50(rows_ahead=6.0)
    assert l50(rotation_deg=0.0) > l50(rotation_deg=10.0) > l50(rotation_deg=20.0)
    assert l50(push_force_n=0.0) < l50(push_force_n=0.5) < l50(push_force_n=2.0)


def test_no_l50_is_given_where_too_few_fish_try_and_no_sr_where_l25_does_not_exist():
    assert np.isnan(escape_terms(crowd(), values(contact=0.4))[0].l50_sr()).all()
    l50, sr = escape_terms(crowd(), values(contact=0.7))[0].l50_sr()
    assert np.isfinite(l50)
    assert np.isnan(sr)


def test_nothing_escapes_without_a_mesh_ahead_of_the_catch():
    terms = escape_terms(crowd(first=200.0), SPECIES.values)[0]
    np.testing.assert_array_equal(terms.retention(LENGTH_CM), 1.0)
    assert np.isnan(terms.l50_sr()).all()


def test_retention_moves_continuously_with_the_front_from_row_to_row():
    starts = np.linspace(0.0, 2.0, 81)
    openings = np.linspace(50.0, 20.0, 12)
    l50 = np.array([escape_terms(crowd(openings, first=s), SPECIES.values)[0].l50_sr()[0] for s in starts])
    assert np.abs(np.diff(l50)).max() < 0.05 * np.ptp(l50) + 0.02


# --- the haul --------------------------------------------------------------------------------------------------------


def catch(case: int, volume_m3: float, opening_deg: float) -> Catch:
    holes = Holes.of("diamond", 0.05, np.full(8, opening_deg))
    return Catch(case, 1.5, volume_m3, opening_deg, holes, 1.0 + np.arange(8), np.ones(8))


CATCHES = [catch(1, 0.1, 20.0), catch(2, 0.4, 30.0), catch(3, 1.0, 45.0)]


def test_a_haul_is_the_mean_over_time_of_its_catches():
    (haul,) = hauls_of(CATCHES[::-1])
    of_catches = terms_of_catches(haul, SPECIES)
    each = np.array([terms.retention(LENGTH_CM) for terms in of_catches])
    whole = terms_of_haul(haul, of_catches, SPECIES).retention(LENGTH_CM)
    # steady growth: by hand, constant to volume 0.1, then linear in volume to 0.4 and to 1
    shares = np.array([0.1 + 0.15, 0.15 + 0.3, 0.3])
    np.testing.assert_allclose(haul.time_shares(SPECIES), shares, rtol=1e-12)
    np.testing.assert_allclose(whole, shares @ each, rtol=1e-12)


def test_a_single_catch_stands_for_the_whole_haul():
    (haul,) = hauls_of(CATCHES[:1])
    of_catches = terms_of_catches(haul, SPECIES)
    assert terms_of_haul(haul, of_catches, SPECIES).l50_sr() == pytest.approx(of_catches[0].l50_sr(), rel=1e-9)


def test_many_hauls_agree_with_one_in_l50_sr_and_retention():
    (haul,) = hauls_of(CATCHES)
    whole = terms_of_haul(haul, terms_of_catches(haul, SPECIES), SPECIES)
    l50_sr, retained = many_hauls(haul, np.tile(SPECIES.values, (3, 1)), nodes_of(), LENGTH_CM)
    np.testing.assert_allclose(l50_sr, np.tile(whole.l50_sr(), (3, 1)), rtol=1e-3)
    np.testing.assert_allclose(retained[0], whole.retention(LENGTH_CM), atol=2e-3)


# --- what numbers do -------------------------------------------------------------------------------------------------


def test_hauls_that_share_passages_and_terms_answer_as_each_does_alone():
    haul = hauls_of([catch(1, 0.2, 20.0), catch(2, 1.0, 35.0)])[0]
    changed = {
        "behaviour.contact": 0.6,
        "behaviour.attempts": 2.5,
        "behaviour.rows_ahead": 2.2,
        "spread.size": 0.03,
        "haul.catch_growth": 1.4,
        "behaviour.push_force_n": 0.7,
        "section.height_per_length": 0.19,
    }
    sets = np.tile(SPECIES.values, (2 * len(changed) + 1, 1))
    for i, (name, value) in enumerate(changed.items()):
        sets[[i, -1 - i], PARAMETERS.index(name)] = value
    for nodes in (nodes_of(), COARSE):
        together = many_hauls(haul, sets, nodes, LENGTH_CM)
        for i, one in enumerate(sets):
            for all_of_them, alone in zip(together, many_hauls(haul, one[None], nodes, LENGTH_CM), strict=True):
                np.testing.assert_allclose(all_of_them[i], alone[0], rtol=1e-12)


def species_with_ranges(folder: Path, ranged: tuple[str, ...], **changes: float) -> Species:
    """The example with the ranges of these numbers only, and other values for some."""
    lines = []
    for line in example_species_path().read_text(encoding="utf-8").splitlines():
        name = line.split(" = ")[0]
        kept = line if name in ranged else re.sub(r"low = [\d.]+, high = [\d.]+, ", "", line)
        lines.append(re.sub(r"value = [\d.]+", f"value = {changes[name]}", kept) if name in changes else kept)
    path = folder / "species.toml"
    path.write_text("\n".join(lines), encoding="utf-8")
    return load_species(path)


def test_sobol_indices_of_one_catch_are_what_the_closed_form_says(tmp_path):
    """Only height and width vary, in a rhombus at the best opening: ln L50 = -ln(height + width) + constant."""
    species = species_with_ranges(tmp_path, ("height_per_length", "width_per_length"), rotation_deg=0.0)
    (haul,) = hauls_of([catch(1, 1.0, 2.0 * np.degrees(np.arctan(np.sqrt(0.14 / 0.21))))])
    found = sensitivity(haul, species, samples=256)
    assert found is not None
    assert found.parameters == ("section.height_per_length", "section.width_per_length")
    # both ranges are 0.04 wide, and L50 depends on the sum: equal shares, next to no interaction
    np.testing.assert_allclose(found.first_order[:, 0], 0.5, atol=0.08)
    np.testing.assert_allclose(found.total[:, 0], 0.5, atol=0.08)
    expected = found.base[0] * 0.35 / (0.35 + np.array([[-0.02, 0.02]] * 2))
    np.testing.assert_allclose(found.one_at_a_time[:, :, 0], expected, rtol=5e-3)
    lower, upper = found.band
    assert (lower <= upper).all()


def test_a_single_number_with_a_range_makes_all_of_the_variance(tmp_path):
    (haul,) = hauls_of(CATCHES)
    found = sensitivity(haul, species_with_ranges(tmp_path, ("height_per_length",)), samples=16)
    assert found is not None
    assert found.parameters == ("section.height_per_length",)
    np.testing.assert_array_equal([found.first_order, found.total], 1.0)


def test_without_ranges_there_is_nothing_to_rank(tmp_path):
    (haul,) = hauls_of(CATCHES)
    assert sensitivity(haul, species_with_ranges(tmp_path, ())) is None
