"""The independent checks of the validation report, one test each, over the same table."""

import pytest

from validation.independent_checks import THEMES, verdict

CHECKS = [check for theme in THEMES for check in theme.checks]


@pytest.mark.parametrize("check", CHECKS, ids=[check.claim for check in CHECKS])
def test_claim_holds(check):
    found = verdict(check, quick=True)
    assert found.passed, found.found


def test_every_claim_is_made_once_and_says_what_it_rests_on():
    claims = [check.claim for check in CHECKS]
    assert len(set(claims)) == len(claims)
    assert all(check.source for check in CHECKS)
