"""The bow wave's closed forms beside the paper's own measurements. ``python -m validation.bow_wave``.

Guilbaud, David, Delhommeau and Noblesse, section 2, table 1: a flat plate at 2 m/s, draught 0.2 m, entrance and flare
20 degrees, in mm. The formula has the crest a tenth too high and a quarter too far back there; of the flare it knows
nothing in the height, which falls slightly with it in the tests (their figure 8).
"""

from typing import NamedTuple

from codend.scenes.bow_wave import LIMIT_ANGLE_DEG, BowWave

SPEED_M_S, DRAUGHT_M, ANGLE_DEG = 2.0, 0.2, 20.0


class Row(NamedTuple):
    """A row of table 1, mm."""

    name: str
    height: float
    height_deviation: float
    behind_stem: float
    behind_stem_deviation: float


TABLE_1 = (
    Row("series 1", 129.4, 0.67, 151.20, 4.61),
    Row("series 2", 129.54, 0.84, 138.36, 6.01),
    Row("both", 129.46, 0.77, 145.21, 8.21),
)


def formula() -> tuple[float, float]:
    """Height of the crest and its distance behind the stem under the conditions of table 1, mm."""
    wave = BowWave(SPEED_M_S, DRAUGHT_M, ANGLE_DEG, ANGLE_DEG)
    unit = 1e3 * wave.length_unit_m
    return unit * wave.height, unit * wave.crest


def main() -> None:
    """Print table 1 beside the formula, and the angle up to which the wave is always steady."""
    height, behind = formula()
    print(f"{'':10s}{'height mm':>18s}{'formula':>9s}{'off':>8s}{'behind the stem mm':>22s}{'formula':>9s}{'off':>8s}")
    for row in TABLE_1:
        print(
            f"{row.name:10s}{row.height:10.2f} +- {row.height_deviation:4.2f}{height:9.1f}"
            f"{100.0 * (height / row.height - 1.0):+7.1f}%{row.behind_stem:14.2f} +- {row.behind_stem_deviation:4.2f}"
            f"{behind:9.1f}{100.0 * (behind / row.behind_stem - 1.0):+7.1f}%"
        )
    print(f"steady at any speed up to a half entrance angle of {LIMIT_ANGLE_DEG:.2f} degrees (the paper: about 12)")


if __name__ == "__main__":
    main()
