"""The manual: whole, true to the program, and with no link that leads nowhere."""

import re
import tomllib

import pytest

from codend.cli.guide import PAGES
from codend.io import columns
from codend.studies.comparison.designs import DIFFERENCE_COLUMNS
from codend.studies.sensitivity import table as sensitivity
from codend.studies.sensitivity import uncertain
from tests.cli.processes import run
from validation.manual import GUIDE, pages

CELL = re.compile(r"^\| `([^`]+)` \|(.*)\|$", re.MULTILINE)


@pytest.mark.parametrize("name", pages())
def test_what_follows_from_the_program_is_as_it_is_made(name: str):
    assert (GUIDE / name).read_text(encoding="utf-8") == pages()[name], "run python -m validation.manual"


@pytest.mark.parametrize("name", [name for name in pages() if name != "commands.md"])
def test_every_key_and_column_is_told_what_it_is(name: str):
    silent = [key for key, told in CELL.findall(pages()[name]) if not told.split("|")[-1].strip()]
    assert silent == []


@pytest.mark.parametrize(
    ("name", "wanted"),
    [
        (
            "results",
            [*columns.RESULT_COLUMNS, *columns.STRAP_COLUMNS, *columns.ROPE_COLUMNS, *columns.LAYER_COLUMNS],
        ),
        ("layers", columns.OF_LAYERS),
        ("profile", columns.PROFILE_COLUMNS),
        ("meshes", columns.MESH_COLUMNS),
        ("ropes", columns.OF_ROPES),
        ("opening_force", columns.OPENING_FORCE_COLUMNS),
        ("differences", DIFFERENCE_COLUMNS),
        ("sensitivities", sensitivity.COLUMNS),
        ("intervals", uncertain.COLUMNS),
    ],
)
def test_every_column_stands_in_the_manual_and_no_other(name, wanted):
    told = tomllib.loads((GUIDE / "columns.toml").read_text(encoding="utf-8"))[name]
    assert [key for key in told if not key.startswith("_")] == list(wanted)


def test_every_page_is_among_the_contents():
    assert set(PAGES) == {path.stem for path in GUIDE.glob("*.md")}


def test_the_manual_becomes_a_site_and_every_link_leads_somewhere(tmp_path):
    done = run("guide", "--site", tmp_path / "site")
    assert done.returncode == 0, done.stderr
    assert {path.stem for path in (tmp_path / "site").glob("*.html")} >= set(PAGES)


def test_a_page_is_printed():
    assert run("guide", "glossary").stdout.startswith("# Glossary")
