"""What README shows is what works."""

import re

import codend
from tests import ROOT

README = (ROOT / "README.md").read_text(encoding="utf-8")


def test_the_plan_in_the_readme_loads(tmp_path):
    plan = tmp_path / "plan.toml"
    plan.write_text(re.search(r"```toml\n(.*?)```", README, re.S).group(1), encoding="utf-8")
    assert len(codend.load_plan(plan).cases()) == 3


def test_the_python_in_the_readme_and_on_fits_runs(monkeypatch, capsys):
    monkeypatch.chdir(ROOT)
    (study,) = re.findall(r"```python\n(.*?)```", README, re.S)
    manual = (ROOT / "codend" / "guide" / "selectivity.md").read_text(encoding="utf-8")
    (fits,) = re.findall(r"```python\n(.*?)```", manual, re.S)
    exec(study, {})
    assert "drag_n" in capsys.readouterr().out
    exec(fits, {})
    assert capsys.readouterr().out.startswith("one-stage 20.5")


def test_ci_does_what_the_readme_says():
    command = next(line for line in README.splitlines() if "pytest" in line)
    assert command in (ROOT / ".ci" / "run").read_text(encoding="utf-8")


def test_every_file_the_readme_names_exists():
    for name in re.findall(r"(?:validation|catch_models)/[\w./]+\.\w+", README):
        assert (ROOT / name).is_file(), name
