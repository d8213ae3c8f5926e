import pickle

import numpy as np
import pytest

from catch_models.fish import FishSection
from codend.errors import InputError
from codend.selectivity.escape.species import example_species_path, load_species, shipped_species_path

EXAMPLE = example_species_path().read_text(encoding="utf-8")


def test_every_number_of_the_example_is_marked_as_assumed():
    species = load_species(example_species_path())
    assert "assumed" in species.name.lower()
    given = [line for line in EXAMPLE.splitlines() if "value =" in line]
    assert len(species.assumed) == len(given)


def girth(height: float, width: float, exponent: float) -> float:
    angle = np.linspace(0.0, np.pi / 2.0, 100_001)
    x, y = height / 2.0 * np.cos(angle) ** (2.0 / exponent), width / 2.0 * np.sin(angle) ** (2.0 / exponent)
    return float(4.0 * np.hypot(np.diff(x), np.diff(y)).sum())


def test_the_red_mullet_is_as_high_wide_and_round_as_it_was_measured():
    section = load_species(shipped_species_path("red-mullet")).section
    high, wide, exponent = section.height_per_length, section.width_per_length, section.exponent
    assert exponent is not None
    assert (high.value, wide.value) == (0.20, 0.11)
    assert girth(high.value, wide.value, exponent.value) == pytest.approx(0.53, abs=1e-3)
    assert girth(high.high, wide.high, exponent.low) == pytest.approx(0.525, abs=1e-3)
    assert girth(high.low, wide.low, exponent.high) == pytest.approx(0.535, abs=1e-3)


def test_only_what_was_measured_of_the_red_mullet_is_not_assumed():
    species = load_species(shipped_species_path("red-mullet"))
    measured = {"section.height_per_length", "section.width_per_length", "section.exponent"}
    text = shipped_species_path("red-mullet").read_text(encoding="utf-8")
    assert not measured & set(species.assumed)
    assert len(species.assumed) == sum("value =" in line for line in text.splitlines()) - len(measured)


@pytest.mark.parametrize(
    ("old", "new", "key"),
    [
        ("value = 0.21", "value = -0.21", "section.height_per_length.value"),
        ("value = 0.21, low = 0.19", "value = 0.21, low = 0.22", "section.height_per_length.value"),
        ("value = 0.21, low = 0.19, high", "value = 0.21, high", "section.height_per_length.low"),
        (', source = "assumed" }   # share', " }   # share", "section.height_compression.source"),
        ("contact =", "contakt =", "behaviour.contakt"),
        ('shape = "ellipse"', 'shape = "superellipse"', "section.exponent"),
        ('shape = "ellipse"', 'shape = "circle"', "shape"),
        ("to_cm = 60.0", "to_cm = 5.0", "lengths.to_cm"),
        ("step_cm = 1.0", "step_cm = 1e-6", "lengths.step_cm"),
        ("[behaviour]", "[behaviour", ""),
        ("[section] ", '[section]\nexponent = { value = 3.0, source = "x" }', "section.exponent"),
    ],
)
def test_a_broken_species_file_is_refused_by_its_key(tmp_path, old, new, key):
    assert old in EXAMPLE
    path = tmp_path / "species.toml"
    path.write_text(EXAMPLE.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(InputError) as error:
        load_species(path)
    assert error.value.key == key
    assert str(path) in str(error.value)
    assert "\n" not in str(error.value)


def test_there_are_at_most_ten_thousand_length_classes(tmp_path):
    path = tmp_path / "species.toml"  # from 5 to 60 cm
    path.write_text(EXAMPLE.replace("step_cm = 1.0", "step_cm = 0.00551"), encoding="utf-8")
    assert len(load_species(path).length_cm) == 9982
    path.write_text(EXAMPLE.replace("step_cm = 1.0", "step_cm = 0.0055"), encoding="utf-8")
    with pytest.raises(InputError, match=r"lengths\.step_cm = 0\.0055 .* at most 10000 length classes"):
        load_species(path)


def test_a_missing_species_file_is_an_input_error(tmp_path):
    with pytest.raises(InputError, match="cannot be read"):
        load_species(tmp_path / "none.toml")


@pytest.mark.parametrize("exponent", [1.4, 2.0, 3.3])
def test_support_is_the_reach_of_the_outline(exponent):
    section = FishSection(0.1, 0.06, exponent)
    outline = section.outline(200_001)
    for angle in np.radians([0.0, 10.0, 45.0, 77.0, 90.0, 200.0]):
        reach = (outline @ [np.cos(angle), np.sin(angle)]).max()
        np.testing.assert_allclose(section.support(angle), reach, rtol=1e-7)
    x, y = np.abs(outline).T
    np.testing.assert_allclose((x / 0.1) ** exponent + (y / 0.06) ** exponent, 1.0, rtol=1e-9)


def test_a_species_goes_to_other_processes_whole():
    species = load_species(example_species_path())
    again = pickle.loads(pickle.dumps(species))
    assert again == species
    assert again.model_fields_set == species.model_fields_set
