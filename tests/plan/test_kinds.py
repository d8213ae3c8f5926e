import ast
from typing import get_args

import pytest

from codend.netting.pattern import PATTERNS
from codend.plan.kinds import KINDS, MeshName, kinds_in_words
from codend.selectivity.escape.penetration import SHAPES
from tests import ROOT


def test_every_mesh_a_plan_may_name_has_its_record():
    assert tuple(KINDS) == get_args(MeshName)


@pytest.mark.parametrize("mesh", KINDS)
def test_a_record_names_a_pattern_and_a_hole_there_are(mesh: MeshName):
    assert KINDS[mesh].pattern in PATTERNS
    assert KINDS[mesh].hole in SHAPES


THEIR_OWN = {ROOT / "codend" / "plan" / "kinds.py", ROOT / "codend" / "netting" / "pattern.py"}
"""The records, and the table of patterns, of which one may be called like its kind."""


def test_no_other_file_asks_for_a_kind_by_its_name():
    for path in set((ROOT / "codend").rglob("*.py")) - THEIR_OWN:
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            asked = [node.left, *node.comparators] if isinstance(node, ast.Compare) else getattr(node, "keys", [])
            named = [one for part in asked if part for one in ast.walk(part) if isinstance(one, ast.Constant)]
            assert not any(one.value in KINDS for one in named), f"{path}, line {node.lineno}"


def test_kinds_are_named_in_words():
    assert kinds_in_words(lambda kind: kind.membrane) == "diamond and T90"
    assert kinds_in_words(lambda kind: kind.rows_per_mesh == 1, "or") == "square"
