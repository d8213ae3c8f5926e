"""The validation report: sections found, written as ``REPORT.md`` with their pictures and data."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from codend.io.files import whole_file, write_table
from codend.report.style import png
from validation.section import Picture, Section, Verdict

REPORT = "REPORT.md"
_LINKED = re.compile(r"\]\(((?:figures|data)/[^/)]+)\)")


@dataclass(frozen=True)
class Part:
    """A section with the name it is run by."""

    name: str
    section: Section

    @property
    def failures(self) -> list[str]:
        """What failed, a line each."""
        return [f"{self.name}: {v.claim}: {v.found}" for v in self.section.verdicts if not v.passed]


def write_report(folder: Path, parts: Sequence[Part], how: str, machine: Sequence[tuple[str, str]]) -> Path:
    """Write ``REPORT.md``, ``figures/*.png`` and ``data/*.csv`` into a folder, each file at once.

    Files that the folder's last report links to and this one does not are removed; all else is left alone.

    Args:
        folder: is made if need be.
        parts: sections in the order of the report, their pictures and tables named differently throughout.
        how: paragraph that says how the report is recomputed and what it holds.
        machine: what it was computed with, as ``machine.machine`` tells.
    """
    report = folder / REPORT
    former = set(_LINKED.findall(report.read_text(encoding="utf-8"))) if report.is_file() else set()
    for name in ("figures", "data"):
        (folder / name).mkdir(parents=True, exist_ok=True)
    for part in parts:
        for picture in part.section.pictures:
            with whole_file(folder / _place(picture)) as temporary:
                temporary.write_bytes(png(picture.figure))
        for stem, table in part.section.data.items():
            write_table(table, folder / f"data/{stem}.csv")
    text = report_text(parts, how, machine)
    with whole_file(report) as temporary:
        temporary.write_text(text, encoding="utf-8")
    for leftover in former - set(_LINKED.findall(text)):
        (folder / leftover).unlink(missing_ok=True)
    return report


def report_text(parts: Sequence[Part], how: str, machine: Sequence[tuple[str, str]]) -> str:
    """The report in Markdown."""
    verdicts = [(part, verdict) for part in parts for verdict in part.section.verdicts]
    failed = [failure for part in parts for failure in part.failures]
    blocks = [
        "# Validation of codend",
        how,
        markdown_table(("computed with", ""), machine),
        "## Summary",
        f"{len(verdicts) - len(failed)} of {len(verdicts)} checks passed.",
        *(f"**FAILED** {failure}" for failure in failed),
        markdown_table(
            ("section", "claim", "found", "passed"), [(part.name, v.claim, v.found, _passed(v)) for part, v in verdicts]
        ),
        *(block for part in parts for block in _section_blocks(part.section)),
    ]
    return "\n\n".join(blocks) + "\n"


def markdown_table(headers: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table in Markdown; bars and line breaks within cells are made harmless."""
    lines = [headers, ["---"] * len(headers), *rows]
    return "\n".join("| " + " | ".join(" ".join(c.split()).replace("|", "\\|") for c in line) + " |" for line in lines)


def _passed(verdict: Verdict) -> str:
    return "yes" if verdict.passed else "**NO**"


def _place(picture: Picture) -> str:
    return f"figures/{picture.name}.png"


def _section_blocks(section: Section) -> list[str]:
    text, after = section.text.strip(), []
    for picture in section.pictures:
        shown = f"![{picture.name}]({_place(picture)})\n\n*{picture.caption}*"
        here = re.compile(rf"^!\[{re.escape(picture.name)}\]$", re.MULTILINE)
        if here.search(text):
            text = here.sub(lambda _, shown=shown: shown, text)
        else:
            after.append(shown)
    data = ", ".join(f"[{stem}.csv](data/{stem}.csv)" for stem in section.data)
    return [f"## {section.title}", text, *after, *([f"Data: {data}."] if data else [])]
