"""CONTRIBUTING names what is there."""

import re
import tomllib

from tests import ROOT

TEXT = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")


def test_every_file_it_names_exists():
    named = re.findall(r"`((?:codend|catch_models|tests|validation)/[\w./]+)`", TEXT)
    assert len(named) >= 20
    for name in named:
        assert (ROOT / name).exists(), name


def test_its_rooms_are_those_of_the_contracts():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    contracts = project["tool"]["importlinter"]["contracts"]
    (rooms,) = (contract["layers"] for contract in contracts if contract.get("containers") == ["codend"])
    named = re.findall(r"^\| `(\w+)` \|", TEXT, re.MULTILINE)
    kept = {room.strip() for layer in rooms for room in layer.split("|")} - {"compiled", "errors", "guide"}
    assert set(named) == kept
