"""Plans as people write them: what is wrong is said all at once, with what was probably meant."""

import codecs
from pathlib import Path

import pytest

from codend.errors import InputError
from codend.plan.plan import MOST_CASES, load_plan
from codend.selectivity.escape.species import example_species_path
from codend.studies.sweep import MOST_RUNS
from tests.bad_plans import VALID_PLAN
from tests.cli.test_cli import TINY_PLAN, assert_refused, codend_cli


def run(text: str | bytes, folder: Path, *words: object):
    path = folder / "plan.toml"
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    return codend_cli("run", path, "--out", folder / "out", *words)


def changed(*pairs: tuple[str, str]) -> str:
    text = VALID_PLAN
    for old, new in pairs:
        assert old in text
        text = text.replace(old, new, 1)
    return text


SEVERAL = [
    (
        [("tow]\nspeed_m_s", "tow]\nspeed_ms")],
        ["tow.speed_ms = [1.0, 1.5] is not a known key (did you mean speed_m_s?)"],
    ),
    (
        [('"t90"', '"T90"'), ("meshes_round = 100", "meshes_around = 100"), ("1026.0", "1.026")],
        ["netting.0.meshes_around = 100", "netting.1.mesh", "tow.water_density_kg_m3 = 1.026"],
    ),
    (
        [
            ('title = "Two sections"', "title = 2"),
            ("twine_mm = 3.0", "twine_mm = 60"),
            ("radius_m = 0.30", "radius_m = 9"),
        ],
        ["title = 2", "netting.0.twine_mm = 60", "entry.radius_m = 9"],
    ),
    (
        [("[20, 40.5, 60]", "[20, 140, 160]"), ("meshes_from_codline = 30", "meshes_from_codline = 300")],
        ["catch.filled_meshes.1 = 140", "catch.filled_meshes.2 = 160", "strap.0.meshes_from_codline = 300"],
    ),
    (
        [("knot_mm = 5.0", "twin_mm = 2.0"), ("length_m = 3.5", ""), ('"kinetic"', '"viscos"'), ("0.07", "-1")],
        ["netting.0.twin_mm", "model.damping", "strap.0.length_m is missing", "drag.tangential = -1"],
    ),
    (
        [
            ('"uniform"', '"sphere"'),
            ("coefficient = 1.3", 'sphere_cp_csv = "none.csv"'),
            ("meshes_long = 60", "meshes_long = 0"),
        ],
        ["netting.1.meshes_long = 0", 'catch.sphere_cp_csv = "none.csv"'],
    ),
]


@pytest.mark.parametrize(("changes", "mistakes"), SEVERAL)
def test_every_mistake_has_its_line_and_nothing_else(changes, mistakes, tmp_path):
    result = run(changed(*changes), tmp_path)
    assert (result.exit_code, result.stdout) == (2, "")
    lines = result.stderr.splitlines()
    assert len(lines) == len(mistakes)
    for mistake in mistakes:
        assert sum(line.startswith(f"codend: {tmp_path / 'plan.toml'}: {mistake}") for line in lines) == 1
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("old", "new", "meant"),
    [
        ('"t90"', '"T90"', '"t90"'),
        ('"t90"', '"T0"', '"diamond"'),
        ('"t90"', '"t45"', '"square"'),
        ('"t90"', '"Diamond"', '"diamond"'),
        ('"t90"', '"sqaure"', '"square"'),
        ("meshes_round = 50", "meshes_around = 50", "meshes_round"),
        ("mesh_mm = 100.0", "Mesh_mm = 100.0", "mesh_mm"),
        ("[catch]", "[Catch]", "catch"),
        ('"le-bris-1999"', '"LeBris1999"', '"le-bris-1999"'),
        ('"globalised"', '"globalized"', '"globalised"'),
        ('method = "auto"', 'method = "Newton"', '"newton"'),
        ("[entry]", "[entry]\ntwine_mm = 3.0", "netting"),
    ],
)
def test_what_was_probably_meant_is_said(old, new, meant, tmp_path):
    result = run(changed((old, new)).replace("knot_mm = 10.0\n", ""), tmp_path)  # square mesh has no knots
    assert_refused(result, "it is one of netting" if meant == "netting" else f"did you mean {meant}?")


def test_a_list_of_many_mistakes_is_cut_and_counted(tmp_path):
    result = run(changed(("[20, 40.5, 60]", str([1000 + i for i in range(100)]))), tmp_path)
    lines = result.stderr.splitlines()
    assert len(lines) == 31
    assert lines[-1].endswith("plan.toml: and 70 more mistakes")


def test_python_is_told_all_mistakes_too(tmp_path):
    path = tmp_path / "plan.toml"
    path.write_text(changed(('"t90"', '"T90"'), ("1026.0", "1.026")), encoding="utf-8")
    with pytest.raises(InputError) as caught:
        load_plan(path)
    assert len(caught.value.lines) == 2
    assert caught.value.__notes__ == caught.value.lines[1:]


def test_a_species_file_says_all_its_mistakes(tmp_path):
    text = example_species_path().read_text(encoding="utf-8")
    path = tmp_path / "species.toml"
    path.write_text(text.replace("contact =", "contakt =").replace('"ellipse"', '"Ellipse"'), encoding="utf-8")
    (tmp_path / "plan.toml").write_text(TINY_PLAN, encoding="utf-8")
    result = codend_cli("selectivity", tmp_path, "--species", path)
    assert result.exit_code == 2
    said = ["behaviour.contakt", "did you mean contact?", "shape", 'did you mean "ellipse"?']
    assert all(word in result.stderr for word in said)
    assert len(result.stderr.splitlines()) == 2


# --- forms of the file


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "utf-32"])
def test_a_plan_with_a_byte_order_mark_is_read(encoding, tmp_path):
    path = tmp_path / "plan.toml"
    path.write_text(VALID_PLAN.replace("Two sections", "Zwölf Maschen"), encoding=encoding)
    assert load_plan(path).title == "Zwölf Maschen"


LATIN = VALID_PLAN.replace("Two sections", "Zwölf Maschen").encode("latin-1")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (LATIN, ["not UTF-8 but probably Latin-1", "line 1", "ö", "saved as UTF-8"]),
        (codecs.BOM_UTF8 + LATIN, ["not UTF-8 but probably Latin-1", "line 1", "ö"]),
        (VALID_PLAN.encode("utf-16-le"), ["UTF-16 without a byte order mark", "saved as UTF-8"]),
        (b"PK\x03\x04" + bytes(50), ["spreadsheet", "TOML plan, which is plain text"]),
        (changed(("bar_mm = 40.0", "bar_mm = 40,0")), ["line 14", "decimal comma", "40.0"]),
        (changed(('"diamond"', "\u201ediamond\u201c")), ["line 11", "typographic quotation mark"]),
        (VALID_PLAN + "#" * 1_000_000, ["too large", "at most 1 MB"]),
    ],
)
def test_a_plan_that_cannot_be_read_says_what_the_file_is(text, words, tmp_path):
    assert_refused(run(text, tmp_path), "plan.toml", *words)


def test_a_species_file_says_what_it_is(tmp_path):
    text = example_species_path().read_text(encoding="utf-8")
    path = tmp_path / "species.toml"
    path.write_bytes(text.replace('name = "', 'name = "Hälleflundra ', 1).encode("latin-1"))
    assert_refused(codend_cli("selectivity", tmp_path, "--species", path), "species.toml", "Latin-1", "ä")


@pytest.mark.parametrize("change", ["value = 0.0,", "value = 1e-17,", "value = 0.009,"])
def test_no_fish_is_as_thin_as_a_thread(change, tmp_path):
    text = example_species_path().read_text(encoding="utf-8")
    lines = [
        line.replace(line[line.index("value") : line.index(",") + 1], change) if "width_per_length" in line else line
        for line in text.splitlines()
    ]
    (tmp_path / "species.toml").write_text("\n".join(lines), encoding="utf-8")
    result = codend_cli("selectivity", tmp_path, "--species", tmp_path / "species.toml")
    assert_refused(result, "section.width_per_length.value", "at least 0.01")


# --- lists of cases


def test_a_list_of_cases_has_a_limit(tmp_path):
    speeds, catches = [1.0 + 0.001 * i for i in range(101)], [4.0 + 0.01 * i for i in range(100)]
    result = run(TINY_PLAN, tmp_path, "--set", f"tow.speed_m_s={speeds}", "--set", f"catch.filled_meshes={catches}")
    assert_refused(result, "tow.speed_m_s", "makes 10100 cases", f"at most {MOST_CASES} cases")


def test_a_sweep_has_a_limit(tmp_path):
    (tmp_path / "plan.toml").write_text(TINY_PLAN, encoding="utf-8")
    axes = [f"{key}={[10.0 + i for i in range(30)]}" for key in ("netting.0.bar_mm", "tow.x", "tow.y")]
    words = [word for axis in axes for word in ("--vary", axis)]
    result = codend_cli("sweep", tmp_path / "plan.toml", *words, "--out", tmp_path / "out")
    assert_refused(result, "makes 27000 runs", f"at most {MOST_RUNS} runs")


# --- water


def test_water_that_is_left_out_is_sea_water_with_a_word(tmp_path):
    said = "Sea water of 1025 kg/m3 is assumed: the plan gives no tow.water_density_kg_m3"
    result = run(TINY_PLAN.replace("water_density_kg_m3 = 1000.0\n", ""), tmp_path)
    assert result.exit_code == 0
    assert f"{said}\n" in result.stdout
    assert said in (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert load_plan(tmp_path / "out" / "plan.toml").tow.water_density_kg_m3 == 1025.0
    given = run(TINY_PLAN, tmp_path)
    assert "Sea water" not in given.stdout
    assert "Sea water" not in (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
