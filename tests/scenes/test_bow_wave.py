"""The closed forms of a bow wave hold each other up, and the paper's own measurements stand beside them."""

import ast
import math
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner
from hypothesis import given
from hypothesis import strategies as st

from codend.cli.main import main
from codend.scenes import bow_wave
from codend.scenes.bow_wave import HULLS, LIMIT_ANGLE_DEG, STEADY_LIMIT, BowWave, steady_limit
from validation.bow_wave import TABLE_1, formula

waves = st.builds(
    BowWave,
    speed_m_s=st.floats(1.0, 10.0),
    draught_m=st.floats(0.1, 5.0),
    entrance_angle_deg=st.floats(1.0, 20.0),
    flare_deg=st.floats(0.0, 60.0),
    stem_share=st.floats(0.0, 0.9),
).filter(lambda wave: wave.height < 0.98 * STEADY_LIMIT)


@given(waves)
def test_the_rise_is_the_free_flight_of_water_whose_speed_bernoulli_tells(wave):
    t = np.linspace(0.0, wave.crest, 30)
    onward = math.sqrt(1.0 - 2.0 * wave.height)
    upward = math.sqrt(2.0 * wave.height * (1.0 - wave.stem_share))
    start = wave.stem_share * wave.height
    assert onward**2 + upward**2 + 2.0 * start == pytest.approx(1.0, rel=1e-14)
    time = t / onward
    np.testing.assert_allclose(wave.profile(t), start + upward * time - 0.5 * time**2, atol=1e-14)


@given(waves)
def test_velocity_follows_the_line_the_side_and_bernoulli(wave):
    t = np.linspace(0.0, 3.0 * wave.crest, 50)
    u, w = wave.velocity(t)
    np.testing.assert_allclose(w / u, wave.slope(t) / math.cos(math.radians(wave.flare_deg)), rtol=1e-12, atol=1e-14)
    np.testing.assert_allclose(u**2 + w**2, 1.0 - 2.0 * wave.profile(t), rtol=1e-12)
    step = 1e-6
    inside = t[1:][np.abs(t[1:] - wave.crest) > 2.0 * step]
    differences = (wave.profile(inside + step) - wave.profile(inside - step)) / (2.0 * step)
    np.testing.assert_allclose(wave.slope(inside), differences, atol=1e-8)


@given(waves)
def test_the_sheet_leaves_the_hull_along_the_velocity_and_falls_freely(wave):
    t, flare = np.linspace(0.0, wave.crest, 7), math.radians(wave.flare_deg)
    onward = np.array([0.0, 1e-3, 2e-3])
    along, out, up = wave.sheet(t, onward)
    u, w = wave.velocity(t)
    np.testing.assert_allclose(up[:, 0], wave.profile(t), atol=1e-15)
    np.testing.assert_allclose(out[:, 0], wave.profile(t) * math.tan(flare), atol=1e-15)
    np.testing.assert_allclose(along[:, 2] - along[:, 0], onward[2])
    time = 1e-3 / u
    np.testing.assert_allclose((up[:, 2] - 2.0 * up[:, 1] + up[:, 0]) / time**2, -1.0, rtol=1e-6)
    np.testing.assert_allclose((out[:, 1] - out[:, 0]) / time, w * math.sin(flare), atol=1e-9)


def test_the_limit_of_steady_waves_meets_standstill_at_the_papers_angle():
    assert pytest.approx(12.51, abs=5e-3) == LIMIT_ANGLE_DEG
    assert steady_limit(LIMIT_ANGLE_DEG) == pytest.approx(0.0, abs=1e-12)
    assert steady_limit(0.9 * LIMIT_ANGLE_DEG) == 0.0
    for angle in (15.0, 25.0, 60.0):
        slowest = BowWave(1.0, 0.2, angle).slowest_steady_m_s
        assert not BowWave(0.999 * slowest, 0.2, angle).steady
        assert BowWave(1.001 * slowest, 0.2, angle).steady


def test_beside_the_papers_table_1_the_crest_is_a_tenth_too_high_and_a_quarter_too_far_back():
    height, behind = formula()
    both = TABLE_1[-1]
    assert height == pytest.approx(1.10 * both.height, rel=0.01)
    assert behind == pytest.approx(1.28 * both.behind_stem, rel=0.01)


@given(waves)
def test_water_at_the_contact_line_goes_along_it_and_along_the_side(wave):
    # along the hull t, out m and up z: on the line m = zeta tan(gamma), z = zeta, whatever the surface across it does
    flare, t = math.radians(wave.flare_deg), np.linspace(0.05, 1.9, 40) * wave.crest
    u, w = wave.velocity(t)
    velocity = np.stack([u, w * math.sin(flare), w * math.cos(flare)])
    slope = wave.slope(t)
    line = np.stack([np.ones_like(t), slope * math.tan(flare), slope])
    np.testing.assert_allclose(np.cross(velocity, line, axis=0), 0.0, atol=1e-12)
    np.testing.assert_allclose((velocity**2).sum(axis=0), 1.0 - 2.0 * wave.profile(t), rtol=1e-12)
    # the hull's side leans out by the flare: nothing goes through it
    np.testing.assert_allclose(-velocity[1] * math.cos(flare) + velocity[2] * math.sin(flare), 0.0, atol=1e-14)


def test_the_file_imports_nothing_of_the_rest():
    tree = ast.parse(Path(bow_wave.__file__).read_text(encoding="utf-8"))
    named = {alias.name for node in ast.walk(tree) if isinstance(node, ast.Import) for alias in node.names}
    named |= {node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)}
    assert named == {"math", "dataclasses", "typing", "numpy", "numpy.typing"}


@pytest.mark.parametrize(
    ("hull", "right"), [("model-10", 10.0), ("model-20", 20.0), ("model-30", 30.0), ("wigley", None)]
)
def test_a_hull_opens_at_the_angle_of_its_waterline(hull, right):
    # GD 4: y = x tan(a) - 3 / (2 L) x^2 tan(a); Wigley: y = B / 2 (1 - (1 - 2 x / L)^2), B = L / 10
    length, x = 1.5, 1e-7
    if right is None:
        y = 0.05 * length * (1.0 - (1.0 - 2.0 * x / length) ** 2)
    else:
        y = x * math.tan(math.radians(right)) * (1.0 - 1.5 * x / length)
    assert HULLS[hull].entrance_angle_deg == pytest.approx(math.degrees(math.atan2(y, x)), rel=1e-5)


@pytest.mark.parametrize("hull", [*HULLS, "plate"])
def test_the_command_writes_line_sheet_and_plot(hull, tmp_path):
    angle = ["--entrance-angle", "15"] if hull == "plate" else []
    said = ["bow-wave", "--speed", "3", "--draught", "0.2", "--hull", hull, *angle, "--out", str(tmp_path)]
    result = CliRunner().invoke(main, said)
    assert result.exit_code == 0, result.output
    assert "The wave is" in result.output
    line = pd.read_csv(tmp_path / "bow_wave.csv")
    assert line["height_m"].max() == pytest.approx(line["height_m"][40], rel=1e-3)
    assert (tmp_path / "bow_wave_sheet.csv").exists()
    assert (tmp_path / "bow_wave.png").exists()


def test_of_a_wave_that_is_not_steady_no_profile_is_left(tmp_path):
    common = ["bow-wave", "--draught", "0.2", "--entrance-angle", "40", "--out", str(tmp_path)]
    assert CliRunner().invoke(main, [*common, "--speed", "9"]).exit_code == 0
    slow = CliRunner().invoke(main, [*common, "--speed", "1"])
    assert slow.exit_code == 0
    assert "not steady" in slow.output
    assert sorted(path.name for path in tmp_path.iterdir() if not path.name.startswith(".")) == ["bow_wave.png"]


@pytest.mark.parametrize(
    ("options", "named"),
    [
        (["--speed", "0", "--draught", "1", "--entrance-angle", "20"], "speed_m_s"),
        (["--speed", "1e200", "--draught", "1", "--entrance-angle", "20"], "speed_m_s"),
        (["--speed", "2", "--draught", "-1", "--entrance-angle", "20"], "draught_m"),
        (["--speed", "2", "--draught", "1", "--entrance-angle", "90"], "entrance_angle_deg"),
        (["--speed", "2", "--draught", "1", "--entrance-angle", "20", "--flare", "nan"], "flare_deg"),
        (["--speed", "2", "--draught", "1", "--entrance-angle", "20", "--stem-share", "1"], "stem_share"),
        (["--speed", "2", "--draught", "1"], "--entrance-angle"),
        (["--speed", "2", "--draught", "1", "--hull", "wigley", "--entrance-angle", "20"], "--entrance-angle"),
    ],
)
def test_what_no_bow_has_is_refused_in_one_line(options, named, tmp_path):
    result = CliRunner().invoke(main, ["bow-wave", *options, "--out", str(tmp_path / "out")])
    assert result.exit_code == 2
    assert named in result.stderr
    assert len(result.stderr.splitlines()) == 1
    assert not (tmp_path / "out").exists()
