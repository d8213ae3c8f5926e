"""Writes the default pressure law as cubic pieces, from its curve: ``python -m validation.make_sphere_pieces``."""

from importlib.resources import files
from pathlib import Path

import numpy as np

from catch_models.pressure import sphere_law_through
from codend.io.files import whole_file
from codend.io.input_table import read_table

HEADER = """\
# 1 - Cp on a sphere as cubic pieces in theta: computed from sphere_cp_subcritical.csv, a reconstruction (see there), by
# python -m validation.make_sphere_pieces. A piece begins at theta_rad and holds to the next, the last one to pi.
theta_rad,cubic,square,slope,value
"""


def main() -> None:
    """Write the file that ships."""
    data = Path(str(files("catch_models") / "data"))
    table = read_table(data / "sphere_cp_subcritical.csv")
    law = sphere_law_through(table.numbers("theta_deg"), table.numbers("cp"))
    rows = np.column_stack([law.angles_rad[:-1], law.coefficients.T])
    with whole_file(data / "sphere_cp_subcritical_pieces.csv") as temporary:
        text = "".join(",".join(map(repr, row)) + "\n" for row in rows.tolist())
        temporary.write_text(HEADER + text, encoding="utf-8")


if __name__ == "__main__":
    main()
