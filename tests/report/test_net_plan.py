"""The net plan as drawn: measured from the SVG."""

import math
import re
from itertools import pairwise

import pytest
from click.testing import CliRunner

from codend.cli.main import main
from codend.cli.net_plan import TEMPLATES
from codend.errors import InputError
from codend.plan.amounts import amounts_of
from codend.plan.limits import held_to
from codend.plan.plan import Plan, load_plan, plan_from_dict
from codend.report.net_plan import plan_svg
from codend.report.net_plan_shapes import HANGING

OUTLINE = r'<polygon points="([^"]+)" id="section-\d"'


def test_sections_are_drawn_to_scale():
    plan = load_plan("validation/cases/joined_with_strap.toml")
    svg = plan_svg(plan)
    (scale,) = map(float, re.findall(r'data-pixels-per-metre="([\d.]+)"', svg))
    outlines = re.findall(OUTLINE, svg)
    assert len(outlines) == 2
    for outline, section in zip(outlines, plan.netting, strict=True):
        (x0, y0), (x1, _), (_, y2), _ = [tuple(map(float, point.split(","))) for point in outline.split()]
        assert (x1 - x0) / scale == pytest.approx(HANGING * section.meshes_round * section.full_mesh_m, rel=1e-5)
        deep = math.sqrt(1 - HANGING**2) * section.meshes_long * section.full_mesh_m
        assert (y2 - y0) / scale == pytest.approx(deep, rel=1e-5)
    assert "joined 3 to 2" in svg
    assert svg.count('class="strap"') == 1


@pytest.mark.parametrize("kind", TEMPLATES)
def test_templates_are_plans_and_are_drawn(kind, tmp_path):
    path = tmp_path / "plan.toml"
    printed = CliRunner().invoke(main, ["plan", "new", "--kind", kind])
    assert printed.exit_code == 0
    path.write_text(printed.stdout)
    drawn = CliRunner().invoke(main, ["plan", "show", str(path), "--out", str(tmp_path / "plan.svg")])
    assert drawn.exit_code == 0, drawn.output
    assert (tmp_path / "plan.svg").read_text().count('class="rope"') == (2 if kind in ("ropes", "panels") else 0)


def test_a_rope_is_drawn_where_it_runs():
    changes = ["rope.0.meshes_from_codline=[0, 25]"]
    plan = load_plan("validation/cases/assumed_two_panels_with_ropes.toml", changes)
    svg = plan_svg(plan)
    outline = re.findall(OUTLINE, svg)[0]
    (_, top), _, (_, bottom), _ = [tuple(map(float, point.split(","))) for point in outline.split()]
    (long,) = (section.meshes_long for section in plan.netting)
    drawn = re.findall(r'<polyline points="[\d.]+,([\d.]+) [\d.]+,([\d.]+)" [^>]*class="rope"', svg)
    assert len(drawn) == plan.rope[0].number
    for y1, y2 in drawn:
        assert float(y2) == pytest.approx(bottom, abs=0.01)
        assert float(y1) == pytest.approx(bottom - 25 / long * (bottom - top), abs=0.01)
    assert "from 0 to 25 meshes from the codline" in svg


PANELS = """
title = "two panels"
tow.speed_m_s = 1.5
entry.hanging_ratio = 0.3
catch.mass_kg = 500
[[netting]]
mesh = "diamond"
name = "belly"
meshes_round = 120
meshes_long = 40
mesh_mm = 120
twine_mm = 4.0
panels = 2
selvedge_meshes = 2
cut = "1N2B"
[[netting]]
mesh = "diamond"
name = "codend"
meshes_round = 80
meshes_long = 50
mesh_mm = 100
twine_mm = 4.0
panels = 2
[[window]]
netting = "codend"
panel = "upper"
meshes_from_codline = [10, 40]
meshes_across = 20
mesh = "square"
meshes_round = 24
meshes_long = 50
bar_mm = 60
twine_mm = 4.0
"""


@pytest.fixture
def panels(tmp_path):
    path = tmp_path / "panels.toml"
    path.write_text(PANELS)
    return load_plan(path)


@pytest.mark.parametrize(
    ("mesh", "cut", "around", "deep", "rate"),
    [
        ("diamond", "1N2B", 120, 40, 1 / 2),
        ("diamond", "1N1B", 120, 30, 1 / 3),
        ("diamond", "AB", 160, 30, 1),
        ("diamond", "1T2B", 200, 20, 2),
        ("t90", "1T2B", 120, 40, 1 / 2),
        ("t90", "1N1B", 200, 12, 3),
        ("diamond", "AN", 80, 40, 0),
    ],
)
def test_edges_slope_as_they_are_cut(panels, mesh, cut, around, deep, rate):
    own = {"mesh": mesh, "cut": cut, "meshes_round": around, "meshes_long": deep}
    tables = panels.to_dict()
    tables["netting"][0].update(own)
    svg = plan_svg(Plan.from_dict(tables))
    outline = re.findall(OUTLINE, svg)[0]
    _, (x1, y1), (x2, y2), _ = [tuple(map(float, point.split(","))) for point in outline.split()]
    assert (x1 - x2) / (y2 - y1) == pytest.approx(rate * HANGING / math.sqrt(1 - HANGING**2), rel=1e-5)
    assert f">{cut}<" in svg


def test_panels_that_differ_are_drawn_each(panels):
    svg = plan_svg(panels)
    assert "upper and lower" not in svg
    assert svg.count('class="window"') == 1
    assert "upper and lower" in plan_svg(panels.model_copy(update={"window": ()}))
    assert svg.count('class="selvedge"') == 4


def test_a_window_is_drawn_where_it_lies(panels):
    svg = plan_svg(panels)
    (scale,) = map(float, re.findall(r'data-pixels-per-metre="([\d.]+)"', svg))
    (window,) = re.findall(r'<polygon points="([^"]+)" id="window-0"', svg)
    codend = re.findall(OUTLINE, svg)[1]
    (x0, y0), (x1, _), (_, y2), _ = [tuple(map(float, point.split(","))) for point in window.split()]
    bottom = float(codend.split()[2].split(",")[1])
    mesh = panels.netting[1].full_mesh_m
    assert (x1 - x0) / scale == pytest.approx(20 * HANGING * mesh, rel=1e-5)
    assert (bottom - y2) / scale == pytest.approx(10 * math.sqrt(1 - HANGING**2) * mesh, rel=1e-5)
    assert (bottom - y0) / scale == pytest.approx(40 * math.sqrt(1 - HANGING**2) * mesh, rel=1e-5)
    assert "joined 6 to 5 across, 5 to 3 along" in svg


def test_mass_is_twine_length_times_runnage_without_the_netting_of_windows(panels):
    section = panels.netting[1].model_copy(update={"runnage_m_kg": 100.0, "twine_density_kg_m3": 950.0})
    amounts = amounts_of(section, 600)
    assert amounts.mass_kg == pytest.approx(amounts.twine_m / 100.0)
    assert amounts.twine_m == pytest.approx(4 * (80 * 50 - 600) * 0.05)


def test_no_text_of_the_drawing_lies_on_another(panels):
    short = {"meshes_long": 2, "cut": None, "selvedge_meshes": 0}
    parts = [panels.netting[0].model_copy(update={**short, "name": f"part {i}"}) for i in range(5)]
    svg = plan_svg(panels.model_copy(update={"netting": (*parts, panels.netting[1])}))
    texts = re.findall(r'<text x="([\d.]+)" y="([\d.]+)"', svg)
    assert len(set(texts)) == len(texts)
    for x in {x for x, _ in texts}:
        ys = sorted(float(y) for own, y in texts if own == x)
        assert all(later - first > 11.9 for first, later in pairwise(ys))


LIMITS = """
[[limit]]
quantity = "inside_mesh_mm"
least = 120
source = "an example"
[[limit]]
quantity = "meshes_round"
most = 100
section = "codend"
source = "an example"
"""


def test_a_plan_is_held_to_the_limits_of_a_file(panels, tmp_path):
    path = tmp_path / "limits.toml"
    path.write_text(LIMITS)
    assert [(one.section, one.kept) for one in held_to(panels, path)] == [
        ("belly", False),
        ("codend", False),
        ("window 1", False),
        ("codend", True),
    ]
    shown = ["plan", "show", str(panels.source), "--out", str(tmp_path / "p.svg"), "--limits", str(path)]
    assert "NOT KEPT: inside_mesh_mm of belly is 112, least 120 (an example)" in CliRunner().invoke(main, shown).output


def test_windows_and_layers_are_held_to_the_limits_of_meshes_and_twine(tmp_path):
    section = {"mesh": "diamond", "meshes_round": 60, "meshes_long": 40, "bar_mm": 50.0, "twine_mm": 3.0, "name": "bag"}
    thick = section | {"twine_mm": 6.0, "name": "lifter", "meshes_from_codline": [0, 20]}
    window = section | {"meshes_round": 20, "bar_mm": 35.0, "netting": "bag", "name": "fine", "meshes_across": 20}
    plan = plan_from_dict(
        {
            "title": "a bag",
            "tow": {"speed_m_s": 1.5},
            "entry": {"radius_m": 0.5},
            "catch": {"filled_meshes": 5},
            "netting": [section],
            "window": [window | {"meshes_from_codline": [10, 20]}],
        }
    )
    path = tmp_path / "limits.toml"
    path.write_text(LIMITS.replace("120", "90").replace('section = "codend"', "") + 'section = "bag"\n')
    assert [(one.section, one.kept) for one in held_to(plan, path)] == [("bag", True), ("fine", False), ("bag", True)]
    path.write_text('[[limit]]\nquantity = "twine_mm"\nmost = 4\nsource = "an example"\n')
    layered = plan_from_dict(plan.model_dump(exclude_unset=True, exclude={"window"}) | {"layer": [thick]})
    assert [(one.section, one.kept) for one in held_to(layered, path)] == [("bag", True), ("lifter", False)]


def test_what_breaks_a_limit_is_told_in_digits_that_show_it(panels, tmp_path):
    path = tmp_path / "limits.toml"
    path.write_text(LIMITS.replace("least = 120", "least = 112.0004"))
    assert held_to(panels, path)[0].words == "NOT KEPT: inside_mesh_mm of belly is 112, least 112.0004 (an example)"


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("least = 120", "least = 120\nmost = 100", "limit.0.least"),
        ("most = 100", "", "limit.1.least"),
        ('source = "an example"', "", "limit.0.source"),
        ('"codend"', '"bag"', "limit.1.section"),
        ('"meshes_round"', '"weight"', "limit.1.quantity"),
        ("most = 100", "most = 100\nleast = 110", "limit.1.least"),
        ("most = 100", "most = -1", "limit.1.most"),
        ('"an example"', '" "', "limit.0.source"),
        ('"an example"', '"two\\nlines"', "limit.0.source"),
    ],
)
def test_a_file_of_limits_that_says_what_they_cannot_be_is_refused(panels, tmp_path, old, new, told):
    path = tmp_path / "limits.toml"
    path.write_text(LIMITS.replace(old, new))
    with pytest.raises(InputError, match=told):
        held_to(panels, path)
