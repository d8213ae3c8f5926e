"""The command ``codend scene``: ropes, netting, weights and floats that are towed, at rest and in motion."""

from pathlib import Path
from typing import TYPE_CHECKING

import click

from codend.cli.common import NOT_CONVERGED, SeveralPairs, Stopped, check_writable, out_option, set_option, written_into
from codend.cli.console import shown_progress, text_table
from codend.errors import OPTIONS, InputError

if TYPE_CHECKING:
    import pandas as pd

    from codend.net.net import Floats
    from codend.scenes.build import BuiltScene

TABLES = ("results.csv", "ropes.csv", "netting.csv", "points.csv", "frame.csv", "floats.csv")
FILES = (*TABLES, "scene.png", "report.html", "motion.png", "motion.gif", "net.pvd")
GOES_ON = "motion_state.npz"
"""What a motion goes on from; there until it has ended."""
GROWN = 1.05
"""Largest pull of a rope since the last output, over that since the one before, that is told at the end."""
JUMP_M_S = 0.05
"""Jump of a vessel's speed that is told."""
TABLE = {
    "name": "rope",
    "tension_from_n": "tension at its first end N",
    "tension_to_n": "at its second N",
    "slack_share": "slack",
    "deepest_m": "deepest m",
}
NETTING_TABLE = {
    "name": "netting",
    "drag_n": "drag along x N",
    "side_force_n": "side force N",
    "lift_n": "lift N",
    "max_bar_tension_n": "largest in a bar N",
    "opening_deg": "opening deg",
    "deepest_m": "deepest m",
}
FRAME_TABLE = {
    "name": "frame",
    "x_m": "x m",
    "y_m": "y m",
    "z_m": "z m",
    "heel_deg": "heel deg",
    "trim_deg": "trim deg",
    "yaw_deg": "yaw deg",
    "force_x_n": "held by x N",
    "force_y_n": "y N",
    "force_z_n": "z N",
}
ACROSS = ("side_force_n", "force_y_n")
"""Forces along y, across the tow."""
FORCES = ("drag_n", "lift_n", "force_x_n", "force_z_n", *ACROSS)
NONE_ACROSS = 1e-6
"""Of the largest of the others, or of 1 N."""
FLOAT_TABLE = {"name": "float", "draft_m": "draft m", "immersed_share": "immersed", "buoyancy_n": "buoyancy N"}


@click.command(cls=SeveralPairs)
@click.argument("scene", metavar="SCENE.toml")
@out_option
@set_option
@click.option(
    "--species", "files", multiple=True, metavar="FILE.toml", help="L50 of a pulsing codend. May be repeated."
)
def scene(scene: str, folder: Path, changes: tuple[str, ...], files: tuple[str, ...]) -> int:
    """Equilibrium of towed or moored ropes and netting with weights, floats and doors, and their motion in time.

    Writes results.csv, ropes.csv, netting.csv, points.csv, of a frame frame.csv and floats.csv, a figure, net_<n>.vtu
    and a report into DIR; of a scene with a table [time] also motion.csv, its figure and film, and net.pvd. A motion
    that was killed goes on from its last output when the same command is given again.

    A codend's plan with a table [vessel] pulses: pulse.csv has its speed, openings and drag in time, pulse_range.csv
    their ranges for every period of heave, with --species what L50 is at the least and the most open, pulse.png shows
    them.
    """
    from codend.io.toml import read_toml

    if "catch" in read_toml(scene, "TOML scene"):
        from codend.cli.pulse import pulse_codend

        return pulse_codend(scene, folder, changes, files)
    if files:
        raise InputError(OPTIONS, "--species", None, "a codend's plan with a table [vessel] in place of a scene")
    from codend.scenes.scene import load_scene

    checked = load_scene(scene, changes)
    check_writable(folder, (*FILES, "motion.csv", GOES_ON))
    import pandas as pd

    from codend.io.files import write_bytes, write_table, write_text
    from codend.report.html import PageFigure
    from codend.report.own_look import own_look
    from codend.report.scene_page import scene_page
    from codend.report.scene_plots import film, motion_figure, scene_figure
    from codend.report.style import png
    from codend.report.vtk import write_bars, write_series
    from codend.scenes.build import build
    from codend.scenes.follow import outputs
    from codend.scenes.frame_measures import float_rows, frame_rows
    from codend.scenes.measures import cautions, point_rows, result_row, rope_rows, settled, solve_scene
    from codend.scenes.netting_measures import netting_rows
    from codend.scenes.other_shapes import frame_errors, netting_errors, not_sought, other_shapes, shape_errors

    built = build(checked)
    placed = checked.time is not None and checked.time.start == "placed"
    # netting placed anyhow is led to its rest by its motion
    found = None if placed and checked.netting else solve_scene(built)
    with written_into(folder, FILES), own_look():
        moved = found is None or (checked.time is not None and (found.converged or placed))
        if moved:
            start = built.problem.net.positions if found is None or placed else found.solution.positions
            peaks, more, last = _move(built, start, folder)
            found = settled(built, last.positions, last.bar_tension) if found is None else found
        assert found is not None
        others = other_shapes(found)
        ropes, notes = pd.DataFrame(rope_rows(found)), cautions(found) + not_sought(found, others)
        if moved:
            ropes[["peak_tension_n", "peak_time_s", "peak_from_end_m"]] = peaks
            notes += more
        else:
            _clear(folder)
            if found.converged:
                tension = found.solution.bar_tension
                write_bars(found.solution.positions, built.problem.net.bars, folder / "net_1.vtu", tension_n=tension)
        shape, pulls = found.solution.positions, found.solution.bar_tension
        holds = found.support
        if moved and not found.converged:  # netting and frame are told as they are at the end of the motion
            shape, pulls, holds = last.positions, last.bar_tension, last.support
        frame, floats = pd.DataFrame(frame_rows(built, shape, holds)), pd.DataFrame(float_rows(built, shape))
        frame = frame.join(pd.DataFrame(frame_errors(found, others)))
        netting = [
            row | errors
            for row, errors in zip(netting_rows(built, shape, pulls), netting_errors(found, others), strict=True)
        ]
        tables = {
            "results.csv": pd.DataFrame([result_row(found) | shape_errors(found, others)]),
            "ropes.csv": ropes,
            "netting.csv": pd.DataFrame(netting),
            "points.csv": pd.DataFrame(point_rows(found)),
            "frame.csv": frame,
            "floats.csv": floats,
        }
        titles = {name: name.removesuffix(".csv").capitalize() for name in tables} | {"results.csv": "Equilibrium"}
        tables = {name: table for name, table in tables.items() if len(table)}
        for name, table in tables.items():
            write_table(table, folder / name)
        figures = []
        if found.converged:
            picture = png(scene_figure(built, found.solution.positions))
            figures.append(PageFigure(picture, "The equilibrium of the tow, not to scale."))
            write_bytes(picture, folder / "scene.png")
        if moved and checked.time is not None:
            picture = png(motion_figure(built, pd.read_csv(folder / "motion.csv")))
            figures.append(PageFigure(picture, "Heights of points, and the largest tension of every rope, in time."))
            write_bytes(picture, folder / "motion.png")
            names = [f"net_{number}.vtu" for number in range(outputs(checked.time))]
            times = [number * checked.time.output_s for number in range(len(names))]
            write_series(names, times, folder / "net.pvd")
            write_bytes(film(built, [folder / name for name in names], times), folder / "motion.gif")
        page = scene_page(checked, [(titles[name], table) for name, table in tables.items()], figures, notes)
        write_text(page, folder / "report.html")
        (folder / GOES_ON).unlink(missing_ok=True)
    shown_tables = ((ropes, TABLE), (pd.DataFrame(netting), NETTING_TABLE), (frame, FRAME_TABLE), (floats, FLOAT_TABLE))
    for table, heads in shown_tables:
        shown = _columns(table, (*heads, "peak_tension_n", "peak_time_s"))
        if shown and len(table):
            words = [heads.get(column, column) for column in shown]
            click.echo(text_table(words, table[shown].itertuples(index=False, name=None)))
    for note in notes:
        click.echo(note)
    return 0 if found.converged or (moved and placed and checked.netting) else NOT_CONVERGED


def _columns(table: "pd.DataFrame", wanted: tuple[str, ...]) -> list[str]:
    """Those of a table that are to be shown: forces across the tow only where there are some."""
    shown = [column for column in wanted if column in table]
    forces = table[[column for column in shown if column in FORCES]].abs().max()
    return [
        column for column in shown if column not in ACROSS or not forces[column] <= NONE_ACROSS * max(forces.max(), 1.0)
    ]


def _clear(folder: Path) -> None:
    """Remove the motion and nets of an earlier scene."""
    for path in (*folder.glob("net_*.vtu"), folder / "motion.csv", folder / GOES_ON):
        path.unlink(missing_ok=True)


def _move(built: "BuiltScene", start: "Floats", folder: Path):  # type: ignore[no-untyped-def]
    """Follow the motion, a file and some rows an output; the ropes' peaks, (r, 3), what is to be told, the end."""
    import io

    import numpy as np
    import pandas as pd

    from codend.io.files import whole_file
    from codend.report.vtk import write_bars
    from codend.scenes.follow import follow, largest_jump, motion_rows, outputs
    from codend.scenes.measures import lies_in_zigzag
    from codend.scenes.step_check import TOLD, by_half_steps, largest_difference, worth_a_check

    scene, time = built.scene, built.scene.time
    assert time is not None
    digest, table, kept = _digest(built), folder / "motion.csv", folder / GOES_ON
    state = _kept_state(kept, table, digest)
    if state is None:
        _clear(folder)
        table.write_bytes(b"")
    else:
        with table.open("rb+") as stream:
            stream.truncate(int(state["written"][0]))
    first, last = (0 if state is None else int(state["number"][0])), outputs(time)
    frame, since = None, [np.zeros(len(built.rope_bars))]
    with shown_progress() as progress:
        try:
            for frame in follow(built, start, state):
                since = [since[-1], frame.since]
                if state is None or frame.number > first:
                    net = folder / f"net_{frame.number}.vtu"
                    tension = frame.bar_tension
                    write_bars(frame.positions, built.problem.net.bars, net, tension_n=tension)
                    rows = io.StringIO()
                    frame_table = pd.DataFrame(motion_rows(built, frame))
                    frame_table.to_csv(rows, index=False, header=frame.number == 0, float_format="%.12g")
                    with table.open("ab") as stream:
                        stream.write(rows.getvalue().encode())
                    with whole_file(kept) as temporary, temporary.open("wb") as stream:
                        size = np.array([float(table.stat().st_size)])
                        np.savez(stream, digest=np.array(digest), written=size, **frame.state)  # type: ignore[arg-type]
                progress(frame.number + 1, last, f"{frame.time_s:.4g} of {time.end_s:g} s")
        except ArithmeticError as error:
            raise Stopped(f"{scene.source}: {error}; a smaller time.step_s may help", NOT_CONVERGED) from error
    assert frame is not None
    notes = []
    if (path := scene.vessel_path()) is not None and (jump := largest_jump(path, time.end_s))[0] > JUMP_M_S:
        said = "the pulls there are of that jump, and of ropes that do not stretch of the step"
        notes.append(f"The vessel's speed jumps by {jump[0]:.3g} m/s at {jump[1]:g} s: {said}.")
    if unsettled := int(frame.state["clock"][2]):
        notes.append(f"In {unsettled} steps it was not settled which bars are slack: take a smaller time.step_s.")
    if (worst := float(frame.state["clock"][3])) > 1e-3:
        notes.append(f"Bars were off their lengths by up to {100.0 * worst:.2g} % in a step: see time.length_error.")
    grown = (since[-1] > GROWN * since[0]) & (since[-1] >= frame.peaks[:, 0])
    if len(since) > 1 and (
        growing := [name for name, grows in zip(built.scene.rope_names, grown, strict=True) if grows]
    ):
        notes.append(f"Pulls still grow at the end, so their peaks are not seen: {', '.join(growing)}.")
    for name, nodes, bars in zip(built.scene.rope_names, built.rope_nodes, built.rope_bars, strict=True):
        if lies_in_zigzag(frame.positions[nodes], frame.bar_tension[bars]):
            notes.append(f"{name} ends in a zigzag of its bars, which comes of long steps: take a smaller time.step_s.")
    if worth_a_check(built):
        try:
            again = by_half_steps(built, start)
        except ArithmeticError:
            notes.append(
                "The motion cannot be followed in steps half as long: do not use it without a smaller time.step_s."
            )
        else:
            off, of = largest_difference(pd.read_csv(table).to_dict("records"), again)
            if off > TOLD:
                said = f"Steps half as long change the {of} by up to {100.0 * off:.2g} % of its largest value"
                notes.append(f"{said}: take a smaller time.step_s.")
    if passages := int(frame.passages[0]):
        seen = f"at {passages} of {last} outputs, first at {frame.passages[1]:g} s"
        prevents = "nothing in a motion prevents" if scene.afloat else "model.contact = true prevents"
        notes.append(f"Netting has passed through itself or a rope, which {prevents}: {seen}.")
    return frame.peaks, notes, frame


def _digest(built: "BuiltScene") -> str:
    """Of all that a motion depends on."""
    from hashlib import sha256
    from importlib.metadata import version

    path = built.scene.vessel_path()
    net = built.problem.net
    parts = [built.scene.model_dump_json(), version("codend"), "" if path is None else path.tobytes().hex()]
    parts += [array.tobytes().hex() for array in (net.point_drag_area, net.point_lift_area)]
    return sha256("\n".join(parts).encode()).hexdigest()


def _kept_state(kept: Path, table: Path, digest: str):  # type: ignore[no-untyped-def]
    """What an earlier run of the same motion left to go on from; None if there is nothing."""
    import zipfile

    import numpy as np

    try:
        with np.load(kept, allow_pickle=False) as found:
            state = dict(found)
    except (OSError, ValueError, EOFError, zipfile.BadZipFile):
        return None
    if str(state.pop("digest", "")) != digest or not table.exists():
        return None
    return state if table.stat().st_size >= state["written"][0] else None
