"""Effects on L50 that trials have published, computed with one assumed push: their signs."""

import pytest

from codend.equilibrium.stability import Stability
from codend.studies import study
from validation import published_effects

SPECIES = published_effects.assumed_fish()


@pytest.fixture(scope="module")
def hauls():
    with pytest.MonkeyPatch.context() as patch:
        # which changes no opening: of small turned meshes all harmonics grow, each asked in nine tenths of the time
        patch.setattr(study, "stability_of", lambda *_, **__: Stability("unknown", complete=False))
        return published_effects.hauls(SPECIES)


@pytest.mark.parametrize("push_n", [0.0, 0.5, 1.0])
def test_all_published_effects_have_the_right_sign_with_one_push(hauls, push_n):
    found = published_effects.effects(hauls, SPECIES, push_n)
    assert len(found) == 12
    assert [one.name for one in found if not one.sign_right] == []


def test_with_half_a_newton_five_of_nine_sizes_are_inside_the_published_ranges(hauls):
    found = published_effects.effects(hauls, SPECIES, 0.5)
    small = ["T90 44 mm, 300 to 150 round, cm", "square, 107 to 213 round, cm"]
    assert [one.name for one in found if one.inside is False] == ["T90, cm", "double 6 to double 4 mm, cm", *small]
    assert sum(bool(one.inside) for one in found) == 5
