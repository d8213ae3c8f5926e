"""The command ``codend bow-wave``: the wave at a ship's bow."""

from pathlib import Path

import click

from codend.cli.common import check_writable, out_option, written_into
from codend.errors import OPTIONS, InputError

HULL_NAMES = ("plate", "model-10", "model-20", "model-30", "wigley")
FILES = ("bow_wave.csv", "bow_wave_sheet.csv", "bow_wave.png")
POINTS, ONWARD = 101, 41


@click.command("bow-wave")
@out_option
@click.option("--speed", "speed_m_s", required=True, type=float, metavar="M/S", help="The ship's speed.")
@click.option("--draught", "draught_m", required=True, type=float, metavar="M", help="How deep it goes.")
@click.option(
    "--hull",
    type=click.Choice(HULL_NAMES),
    default="plate",
    show_default=True,
    help="A flat plate, or a hull whose entrance angle is known.",
)
@click.option(
    "--entrance-angle", "angle_deg", type=float, metavar="DEGREES", help="Half the angle at the stem; of a plate only."
)
@click.option(
    "--flare", "flare_deg", type=float, default=0.0, show_default=True, metavar="DEGREES", help="Of the hull's side."
)
@click.option(
    "--stem-share",
    type=float,
    default=0.0,
    show_default=True,
    metavar="SHARE",
    help="Height of the water at the stem over that of the crest; 0 is assumed, for the source has no law for it.",
)
def bow_wave(
    folder: Path,
    speed_m_s: float,
    draught_m: float,
    hull: str,
    angle_deg: float | None,
    flare_deg: float,
    stem_share: float,
) -> None:
    """Height, profile, velocities and sheet of a ship's bow wave, and whether it is steady.

    By the closed forms of Guilbaud, David, Delhommeau and Noblesse. Writes bow_wave.csv (the contact line),
    bow_wave_sheet.csv (water that has left it) and bow_wave.png into DIR; of a wave that is not steady only the plot.
    """
    import numpy as np
    import pandas as pd

    from codend.io.files import write_bytes, write_table
    from codend.report.bow_wave_plot import LONGEST, bow_wave_figure
    from codend.report.own_look import own_look
    from codend.report.style import png
    from codend.scenes.bow_wave import HULLS, LIMIT_ANGLE_DEG, BowWave

    if (angle_deg is None) == (hull == "plate"):
        told = "given with --hull plate, and left out with another hull, whose angle is known"
        raise InputError(OPTIONS, "--entrance-angle", angle_deg, told)
    try:
        wave = BowWave(
            speed_m_s,
            draught_m,
            HULLS[hull].entrance_angle_deg if angle_deg is None else angle_deg,
            flare_deg,
            stem_share,
        )
    except ValueError as error:
        raise click.UsageError(str(error)) from error
    check_writable(folder, FILES)
    unit = wave.length_unit_m
    with written_into(folder, FILES), own_look():
        if wave.steady:
            t = np.linspace(0.0, LONGEST * wave.crest, POINTS)
            u, w = wave.velocity(t)
            line = {
                "along_hull_m": unit * t,
                "height_m": unit * wave.profile(t),
                "along_m_s": speed_m_s * u,
                "up_side_m_s": speed_m_s * w,
            }
            write_table(pd.DataFrame(line), folder / FILES[0])
            left = np.linspace(0.0, wave.crest, POINTS)[1::10]
            along, out, up = (unit * part for part in wave.sheet(left, np.linspace(0.0, wave.crest, ONWARD)))
            sheet = {"left_at_m": np.repeat(unit * left, ONWARD), "along_hull_m": along, "out_m": out, "height_m": up}
            write_table(pd.DataFrame({k: np.ravel(v) for k, v in sheet.items()}), folder / FILES[1])
        write_bytes(png(bow_wave_figure(wave)), folder / FILES[2])
    click.echo(f"Height of the crest  {unit * wave.height:.3g} m (g z / U2 = {wave.height:.3f})")
    if wave.steady:
        click.echo(f"From the stem        {unit * wave.crest:.3g} m along the hull")
        click.echo("The wave is steady.")
    else:
        click.echo("The wave is not steady: higher than U2 / 2g, which no steady flow reaches; no profile is given.")
    if wave.slowest_steady_m_s == 0.0:
        click.echo(f"Steady at any speed, as up to a half entrance angle of {LIMIT_ANGLE_DEG:.2f} degrees")
    else:
        click.echo(f"Steady from          {wave.slowest_steady_m_s:.3g} m/s on at this entrance angle and draught")
