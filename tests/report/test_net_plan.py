"""The net plan as drawn: measured from the SVG."""

import math
import re

import pytest
from click.testing import CliRunner

from codend.cli.main import main
from codend.cli.net_plan import TEMPLATES
from codend.plan.plan import load_plan
from codend.report.net_plan import HANGING, plan_svg


def test_sections_are_drawn_to_scale():
    plan = load_plan("validation/cases/joined_with_strap.toml")
    svg = plan_svg(plan)
    (scale,) = map(float, re.findall(r'data-pixels-per-metre="([\d.]+)"', svg))
    outlines = re.findall(r'<polygon id="section-\d" points="([^"]+)"', svg)
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
    assert (tmp_path / "plan.svg").read_text().count('class="rope"') == (2 if kind == "ropes" else 0)


def test_a_rope_is_drawn_where_it_runs():
    changes = ["rope.0.meshes_from_codline=[0, 25]"]
    plan = load_plan("validation/cases/assumed_two_panels_with_ropes.toml", changes)
    svg = plan_svg(plan)
    outline = re.findall(r'<polygon id="section-0" points="([^"]+)"', svg)[0]
    (_, top), _, (_, bottom), _ = [tuple(map(float, point.split(","))) for point in outline.split()]
    (long,) = (section.meshes_long for section in plan.netting)
    drawn = re.findall(r'<line class="rope" x1="[\d.]+" x2="[\d.]+" y1="([\d.]+)" y2="([\d.]+)"', svg)
    assert len(drawn) == plan.rope[0].number
    for y1, y2 in drawn:
        assert float(y2) == pytest.approx(bottom, abs=0.01)
        assert float(y1) == pytest.approx(bottom - 25 / long * (bottom - top), abs=0.01)
    assert "from 0 to 25 meshes from the codline" in svg
