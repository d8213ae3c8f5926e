"""The program starts whatever it finds: caches, homes, settings, names, encodings and devices."""

import os
import shutil
from pathlib import Path

import pytest
from numba.core.caching import UserProvidedCacheLocator

from tests import ROOT
from tests.cli.processes import COMMAND, environment, numbers, run, words
from tests.cli.test_cli import TINY_PLAN, assert_refused, codend_cli

ROOMS = ("codend", "catch_models")


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a plan, the run of it that nothing disturbed, and the program with a kernel cache of its own.

    That begins with what has been compiled by now: compiling all of it takes a minute.
    """
    folder = tmp_path_factory.mktemp("anywhere")
    for room in ROOMS:
        shutil.copytree(ROOT / room, folder / room, ignore=shutil.ignore_patterns("*.pyc*", "*.tmp.*"))
    (folder / "plan.toml").write_text(TINY_PLAN, encoding="utf-8")
    done = run("run", folder / "plan.toml", "--out", folder / "plain", env=cached(folder))
    assert done.returncode == 0, done.stderr
    return folder


def cached(folder: Path, **changes: str | None) -> dict[str, str]:
    return environment({"NUMBA_CACHE_DIR": None, **changes}, folder)


def flip(path: Path) -> None:
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 0x10
    path.write_bytes(content)


DAMAGES = {
    "empty": lambda path: path.write_bytes(b""),
    "cut": lambda path: path.write_bytes(path.read_bytes()[:100]),
    "zeros": lambda path: path.write_bytes(bytes(path.stat().st_size)),
    "flipped": flip,
}
DROPPED = "codend: damaged or unreadable files of compiled kernels were dropped; they are compiled anew\n"


@pytest.mark.parametrize("damage", DAMAGES)
@pytest.mark.parametrize("kind", ["nbi", "nbc"])
def test_a_damaged_cache_file_is_compiled_anew(kind: str, damage: str, home: Path, tmp_path: Path):
    (file,) = (home / "codend").rglob(f"newton_state.measure-*.{kind}")
    DAMAGES[damage](file)
    first, second = (run("run", home / "plan.toml", "--out", tmp_path, env=cached(home)) for _ in range(2))
    assert (first.returncode, second.returncode) == (0, 0)
    assert (DROPPED in first.stderr, words(second)) == (True, "")
    assert numbers(tmp_path / "results.csv").equals(numbers(home / "plain" / "results.csv"))


def test_doctor_names_the_damaged_cache_files_and_removes_them(home: Path):
    files = [*home.rglob("filling.fill_by*.nbi"), *home.rglob("bars.bar_vector*.nbc")]
    for file in files:
        DAMAGES["cut"](file)
    first, second = (run("doctor", env=cached(home)) for _ in range(2))
    assert (first.returncode, second.returncode) == (0, 0), first.stdout
    assert first.stdout.count("damaged files removed") == 2
    assert "damaged" not in second.stdout
    assert not any(file.exists() for file in files)


def test_without_a_cache_folder_that_can_be_written_a_temporary_one_is_taken_with_a_word(home: Path, tmp_path: Path):
    """One that an earlier run left there, of which kernels of the solvers' room are gone: compiling all is slow."""
    for room in ROOMS:
        shutil.copytree(home / room, tmp_path / room, ignore=shutil.ignore_patterns("__pycache__"))
    kept = tmp_path / "temporary" / f"codend-{os.getuid() if hasattr(os, 'getuid') else 'cache'}"
    for folder in (tmp_path / room for room in ROOMS):
        for path in (folder, *(path for path in folder.rglob("*") if path.is_dir())):
            (path / "__pycache__").touch()  # a file: nothing can be put into it, not even by root
            compiled = home / path.relative_to(tmp_path) / "__pycache__"
            room = kept / UserProvidedCacheLocator.get_suitable_cache_subpath(str(path / "any.py"))
            if compiled.is_dir():
                shutil.copytree(compiled, room, ignore=shutil.ignore_patterns("*.pyc", "kernels.*"))
    kept.chmod(0o700)
    assert not list(kept.rglob("kernels.advance*"))
    nowhere = {"HOME": "/dev/null/no", "XDG_CACHE_HOME": None, "NUMBA_CACHE_DIR": None}
    env = environment({**nowhere, "TMPDIR": str(tmp_path / "temporary")}, tmp_path)
    done = run("run", home / "plan.toml", "--out", tmp_path / "out", env=env)
    assert done.returncode == 0, done.stderr
    assert "no cache folder can be written" in done.stderr
    assert numbers(tmp_path / "out" / "results.csv").equals(numbers(home / "plain" / "results.csv"))
    assert list(kept.rglob("kernels.advance*"))
    again = run("run", home / "plan.toml", "--out", tmp_path / "out", env=env)
    assert words(again).count("\n") == 1
    asked = run("doctor", env=env)
    assert asked.returncode == 0, asked.stdout
    assert str(tmp_path / "temporary") in asked.stdout


@pytest.mark.parametrize("content", [b"text.usetex: True\nlines.linewidth: 9\n", b"\xff\xfe\x00"])
def test_no_users_settings_reach_the_plots(content: bytes, home: Path, tmp_path: Path):
    (tmp_path / "matplotlibrc").write_bytes(content)
    env = cached(home, MPLBACKEND="nonsense", MATPLOTLIBRC=str(tmp_path / "matplotlibrc"))
    done = run("run", home / "plan.toml", "--out", tmp_path / "out", env=env, cwd=tmp_path)
    assert (done.returncode, words(done)) == (0, "")
    for plot in (home / "plain" / "plots").iterdir():
        assert (tmp_path / "out" / "plots" / plot.name).read_bytes() == plot.read_bytes(), plot.name
    asked = run("doctor", env=env, cwd=tmp_path)
    assert asked.returncode == 0
    assert "which plots do not follow" in asked.stdout


@pytest.mark.skipif(os.name == "nt", reason="names there are texts")
@pytest.mark.parametrize(
    "encoding",
    [{}, {"LC_ALL": "C", "PYTHONUTF8": "0"}, {"PYTHONIOENCODING": "cp1252"}, {"PYTHONIOENCODING": "ascii"}],
    ids=str,
)
@pytest.mark.parametrize("letter", ["ä", "\udce4", "漁"], ids=["umlaut", "not UTF-8", "fish"])
def test_any_file_name_and_output_encoding_will_do(letter: str, encoding: dict, home: Path, tmp_path: Path):
    folder = tmp_path / letter
    try:
        folder.mkdir()
    except OSError:
        pytest.skip("this file system takes no such name")
    (folder / "Cp-Ω.csv").write_text("theta_deg,cp\n0,1\n90,-0.5\n180,0.4\n", encoding="utf-8")
    plan = folder / f"plan{letter}.toml"
    text = TINY_PLAN.replace("A small bag", "漁 Ω").replace("[catch]", '[catch]\nsphere_cp_csv = "Cp-Ω.csv"')
    plan.write_text(text, encoding="utf-8")
    done = run("run", plan, "--out", folder / "out", env=cached(home, **encoding))
    assert (done.returncode, words(done)) == (0, "")
    assert "漁 Ω" in (folder / "out" / "report.html").read_text(encoding="utf-8")
    refused = run("run", plan, "--set", "netting.0.bar_mm=-1", "--out", folder / "out", env=cached(home, **encoding))
    assert (refused.returncode, refused.stderr.count("\n")) == (2, 1)
    if letter != "\udce4":  # a plan is UTF-8, and can name no other Cp curve
        swept = ["sweep", plan, "--vary", "tow.speed_m_s=[1,2]", "--out", folder / "sweep"]
        for _ in range(2):
            done = run(*swept, env=cached(home, **encoding))
            assert (done.returncode, words(done)) == (0, "")


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no full device")
def test_an_output_on_a_full_device_ends_in_one_line(home: Path, tmp_path: Path):
    with open("/dev/full", "wb") as full:
        done = run("run", home / "plan.toml", "--out", tmp_path / "out", env=cached(home), stdout=full)
        assert (done.returncode, done.stderr) == (1, "codend: standard output: No space left on device\n")
        assert not (tmp_path / "out").exists()
        done = run("run", home / "plan.toml", "--out", tmp_path / "out", env=cached(home), stderr=full)
        assert done.returncode == 0
        assert run("run", tmp_path / "none.toml", "--out", tmp_path, env=cached(home), stderr=full).returncode == 2


@pytest.mark.parametrize("closed", [">&-", "2>&-", "<&-"])
def test_a_closed_stream_is_done_without(closed: str, home: Path, tmp_path: Path):
    words = ["sh", "-c", f'exec "$@" {closed}', "sh", *COMMAND, "run", str(home / "plan.toml"), "--out", str(tmp_path)]
    assert os.spawnvpe(os.P_WAIT, "sh", words, cached(home)) == 0


@pytest.mark.parametrize("most_bytes", [200, 20_000])
def test_a_full_disk_ends_in_one_line_without_a_page_or_a_half_file(most_bytes: int, home: Path, tmp_path: Path):
    resource = pytest.importorskip("resource")

    def fill() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (most_bytes, most_bytes))

    for _ in range(2):
        done = run("run", home / "plan.toml", "--out", tmp_path / "out", env=cached(home), preexec_fn=fill)
        assert (done.returncode, done.stderr.count("\n")) == (2, 1), done.stderr
        assert "cannot be written: File too large" in done.stderr
        assert not list((tmp_path / "out").rglob("*.part"))
        assert not (tmp_path / "out" / "report.html").exists()
    if most_bytes > 10_000:
        assert numbers(tmp_path / "out" / "results.csv").equals(numbers(home / "plain" / "results.csv"))


def test_numbas_order_not_to_compile_is_set_aside_with_a_word(home: Path, tmp_path: Path):
    env = cached(home, NUMBA_DISABLE_JIT="1")
    done = run("run", home / "plan.toml", "--out", tmp_path / "out", env=env)
    assert done.returncode == 0
    assert done.stderr == ("codend: NUMBA_DISABLE_JIT is set aside: without compiled kernels a net would take hours\n")
    asked = run("doctor", env=env)
    assert asked.returncode == 0
    assert "NUMBA_DISABLE_JIT" in asked.stdout


def test_the_end_of_a_file_is_not_taken_for_ctrl_c(home: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    def end(*_: object) -> None:
        raise EOFError

    monkeypatch.setattr("codend.studies.study.solve", end)
    result = codend_cli("run", home / "plan.toml", "--out", tmp_path)
    assert isinstance(result.exception, RuntimeError)
    assert "interrupted" not in result.stderr


def test_doctor_makes_every_other_check_when_one_fails(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("codend.cli.doctor._plots", lambda: 1 // 0)
    result = codend_cli("doctor")
    assert result.exit_code == 1
    assert "FAILS: ZeroDivisionError" in result.stdout
    assert "kernel cache" in result.stdout


def test_too_little_memory_is_one_line(home: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    def exhaust(*_: object) -> None:
        raise MemoryError

    monkeypatch.setattr("codend.equilibrium.fidelity.choose", exhaust)
    assert_refused(codend_cli("run", home / "plan.toml", "--out", tmp_path), "too little memory", status=1)
