"""Parts that other commands put into a run's page: each has a name, and takes the place of an earlier one of it."""

import re
from pathlib import Path

from codend.io.files import whole_file

PLACES = ("<!-- here: {} -->", "<h2", "</body>")
"""Before which of these a part goes, the first that the page has."""


def with_part(page: str, name: str, part: str, place: str = "sections") -> str:
    """A page with a part in its place, in place of what it had by that name; ``part`` empty takes it out."""
    start, end = f"<!-- {name} -->", f"<!-- end of {name} -->"
    page = re.sub(f"{re.escape(start)}.*?{re.escape(end)}\n?", "", page, flags=re.DOTALL)
    if not part:
        return page
    whole = f"{start}\n{part}\n{end}\n"
    for mark in (found.format(place) for found in PLACES):
        if mark in page:
            before, after = page.split(mark, 1)
            return f"{before}{whole}{mark}{after}"
    return page + whole


def put_into(report: Path, parts: dict[tuple[str, str], str]) -> None:
    """Put parts, by name and place, into a page that is there.

    Raises:
        OSError: the page cannot be read or written.
    """
    page = report.read_text(encoding="utf-8")
    for (name, place), part in parts.items():
        page = with_part(page, name, part, place)
    with whole_file(report) as temporary:
        temporary.write_text(page, encoding="utf-8")
