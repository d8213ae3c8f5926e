"""Jobs shared out over processes of this machine, or over a Dask cluster; no core has two of them to serve."""

import os
import signal
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from contextlib import contextmanager
from itertools import islice
from multiprocessing import active_children, connection, get_context, parent_process
from threading import Thread
from typing import Any, Final, TypeVar

from codend.errors import OPTIONS, InputError

J = TypeVar("J")
R = TypeVar("R")

THREADS: Final = ("NUMBA_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
"""Variables that libraries take the number of their threads from, as they are loaded."""
WAITING: Final = 3
"""Jobs handed out for each worker at a time, so that none waits for the next and millions are not made ahead."""

WAITED_FOR_S = 0.0
"""How long this process waits for the others before it takes a job itself; tests do, to have them all at work."""


def cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def done_by_workers(
    function: Callable[[J], R], jobs: Iterable[J], workers: int, scheduler: str | None = None
) -> Iterator[tuple[J, R]]:
    """Jobs and what a function makes of them, as they are done.

    Args:
        function: of one job; it and the jobs can be pickled.
        jobs: what to do, made as they are needed.
        workers: processes, this one among them; none or 1: this one alone.
        scheduler: address of a Dask scheduler, whose workers do the jobs instead.

    Raises:
        InputError: Dask is not installed, or no scheduler answers there.
        BrokenProcessPool: a process was killed, or found too little memory.
    """
    if scheduler is not None:
        yield from _on_a_cluster(function, jobs, scheduler)
    elif workers <= 1:
        for job in jobs:
            yield job, function(job)
    else:
        yield from _in_processes(function, jobs, workers)


def _in_processes(function: Callable[[J], R], jobs: Iterable[J], workers: int) -> Iterator[tuple[J, R]]:
    """Jobs done by this process and, once they are ready, which takes a second, by others beside it."""
    before = set(active_children())
    left, handed, room = iter(jobs), dict[Future[R], J](), 0
    with one_thread_each(), ProcessPoolExecutor(workers - 1, get_context("spawn"), end_with_parent) as pool:
        starting = [pool.submit(_ready, function) for _ in range(workers - 1)]
        wait(starting, timeout=WAITED_FOR_S)
        try:
            while True:
                for started in [started for started in starting if started.done()]:
                    starting.remove(started)
                    room += WAITING * started.result()
                done = [future for future in handed if future.done()]
                for job in islice(left, room + len(done)):
                    handed[pool.submit(function, job)] = job
                room = 0
                for future in done:
                    yield handed.pop(future), future.result()
                if done:
                    continue
                own = list(islice(left, 1))
                for job in own:
                    yield job, function(job)
                if not own and not handed:
                    return
                if not own:
                    wait(handed, return_when=FIRST_COMPLETED)
        finally:  # what workers still do is of no use to anyone
            for future in handed:
                future.cancel()
            for worker in set(active_children()) - before:
                worker.terminate()


def _ready(function: Callable[[J], R]) -> int:
    """Told by a worker that has imported what its jobs need."""
    return 1


def _on_a_cluster(function: Callable[[J], R], jobs: Iterable[J], address: str) -> Iterator[tuple[J, R]]:
    try:
        from distributed import Client, as_completed
    except ImportError:
        allowed = "with Dask installed: pip install 'codend[dask]'"
        raise InputError(OPTIONS, "--scheduler", address, allowed) from None
    try:
        client: Any = Client(address, timeout=10)
    except (OSError, ValueError) as error:
        allowed = "the address of a Dask scheduler, such as tcp://127.0.0.1:8786"
        raise InputError(OPTIONS, "--scheduler", address, allowed, f"does not answer: {error}") from None
    with client:
        left = iter(jobs)
        ahead = WAITING * max(len(client.scheduler_info(n_workers=-1)["workers"]), 1)
        handed = {client.submit(function, job, pure=False): job for job in islice(left, ahead)}
        waiting = as_completed(list(handed))
        for future in waiting:
            for job in islice(left, 1):
                following = client.submit(function, job, pure=False)
                handed[following] = job
                waiting.add(following)
            yield handed.pop(future), future.result()


@contextmanager
def one_thread_each() -> Iterator[None]:
    """Have processes started in the block compute in one thread each, and libraries loaded in it do so here.

    There are as many processes as cores, of which this is one.
    """
    before = {name: os.environ.get(name) for name in THREADS}
    os.environ.update(dict.fromkeys(THREADS, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


def end_with_parent() -> None:
    """Have this worker end when the process that started it does, however that ends, and without a word."""
    parent = parent_process()
    assert parent is not None

    def watch() -> None:
        connection.wait([parent.sentinel])
        os._exit(1)

    Thread(target=watch, daemon=True).start()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: os._exit(1))
