"""Whatever is typed into a table, it is read or refused in one line: nothing else escapes."""

import string

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from codend.errors import InputError
from codend.io.table_form import TableForm
from codend.selectivity.fits.fielddata import read_field_data
from codend.selectivity.fits.haul_table import HaulReading
from codend.studies.comparison import read_flume_table

HAULS = "# a trial\nhaul;length_cm;codend;cover;depth\nA;20,5;1;9;80\nA;22,5;4;6;80\nB;20,5;2;8;90\nB;22,5;7;3;90\n"
FLUME = "# a tank\nfilled_meshes,speed_m_s,drag_n\n10,1.0,120.5\n20,1.0,130\n"
TYPED = st.text(string.digits + " ,;.\t|-+e\"'#=\n\r\0\ufeff", max_size=6) | st.text(max_size=4)


@pytest.mark.parametrize(
    ("text", "read"),
    [
        (HAULS, lambda path: read_field_data(path, "covered", ["depth"])),
        (HAULS, lambda path: read_field_data(path, "covered", [], HaulReading(TableForm(), "cm", "lower"))),
        (FLUME, read_flume_table),
    ],
)
@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_whatever_is_typed_into_a_table_nothing_but_one_line_escapes(text, read, data, tmp_path_factory):
    for _ in range(data.draw(st.integers(1, 3))):
        start = data.draw(st.integers(0, len(text)))
        stop = data.draw(st.integers(start, min(start + 8, len(text))))
        text = text[:start] + data.draw(TYPED) + text[stop:]
    encoding = data.draw(st.sampled_from(["utf-8", "utf-16", "utf-16-be", "latin-1"]))
    path = tmp_path_factory.getbasetemp() / "typed.csv"
    path.write_bytes(text.encode(encoding, "replace" if encoding == "latin-1" else "surrogatepass"))
    refused = ""
    try:
        read(path)
    except InputError as error:
        refused = str(error)
    assert len(refused.splitlines()) < 2


NUMBERS = st.decimals(min_value=0, max_value=99999, places=3, allow_nan=False).map(abs)


@settings(max_examples=200, deadline=None)
@given(numbers=st.lists(NUMBERS, min_size=1, max_size=5), grouped=st.booleans(), mark=st.sampled_from(".,"))
def test_a_number_is_read_as_it_was_meant_or_not_at_all(numbers, grouped, mark, tmp_path_factory):
    """Spreadsheets of all countries, with a mark after thousands or none, a fraction only where there is one."""
    thousands = {".": ",", ",": "."}[mark] if grouped else ""
    cells = [f"{number:,f}".rstrip("0").rstrip(".").replace(",", "t").replace(".", mark) for number in numbers]
    cells = [cell.replace("t", thousands) for cell in cells]
    path = tmp_path_factory.getbasetemp() / "numbers.csv"
    path.write_text(
        "filled_meshes;drag_n\n" + "".join(f"{i};{cell}\n" for i, cell in enumerate(cells)), encoding="utf-8"
    )
    try:
        found = read_flume_table(path, TableForm())
    except InputError:
        return
    np.testing.assert_allclose(found.columns["drag_n"], [float(number) for number in numbers])
