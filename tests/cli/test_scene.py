"""``codend scene``: what it writes, refuses, and takes up again."""

import os
import signal
import subprocess
import sys
import time

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner

from codend.cli.main import main
from codend.cli.scene import _columns

SCENE = """
title = "One warp"
[vessel]
speed_m_s = 1.8
[[rope]]
name = "warp"
from = "vessel"
to = "gear"
length_m = 100.0
diameter_mm = 12.0
mass_kg_m = 0.5
bars = 8
[[point]]
name = "gear"
mass_kg = 200.0
wet_weight_n = 1500.0
area_m2 = 0.5
drag = 1.0
"""
TIME = '[time]\nend_s = {end}\noutput_s = {every}\nstart = "placed"\n'


@pytest.fixture
def scene(tmp_path):
    def written(more=""):
        path = tmp_path / "scene.toml"
        path.write_text(SCENE + more)
        return path

    return written


def test_an_equilibrium_is_tables_a_picture_a_vtk_file_and_a_page(scene, tmp_path):
    done = CliRunner().invoke(main, ["scene", str(scene()), "--out", str(tmp_path / "out")])
    assert done.exit_code == 0, done.output
    names = {path.name for path in (tmp_path / "out").iterdir()}
    assert names == {"results.csv", "ropes.csv", "points.csv", "scene.png", "net_1.vtu", "report.html"}
    row = pd.read_csv(tmp_path / "out" / "results.csv").iloc[0]
    rope = pd.read_csv(tmp_path / "out" / "ropes.csv").iloc[0]
    assert bool(row["converged"])
    assert rope["name"] == "warp"
    assert row["pull_n"] == pytest.approx(rope["tension_from_n"], rel=1e-3)
    assert "le-bris-1999" in (tmp_path / "out" / "report.html").read_text()


WALL = """title = "A wall"
[[netting]]
name = "wall"
mesh = "diamond"
bar_mm = 50.0
twine_mm = 2.0
meshes_across = 4
meshes_long = 4
fore = "ground"
corners = [[0, 0, 0], [0, 0.3, 0], [0, 0.3, -0.2], [0, 0, -0.2]]
"""


@pytest.mark.parametrize(("side_n", "told"), [(3e-7, False), (0.1, True)])
def test_a_table_shows_forces_across_the_tow_where_there_are_some(side_n, told):
    table = pd.DataFrame([{"name": "wall", "drag_n": 0.3, "side_force_n": side_n, "lift_n": 0.01}])
    shown = ["name", "drag_n", "side_force_n", "lift_n"]
    assert _columns(table, (*shown, "opening_deg")) == [name for name in shown if told or name != "side_force_n"]


def test_a_current_to_the_side_is_seen_in_the_table(tmp_path):
    path = tmp_path / "wall.toml"
    path.write_text(WALL + "[water]\nflow_m_s = [0.5, 0.5, 0.0]\n")
    done = CliRunner().invoke(main, ["scene", str(path), "--out", str(tmp_path / "out")])
    assert done.exit_code == 0, done.output
    assert "side" in done.stdout.split()


def test_netting_without_ropes_has_no_table_of_them(tmp_path):
    path = tmp_path / "wall.toml"
    path.write_text(WALL + "[water]\nflow_m_s = [0.5, 0.0, 0.0]\n[time]\nend_s = 0.2\noutput_s = 0.1\n")
    done = CliRunner().invoke(main, ["scene", str(path), "--out", str(tmp_path / "out")])
    assert done.exit_code == 0, done.output
    assert "peak_tension_n" not in done.stdout
    assert not (tmp_path / "out" / "ropes.csv").exists()


def test_a_mistake_ends_the_run_with_one_line_and_nothing_written(scene, tmp_path):
    done = CliRunner().invoke(main, ["scene", str(scene()), "--out", str(tmp_path / "out"), "--set", "rope.0.to=door"])
    assert done.exit_code == 2
    assert not (tmp_path / "out").exists()


def test_a_killed_motion_goes_on_from_its_last_output(scene, tmp_path):
    plan = scene(TIME.format(end=6, every=0.25))
    whole, parts = tmp_path / "whole", tmp_path / "parts"
    run = [sys.executable, "-c", "from codend.cli.main import main; main()", "scene", str(plan), "--out"]
    killed = subprocess.Popen([*run, str(parts)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    while killed.poll() is None and not (parts / "net_5.vtu").exists():
        time.sleep(0.005)
    os.kill(killed.pid, signal.SIGKILL)
    killed.wait()
    assert not (parts / "report.html").exists()
    kept = {path.name: path.stat().st_mtime_ns for path in parts.glob("net_[0-3].vtu")}
    for folder in (parts, whole):
        done = CliRunner().invoke(main, ["scene", str(plan), "--out", str(folder)])
        assert done.exit_code == 0, done.output
    assert {path.name: path.stat().st_mtime_ns for path in parts.glob("net_[0-3].vtu")} == kept
    assert (parts / "motion.csv").read_bytes() == (whole / "motion.csv").read_bytes()
    assert {path.name for path in parts.iterdir()} == {path.name for path in whole.iterdir()}
    table = pd.read_csv(whole / "motion.csv")
    assert list(table.columns[:6]) == ["time_s", "name", "x_m", "y_m", "z_m", "tension_n"]
    assert np.array_equal(np.unique(table["time_s"]), np.arange(0.0, 6.1, 0.25))
    assert len(list(whole.glob("net_*.vtu"))) == 25
    assert (whole / "net.pvd").read_text().count("<DataSet") == 25


def test_another_scene_does_not_go_on_where_the_first_was_killed(scene, tmp_path):
    out = tmp_path / "out"
    for end in (2, 1):
        done = CliRunner().invoke(main, ["scene", str(scene(TIME.format(end=end, every=0.5))), "--out", str(out)])
        assert done.exit_code == 0, done.output
    assert len(list(out.glob("net_*.vtu"))) == 3
    assert pd.read_csv(out / "motion.csv")["time_s"].max() == 1.0


@pytest.mark.parametrize(("step_s", "told"), [(1.0, True), (0.1, False)])
def test_a_motion_in_steps_too_long_for_its_bars_says_so(scene, tmp_path, step_s, told):
    path = scene(TIME.format(end=8.0, every=8.0) + f"step_s = {step_s}\n")
    done = CliRunner().invoke(main, ["scene", str(path), "--set", "rope.0.bars=40", "--out", str(tmp_path / "out")])
    assert done.exit_code == 0, done.output
    assert ("warp ends in a zigzag of its bars" in done.output) == told


@pytest.mark.parametrize(("held", "told"), [("held_from_s = 1.0\n", True), ("", False)])
def test_pulls_that_still_grow_at_the_end_are_told(scene, tmp_path, held, told):
    path = scene(held + "[time]\nend_s = 3.0\noutput_s = 0.5\n")
    stretch = ["--set", "rope.0.axial_stiffness_n=1e6"]
    done = CliRunner().invoke(main, ["scene", str(path), *stretch, "--out", str(tmp_path / "out")])
    assert done.exit_code == 0, done.output
    assert ("Pulls still grow at the end, so their peaks are not seen: warp." in done.output) == told
