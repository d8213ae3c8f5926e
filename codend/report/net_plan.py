"""The net plan of a codend to scale, as SVG: panels as cut and laid flat, with what they are made of."""

import math
from collections.abc import Iterable, Sequence
from html import escape

from codend.plan.amounts import Amounts, amounts_of
from codend.plan.limits import Finding
from codend.plan.plan import Plan
from codend.plan.tables import Netting
from codend.report.net_plan_shapes import Corner, Panel, Piece, panels_of
from codend.report.size_words import mass_text
from codend.report.style import listed

HEIGHT_PX, WIDTH_PX, MARGIN_PX, LINE_PX = 560.0, 360.0, 30.0, 16.0
"""Most room for the pieces of a panel, and of all panels; margins; lines of text."""
GAP_PX, WORDS_PX, LETTER_PX = 90.0, 430.0, 6.6
"""Between panels, where their cuts stand; the words beside them; width of a letter, nearly."""
LEFT_PX = 100.0
"""Room at the left for depths and joins."""


def plan_svg(plan: Plan, findings: Sequence[Finding] = ()) -> str:
    """The drawing, what it is made of below, and how it stands to limits, as the text of an SVG file."""
    panels = panels_of(plan)
    tallest = max(piece.top + piece.deep for piece in panels[0].pieces)
    scale = min(WIDTH_PX / sum(panel.width for panel in panels), 2.0 * HEIGHT_PX / tallest)
    top = MARGIN_PX + 2.5 * LINE_PX + (LINE_PX if panels[0].names else 0.0)
    parts = [_text(MARGIN_PX, MARGIN_PX, plan.title, bold=True)]
    right = MARGIN_PX + LEFT_PX
    for column, panel in enumerate(panels):
        middle = right + scale * panel.width / 2
        parts += _panel(plan, panel, column, scale, middle, top)
        right += scale * panel.width + GAP_PX
    y = max(_beside(plan, panels[0].pieces, scale, top, right, parts), top + scale * tallest) + 2 * LINE_PX
    lines = [*_rope_words(plan), *_window_words(plan), "", *_table(plan), *_limit_words(findings)]
    for line in lines:
        parts.append(_text(MARGIN_PX, y, line))
        y += LINE_PX
    wide = max(right + WORDS_PX, MARGIN_PX + LETTER_PX * max(map(len, lines)) + MARGIN_PX)
    box = f"0 0 {wide:.0f} {y + MARGIN_PX:.0f}"
    head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="{box}" font-family="sans-serif" font-size="12"'
    return f'{head} data-pixels-per-metre="{scale:.9f}">\n' + "\n".join(parts) + "\n</svg>\n"


def _panel(plan: Plan, panel: Panel, column: int, scale: float, middle: float, top: float) -> list[str]:
    """One panel with all that lies on it."""

    def placed(corners: Iterable[Corner]) -> list[Corner]:
        return [(middle + scale * x, top + scale * y) for x, y in corners]

    parts = []
    if panel.names:
        parts.append(_text(middle, top - 1.5 * LINE_PX, listed(panel.names), anchor="middle", bold=True))
    for piece in panel.pieces:
        name = f"section-{piece.section}" + (f"-{panel.names[0]}" if column else "")
        outline = placed(piece.outline)
        parts.append(_polygon(outline, f'id="{name}" fill="#f4f4f0" stroke="#333"'))
        strips = [placed(strip) for strip in piece.selvedges()]
        parts += [
            _polygon(strip, 'class="selvedge" fill="#d8d2c0" stroke="#333" stroke-width="0.5"') for strip in strips
        ]
        parts += _counts(plan, piece, outline)
        (_, y0), (x1, _), (x2, y1) = outline[0], outline[1], outline[2]
        if y1 - y0 > LINE_PX:
            cut = plan.netting[piece.section].edge_cut_text
            parts.append(_text(max(x1, x2) + 4, (y0 + y1) / 2 + 4, cut))
    for number, corners in panel.windows:
        how = f'id="window-{number}" class="window" fill="#cfe3ee" stroke="#236"'
        parts.append(_polygon(placed(corners), how))
    for ends in panel.straps:
        parts.append(_line(placed(ends), 'class="strap" stroke="#a33"'))
    for line in panel.ropes:
        parts.append(_line(placed(line), 'class="rope" stroke="#236"'))
    for number, corners in panel.windows:
        (x0, y0), _, (x2, y2), _ = placed(corners)
        words = f"{plan.window[number].meshes_round} x {plan.window[number].meshes_long}"
        if x2 - x0 > LETTER_PX * len(words) and y2 - y0 > LINE_PX:
            parts.append(_on_netting((x0 + x2) / 2, (y0 + y2) / 2 + 4, words))
    return parts


def _counts(plan: Plan, piece: Piece, outline: list[Corner]) -> list[str]:
    """Meshes across at both ends, inside the piece; of one too shallow for both, in one line or none."""
    part = plan.netting[piece.section]
    fore, aft = (f"{count / plan.panels:g}" for count in (part.meshes_round, part.aft_meshes_round))
    (x0, y0), (x1, _), _, (_, y1) = outline
    middle = (x0 + x1) / 2
    if y1 - y0 > 2.2 * LINE_PX:
        return [_on_netting(middle, y0 + 13, fore), _on_netting(middle, y1 - 4, aft)]
    if y1 - y0 > 0.8 * LINE_PX:
        both = fore if fore == aft else f"{fore} to {aft}"
        return [_on_netting(middle, (y0 + y1) / 2 + 4, both)]
    return []


def _beside(plan: Plan, pieces: Sequence[Piece], scale: float, top: float, x: float, parts: list[str]) -> float:
    """Add depths and joins at the left and each section's words at the right, none over another; the lowest line."""
    free_words = free_depth = 0.0
    for piece, name, part in zip(pieces, plan.section_names, plan.netting, strict=True):
        y0, y1 = top + scale * piece.top, top + scale * (piece.top + piece.deep)
        y = max(y0 + LINE_PX, free_words + LINE_PX)
        # level where the words stand beside their section
        parts.append(_line([(x - GAP_PX / 2, min(y - 4, y1)), (x - 6, y - 4)], 'stroke="#999"'))
        for words in _words(plan, name, part):
            parts.append(_text(x, y, words))
            y += LINE_PX
        free_words = y - LINE_PX / 2
        depth = max((y0 + y1) / 2 + 4, free_depth + LINE_PX)
        parts.append(_text(MARGIN_PX, depth, f"{part.meshes_long} deep"))
        free_depth = depth
        if (joined := _join(plan, piece.section)) is not None:
            free_depth = max(y1 + 4, free_depth + LINE_PX)
            parts.append(_text(MARGIN_PX, free_depth, joined))
    return max(free_words, free_depth)


def _join(plan: Plan, section: int) -> str | None:
    """How a section is joined to the one behind it, where their counts differ."""
    if section + 1 == len(plan.netting):
        return None
    ahead, behind = plan.netting[section].open_meshes[1], plan.netting[section + 1].open_meshes[0]
    common = math.gcd(ahead, behind)
    return None if ahead == behind else f"joined {ahead // common} to {behind // common}"


def _words(plan: Plan, name: str, section: Netting) -> list[str]:
    twine = f"{section.twines} x {1000 * section.twine_m:.3g} mm"
    titre = "" if section.rtex_g_km is None else f", R{section.rtex_g_km:.4g} tex"
    fore, aft = section.meshes_round, section.aft_meshes_round
    found = [f"{name}: {section.kind.words} mesh"]
    counts = f"{fore} to {aft}" if section.tapers else f"{fore}"
    found.append(f"{counts} meshes round, {section.meshes_long} deep, cut {section.edge_cut_text}")
    if section.panels > 1:
        found[-1] += f", {section.panels} panels"
    if section.selvedge_meshes:
        opened = " to ".join(str(count) for count in dict.fromkeys(section.open_meshes))
        found.append(f"{section.selvedge_meshes} meshes of each edge in the selvedge: {opened} open")
    found.append(f"inside mesh {1000 * section.inside_mesh_m:.4g} mm, full mesh {1000 * section.full_mesh_m:.4g} mm")
    found.append(f"twine {twine}{titre}{f', {section.material}' if section.material else ''}")
    return found


def _rope_words(plan: Plan) -> list[str]:
    long = float(sum(section.meshes_long for section in plan.netting))
    found = []
    for rope in plan.rope:
        near, far = rope.meshes_from_codline or (0.0, long)
        each_m = (1 - rope.shortening) * (_stretched_m(plan, far) - _stretched_m(plan, near))
        where = "" if rope.meshes_from_codline is None else f", from {near:g} to {far:g} meshes from the codline"
        many = f"{rope.number} {rope.kind} rope{'s' if rope.number > 1 else ''}"
        short = f"{100 * abs(rope.shortening):.3g} % {'short' if rope.shortening >= 0.0 else 'long'}"
        found.append(f"{many}, {short}, {each_m:.4g} m{' each' if rope.number > 1 else ''}{where}")
    return found + [f"strap {s.meshes_from_codline:g} meshes from the codline, {s.around_m:.4g} m" for s in plan.straps]


def _stretched_m(plan: Plan, meshes_from_codline: float) -> float:
    """Stretched length of the netting from the codline to a place, m."""
    length_m, left = 0.0, meshes_from_codline
    for part in reversed(plan.netting):
        own = min(left, part.meshes_long)
        length_m, left = length_m + part.stretched_length_m * own / part.meshes_long, left - own
    return length_m


def _window_words(plan: Plan) -> list[str]:
    """What is let in, and in which ratios its edges are joined."""
    found = []
    for name, window, hole in zip(plan.window_names, plan.window, plan.holes, strict=True):
        across = math.gcd(window.meshes_round, hole.across)
        deep = math.gcd(window.meshes_long, hole.deep)
        found.append(
            f"{name}: {window.kind.words} mesh, {window.meshes_round} across, {window.meshes_long} deep, inside mesh "
            f"{1000 * window.inside_mesh_m:.4g} mm, in place of {hole.across} x {hole.deep} of {window.netting} "
            f"({window.side}); joined {window.meshes_round // across} to {hole.across // across} across, "
            f"{window.meshes_long // deep} to {hole.deep // deep} along"
        )
    return found


def _table(plan: Plan) -> list[str]:
    """Twine length, mass and area of sections and windows, and of all of them."""
    parts: list[tuple[str, Amounts]] = []
    for number, (name, section) in enumerate(zip(plan.section_names, plan.netting, strict=True)):
        gone = sum(hole.across * hole.deep for hole in plan.holes if hole.section == number)
        parts.append((name, amounts_of(section, gone)))
    parts += [(name, amounts_of(window)) for name, window in zip(plan.window_names, plan.window, strict=True)]
    lines = [_amounts(name, amounts) for name, amounts in parts]
    return [*lines, _amounts("all", sum((own for _, own in parts[1:]), parts[0][1]))] if len(parts) > 1 else lines


def _amounts(name: str, amounts: Amounts) -> str:
    mass = "mass not known" if amounts.mass_kg is None else mass_text(amounts.mass_kg)
    return (
        f"{name}: twine {amounts.twine_m:.5g} m, {mass}, twine area {amounts.twine_area_m2:.4g} m2, "
        f"stretched netting {amounts.netting_area_m2:.4g} m2"
    )


def _limit_words(findings: Sequence[Finding]) -> list[str]:
    return ["", *(finding.words for finding in findings)] if findings else []


def _text(x: float, y: float, words: str, anchor: str = "start", bold: bool = False) -> str:
    weight = ' font-weight="bold"' if bold else ""
    return f'<text x="{x:.2f}" y="{y:.2f}" text-anchor="{anchor}"{weight}>{escape(words, quote=False)}</text>'


def _on_netting(x: float, y: float, words: str) -> str:
    """Words in the middle of netting, on a ground that keeps lines off them in every program that shows the drawing."""
    wide = LETTER_PX * len(words) + 2
    ground = f'<rect x="{x - wide / 2:.2f}" y="{y - 11:.2f}" width="{wide:.2f}" height="14" fill="#fff"/>'
    return ground + _text(x, y, words, anchor="middle")


def _polygon(corners: Iterable[Corner], how: str) -> str:
    points = " ".join(f"{x:.6f},{y:.6f}" for x, y in corners)
    return f'<polygon points="{points}" {how}/>'


def _line(corners: Iterable[Corner], how: str) -> str:
    points = " ".join(f"{x:.2f},{y:.2f}" for x, y in corners)
    return f'<polyline points="{points}" fill="none" stroke-width="2" {how}/>'
