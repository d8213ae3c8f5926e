"""Effects on L50 that trials have published, computed with one assumed push: their signs."""

import pytest

from codend.selectivity.escape.species import example_species_path, load_species
from validation import published_effects

SPECIES = load_species(example_species_path())


@pytest.fixture(scope="module")
def hauls():
    return published_effects.hauls(SPECIES)


@pytest.mark.parametrize("push_n", [0.0, 1.0, 2.0])
def test_all_published_effects_have_the_right_sign_with_one_push(hauls, push_n):
    found = published_effects.effects(hauls, SPECIES, push_n)
    assert len(found) == 9
    assert [one.name for one in found if not one.sign_right] == []
