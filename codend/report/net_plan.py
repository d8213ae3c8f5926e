"""The net plan of a codend to scale, as SVG: sections as cut open and laid flat, with what they are made of.

A section is drawn as technologists do, hung at E1: as wide as its stretched meshes times E1, as deep as they are times
E2 = sqrt(1 - E1^2), all sections at one scale; square mesh at its own width and depth.
"""

import math
from xml.sax.saxutils import escape

from codend.plan.amounts import amounts_of
from codend.plan.plan import Plan
from codend.plan.tables import Netting
from codend.report.size_words import mass_text

HANGING = 0.5
"""E1 that meshes are drawn at; no more than a way of drawing."""
WIDTH_PX, MARGIN_PX, LINE_PX = 360.0, 30.0, 16.0


def plan_svg(plan: Plan) -> str:
    """The drawing and the table below it, as the text of an SVG file."""
    sizes = [_drawn_m(section) for section in plan.netting]
    scale = WIDTH_PX / max(width for width, _ in sizes)
    middle, y = MARGIN_PX + WIDTH_PX / 2, MARGIN_PX + 2 * LINE_PX
    parts = [_text(MARGIN_PX, MARGIN_PX, plan.title, bold=True)]
    tops = []
    for index, (name, section, (wide_m, deep_m)) in enumerate(
        zip(plan.section_names, plan.netting, sizes, strict=True)
    ):
        wide, deep = scale * wide_m, scale * deep_m
        tops.append(y)
        corners = [
            (middle - wide / 2, y),
            (middle + wide / 2, y),
            (middle + wide / 2, y + deep),
            (middle - wide / 2, y + deep),
        ]
        outline = " ".join(f"{a:.6f},{b:.6f}" for a, b in corners)
        parts.append(f'<polygon id="section-{index}" points="{outline}" fill="#f4f4f0" stroke="#333"/>')
        for place, words in enumerate(_words(name, section)):
            parts.append(_text(MARGIN_PX + WIDTH_PX + 20, y + LINE_PX * (place + 1), words))
        parts += [_text(middle, y - 4, str(section.meshes_round), anchor="middle")]
        parts += [_text(middle, y + deep - 4, str(section.meshes_round), anchor="middle")]
        y += max(deep, LINE_PX * (len(_words(name, section)) + 1)) if index == len(sizes) - 1 else deep
        if index + 1 < len(sizes) and plan.netting[index + 1].meshes_round != section.meshes_round:
            behind = plan.netting[index + 1].meshes_round
            common = math.gcd(section.meshes_round, behind)
            parts.append(_text(MARGIN_PX, y - 4, f"joined {section.meshes_round // common} to {behind // common}"))
    parts += _ropes(plan, sizes, tops, scale, middle)
    y += 2 * LINE_PX
    for line in [*_rope_words(plan), "", *_table(plan)]:
        parts.append(_text(MARGIN_PX, y, line))
        y += LINE_PX
    box = f"0 0 {2 * MARGIN_PX + WIDTH_PX + 360:.0f} {y + MARGIN_PX:.0f}"
    head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="{box}" font-family="sans-serif" font-size="12"'
    return f'{head} data-pixels-per-metre="{scale:.9f}">\n' + "\n".join(parts) + "\n</svg>\n"


def _drawn_m(section: Netting) -> tuple[float, float]:
    """Width and depth of a section as drawn, m."""
    wide, deep = section.meshes_round * section.full_mesh_m, section.meshes_long * section.full_mesh_m
    if not section.kind.opens:
        return 0.5 * wide, 0.5 * deep
    return HANGING * wide, math.sqrt(1.0 - HANGING**2) * deep


def _words(name: str, section: Netting) -> list[str]:
    twine = f"{section.twines} x {1000 * section.twine_m:.3g} mm"
    titre = "" if section.rtex_g_km is None else f", R{section.rtex_g_km:.4g} tex"
    return [
        f"{name}: {section.kind.words} mesh",
        f"{section.meshes_round} meshes round, {section.meshes_long} deep, cut AN (straight)",
        f"inside mesh {1000 * section.inside_mesh_m:.4g} mm, full mesh {1000 * section.full_mesh_m:.4g} mm",
        f"twine {twine}{titre}{f', {section.material}' if section.material else ''}",
    ]


def _ropes(plan: Plan, sizes: list[tuple[float, float]], tops: list[float], scale: float, middle: float) -> list[str]:
    """Lines of the ropes along the netting and of the straps across it."""
    parts: list[str] = []

    def drawn_at(meshes_from_codline: float) -> tuple[int, float]:
        """Section of a place, on a joint the one ahead, and its height in the drawing."""
        place = sum(part.meshes_long for part in plan.netting) - meshes_from_codline
        index = 0
        while place > plan.netting[index].meshes_long:
            place -= plan.netting[index].meshes_long
            index += 1
        return index, tops[index] + scale * sizes[index][1] * place / plan.netting[index].meshes_long

    for strap in plan.straps:
        index, y = drawn_at(strap.meshes_from_codline)
        wide = scale * sizes[index][0]
        ends = f'x1="{middle - wide / 2:.2f}" x2="{middle + wide / 2:.2f}" y1="{y:.2f}" y2="{y:.2f}"'
        parts.append(f'<line class="strap" {ends} stroke="#a33" stroke-width="2"/>')
    for rope in plan.rope:
        top, bottom = tops[0], tops[-1] + scale * sizes[-1][1]
        if rope.meshes_from_codline is not None:
            bottom, top = (drawn_at(meshes)[1] for meshes in rope.meshes_from_codline)
        for number in range(rope.number):
            x = middle + scale * min(size[0] for size in sizes) * (number / rope.number - 0.5)
            ends = f'x1="{x:.2f}" x2="{x:.2f}" y1="{top:.2f}" y2="{bottom:.2f}"'
            parts.append(f'<line class="rope" {ends} stroke="#236" stroke-width="2"/>')
    return parts


def _rope_words(plan: Plan) -> list[str]:
    stretched = sum(section.stretched_length_m for section in plan.netting)
    found = [
        f"{rope.number} {rope.kind} ropes, {100 * rope.shortening:.3g} % short"
        + (
            f", {(1 - rope.shortening) * stretched:.4g} m each"
            if rope.meshes_from_codline is None
            else ", from {:g} to {:g} meshes from the codline".format(*rope.meshes_from_codline)
        )
        for rope in plan.rope
    ]
    return found + [f"strap {s.meshes_from_codline:g} meshes from the codline, {s.around_m:.4g} m" for s in plan.straps]


def _table(plan: Plan) -> list[str]:
    lines = []
    for name, section in zip(plan.section_names, plan.netting, strict=True):
        amounts = amounts_of(section)
        mass = "mass not known" if amounts.mass_kg is None else mass_text(amounts.mass_kg)
        lines.append(
            f"{name}: twine {amounts.twine_m:.5g} m, {mass}, twine area {amounts.twine_area_m2:.4g} m2, "
            f"stretched netting {amounts.netting_area_m2:.4g} m2"
        )
    return lines


def _text(x: float, y: float, words: str, anchor: str = "start", bold: bool = False) -> str:
    weight = ' font-weight="bold"' if bold else ""
    return f'<text x="{x:.2f}" y="{y:.2f}" text-anchor="{anchor}"{weight}>{escape(words)}</text>'
