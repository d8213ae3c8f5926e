"""A net too large for the memory there is ends in one line before it is built, with the merged net that would fit."""

import subprocess
import sys

import pytest

from codend.equilibrium import fidelity, room
from codend.errors import TooLittleMemory
from codend.solvers.memory import free_bytes, needed_bytes
from codend.studies import study
from tests.cli import processes
from tests.plans import joined_plan, make_plan

FULL = {"fidelity": "full"}


@pytest.mark.parametrize(
    ("counts", "said"),
    [
        ((10_000, 8_000), "globalisation = "),
        ((9_973, 9_967), "no meshes of this plan can be merged so far that it fits"),
    ],
)
def test_a_net_of_millions_of_knots_is_refused_with_the_merged_one_that_fits(counts, said):
    plan = make_plan(counts[0], counts[1], model=FULL)
    with pytest.raises(TooLittleMemory, match=said) as error:
        study.solve(plan)
    assert len(str(error.value).splitlines()) == 1
    assert "knots take about" in str(error.value)


def test_the_merged_net_that_is_named_fits(monkeypatch):
    plan = make_plan(120, 60, model=FULL)
    choice = fidelity.choose(plan)
    monkeypatch.setattr(room, "free_bytes", lambda: needed_bytes(1 + choice.knots // 9))
    with pytest.raises(TooLittleMemory, match=r"3 x 3 meshes merged into one .*model\.globalisation = 3"):
        room.check_room(plan, choice)
    merged = make_plan(120, 60, model={"fidelity": "globalised", "globalisation": 3})
    room.check_room(merged, fidelity.choose(merged))


def test_want_of_memory_at_the_factorisation_names_the_merged_net_too(monkeypatch):
    def spent(*_: object) -> None:
        raise MemoryError

    monkeypatch.setattr(study.equilibrium, "solve", spent)
    plan = joined_plan(("diamond", 12, 6, 40.0, {}), ("diamond", 13, 6, 40.0, {}))
    monkeypatch.setattr(room, "free_bytes", lambda: 2 * needed_bytes(fidelity.choose(plan).knots))
    with pytest.raises(TooLittleMemory, match="knots take about"):
        study.solve(plan)


def test_what_ran_out_while_a_net_was_judged_names_a_merged_net_of_half_of_what_there_was(monkeypatch):
    def spent(*_: object) -> None:
        raise MemoryError

    plan = make_plan(24, 20, model=FULL)
    free = 1.2 * needed_bytes(fidelity.choose(plan).knots)
    monkeypatch.setattr(study, "_judged", spent)
    monkeypatch.setattr(room, "free_bytes", lambda: free)
    with pytest.raises(TooLittleMemory, match="there was did not do; 2 x 2 meshes merged into one"):
        study.solve(plan)


def test_want_of_memory_beside_a_small_net_is_not_laid_to_the_net(monkeypatch):
    def spent(*_: object) -> None:
        raise MemoryError

    monkeypatch.setattr(study.equilibrium, "solve", spent)
    with pytest.raises(MemoryError) as error:
        study.solve(make_plan())
    assert not isinstance(error.value, TooLittleMemory)


def test_free_memory_is_told_and_a_limit_of_the_process_counts():
    assert free_bytes() > 0.0
    if sys.platform != "linux":
        pytest.skip("limits of a process are Linux's")
    told = (
        "import resource; from codend.solvers.memory import free_bytes; "
        "resource.setrlimit(resource.RLIMIT_AS, (2**30, 2**30)); print(free_bytes())"
    )
    found = subprocess.run([sys.executable, "-c", told], capture_output=True, text=True, check=True)
    assert float(found.stdout) < 2**30


def test_a_run_too_large_ends_in_one_line_and_writes_nothing(tmp_path):
    plan = tmp_path / "plan.toml"
    plan.write_text(
        'title = "large"\n[tow]\nspeed_m_s = 1.0\n[entry]\nradius_m = 5.0\n[[netting]]\nmesh = "diamond"\n'
        "meshes_round = 10000\nmeshes_long = 10000\nbar_mm = 20.0\ntwine_mm = 0.5\n[catch]\nfilled_meshes = 100.0\n"
        '[model]\nfidelity = "full"\n'
    )
    ended = processes.run("run", plan, "--out", tmp_path / "out")
    assert ended.returncode == 1
    assert "too little memory: 2" in ended.stderr
    assert "Traceback" not in ended.stderr
    assert not (tmp_path / "out" / "results.csv").exists()
