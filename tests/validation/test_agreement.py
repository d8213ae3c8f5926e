"""The agreement table of the validation report, quick: every claim of it, and that it can tell a disagreement."""

import pytest

from validation import agreement


@pytest.fixture(scope="module")
def section():
    return agreement.section(quick=True)


@pytest.mark.parametrize("number", range(4))
def test_methods_agree_as_closely_as_they_claim(section, number):
    assert section.verdicts[number].passed, section.verdicts[number].found


def test_the_table_has_every_method_on_every_plan(section):
    table = section.data["agreement"]
    assert len(table) == agreement.QUICK
    assert table.notna().all(axis=None)
    assert all(name in section.text for name in table["plan"])


def test_a_difference_beyond_its_claim_fails(section):
    table = section.data["agreement"].copy()
    table.loc[1, "full_difference"] = 2.0 * table.loc[1, "full_claimed"]
    assert not agreement._verdict(table, "", "full").passed
    table.loc[1, "full_difference"] = float("nan")
    assert not agreement._verdict(table, "", "full").passed
