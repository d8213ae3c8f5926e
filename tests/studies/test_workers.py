"""Jobs shared out over processes: every one once, by this process too, and none left running."""

import os
import signal
import subprocess
import sys
from contextlib import contextmanager
from multiprocessing import active_children
from pathlib import Path
from threading import Event, Thread
from time import monotonic, sleep

import numpy as np
import pytest
from threadpoolctl import threadpool_info

from codend.studies import workers
from codend.studies.workers import done_by_workers
from tests import ROOT

told_here: list[int] = []
"""Filled by a test in this process: a copy of it has that, a new one has not."""


@contextmanager
def another_thread():
    """A thread that may hold any lock: copies of this process would not be safe."""
    ended = Event()
    thread = Thread(target=ended.wait)
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join()


def squared(number: int) -> int:
    return number * number


def asleep(seconds: float) -> tuple[int, int]:
    sleep(seconds)
    return os.getpid(), len(told_here)


def threads_of_libraries(_: int) -> tuple[int, int]:
    np.linalg.inv(np.eye(300))
    return os.getpid(), max(library["num_threads"] for library in threadpool_info())


@pytest.mark.parametrize("beside", [False, True])
@pytest.mark.parametrize("waited_for_s", [0.0, 600.0])
@pytest.mark.parametrize("count", [0, 1, 25])
def test_every_job_is_done_once_whether_workers_are_ready_or_not(beside, waited_for_s, count, monkeypatch):
    monkeypatch.setattr(workers, "WAITED_FOR_S", waited_for_s)
    jobs = iter(range(count))
    if beside:
        with another_thread():
            found = list(done_by_workers(squared, jobs, 3))
    else:
        found = list(done_by_workers(squared, jobs, 3))
    assert sorted(found) == [(number, number * number) for number in range(count)]
    assert not active_children()


def test_workers_end_whatever_they_wait_for():
    for _ in range(40):  # as often as it took where they were asked to, and one held the lock another waited for
        assert len(list(done_by_workers(squared, range(25), 3))) == 25
        assert not active_children()


def test_workers_end_when_nobody_asks_for_more(monkeypatch):
    monkeypatch.setattr(workers, "WAITED_FOR_S", 600.0)
    jobs = done_by_workers(squared, range(1000), 2)
    next(jobs)
    assert len(active_children()) == 1
    jobs.close()
    assert not active_children()


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere no process is copied")
def test_a_process_is_copied_where_no_other_thread_can_have_closed_a_lock(monkeypatch):
    monkeypatch.setattr(workers, "WAITED_FOR_S", 600.0)
    monkeypatch.setattr(sys.modules[__name__], "told_here", [1])
    with another_thread():
        new = {found for _, found in done_by_workers(asleep, [0.0] * 3, 2)}
    copied = {found for _, found in done_by_workers(asleep, [0.0] * 3, 2)}
    assert {told for process, told in new if process != os.getpid()} == {0}
    if workers._can_be_copied():  # the runner of the tests has no thread beside this one
        assert {told for process, told in copied if process != os.getpid()} == {1}


def test_what_no_worker_has_begun_is_taken_back():
    jobs = [1.0, 0.1, 0.1, 0.1]  # the first goes to the worker, as do two of the others
    done = list(done_by_workers(asleep, jobs, 2))
    own = [job for job, (process, _) in done if process == os.getpid()]
    assert len(done) == len(jobs)
    assert own.count(0.1) == 3 or 1.0 in own


@pytest.mark.parametrize("beside", [False, True])
def test_every_process_computes_in_one_thread(beside, monkeypatch):
    monkeypatch.setattr(workers, "WAITED_FOR_S", 600.0)
    before = [library["num_threads"] for library in threadpool_info()]
    if beside:
        with another_thread():
            done = list(done_by_workers(threads_of_libraries, range(6), 2))
    else:
        done = list(done_by_workers(threads_of_libraries, range(6), 2))
    assert len({process for _, (process, _) in done}) == 2
    assert {threads for _, (_, threads) in done} == {1}
    assert [library["num_threads"] for library in threadpool_info()] == before


WITH_A_WORKER_AT_WORK = """
import ctypes, os, sys
from pathlib import Path
from codend.io.own_folder import owned
from codend.studies.workers import done_by_workers

def work(job):
    if os.getpid() == parent:
        print("begun", flush=True)
        return ctypes.CDLL(None).sleep(600)
    ctypes.PyDLL(None).sleep(600)  # as compiled code does, without letting another thread of Python run

parent = os.getpid()
with owned(Path(sys.argv[1])):
    list(done_by_workers(work, range(2), 2))
"""


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere no process is copied")
def test_a_folder_is_free_as_soon_as_its_process_is_killed_whatever_workers_do(tmp_path):
    command = [sys.executable, "-c", WITH_A_WORKER_AT_WORK, str(tmp_path / "out")]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, cwd=ROOT)
    assert process.stdout is not None
    assert process.stdout.readline() == b"begun\n"
    children = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text(encoding="ascii").split()
    assert children
    sleep(0.2)  # for the worker to be amid its job
    process.send_signal(signal.SIGKILL)
    process.wait()
    until = monotonic() + 60.0
    while any(state(child) != "Z" for child in children):
        assert monotonic() < until
        sleep(0.01)


def state(process: str) -> str:
    """One letter; Z of one that has ended."""
    try:
        return Path(f"/proc/{process}/stat").read_text(encoding="ascii").rpartition(")")[2].split()[0]
    except OSError:
        return "Z"
