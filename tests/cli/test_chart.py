"""Charts of speed against accuracy: for any case of any plan, confirmed, with what would be chosen automatically."""

import numpy as np
import pandas as pd
import pytest

from codend.errors import InputError
from codend.studies.speed_accuracy.contenders import FULL, MEMBRANE, MERGED, RIGID, contenders, scene_from
from tests.cli.test_cli import TINY_PLAN, assert_refused, codend_cli


@pytest.fixture
def plan(tmp_path):
    path = tmp_path / "plan.toml"
    path.write_text(TINY_PLAN, encoding="utf-8")
    return path


def test_the_command_charts_one_case_and_says_what_is_fastest_and_what_is_chosen(plan, tmp_path):
    folder = tmp_path / "chart"
    done = codend_cli("chart", plan, "--case", 2, "--quick", "--out", folder)
    assert done.exit_code == 0, done.stderr
    points, choices = pd.read_csv(folder / "chart.csv"), pd.read_csv(folder / "chart_choices.csv")
    assert set(points["model"]) == {"sector", MERGED, FULL, MEMBRANE}
    exact = points[(points["method"] == "Newton") & (points["tolerance"] == 1e-10)]
    assert exact["drag_error"].max() < 1e-8
    assert choices["accuracy"].tolist() == [0.1, 0.01, 0.001, 1e-6]
    assert np.all(choices["chosen_drag_error"] <= choices["accuracy"])
    assert np.all(choices["fastest_error"] <= choices["accuracy"])
    assert "others confirm in drag: sector by relaxation" in done.stdout
    known = {f"{row.model}, {row.method}" for row in points.itertuples()}
    assert set(choices["chosen"]) <= known  # one spelling for what is tried and what is chosen
    for name in ("drag", "opening", "volume"):
        assert (folder / f"chart_{name}.png").stat().st_size > 10_000


def test_what_is_tried_fits_the_plan(plan):
    tried = {contender.method for contender in contenders(scene_from(plan), quick=True)}
    assert RIGID in tried
    elastic = scene_from(plan, ["netting.0.axial_stiffness_n=1000"])
    assert RIGID not in {contender.method for contender in contenders(elastic, quick=True)}
    by_volume = scene_from(plan, ["catch.volume_m3=0.02"])
    assert MEMBRANE not in {contender.model for contender in contenders(by_volume, quick=True)}
    heavy = scene_from(plan, ["netting.0.twine_density_kg_m3=7800", "tow.speed_m_s=0.2"])
    assert heavy.weighed
    assert not heavy.is_membrane


def test_a_plan_that_asks_for_a_model_is_charted_by_all(plan):
    asked = ["model.fidelity=globalised", "model.globalisation=2", "model.method=newton"]
    assert scene_from(plan, asked).factors == scene_from(plan).factors == (2, 1)


def test_a_case_that_is_not_there_is_refused_before_the_work(plan, tmp_path):
    with pytest.raises(InputError, match="1 to 2"):
        scene_from(plan, number=3)
    assert_refused(codend_cli("chart", plan, "--case", 3, "--out", tmp_path / "chart"), "case", "1 to 2")
    assert not (tmp_path / "chart").exists()


def test_a_reference_that_is_not_found_gives_status_3_and_no_files(plan, tmp_path):
    # more than the bag holds, though not more than a cylinder of the netting stretched both ways would
    done = codend_cli("chart", plan, "--quick", "--set", "catch.volume_m3=0.2", "--out", tmp_path / "chart")
    assert done.exit_code == 3
    assert "reference" in done.stderr
    assert not (tmp_path / "chart").exists()


def test_a_plan_with_a_strap_is_charted_without_the_membrane(plan):
    strapped = scene_from(plan, ["strap=[{meshes_from_codline=3, length_m=0.5}]"])
    assert MEMBRANE not in {contender.model for contender in contenders(strapped, quick=True)}
