"""Jobs shared out over processes of this machine, or over a Dask cluster; no core has two of them to serve."""

import ctypes
import gc
import os
import signal
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from contextlib import contextmanager
from itertools import islice
from multiprocessing import active_children, connection, get_context, parent_process
from multiprocessing.synchronize import Semaphore
from threading import Thread, active_count, current_thread, main_thread
from typing import Any, Final, TypeVar

from threadpoolctl import threadpool_limits

from codend.errors import OPTIONS, InputError

J = TypeVar("J")
R = TypeVar("R")

THREADS: Final = ("NUMBA_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
"""Variables that libraries take the number of their threads from, as they are loaded."""
WAITING: Final = 3
"""Jobs handed out for each worker at a time, so that none waits for the next and millions are not made ahead."""

WAITED_FOR_S = 0.0
"""How long this process waits for what others do first before it takes a job itself; tests do, to have them at work."""
_SIGNAL_AT_END_OF_PARENT: Final = 1
"""PR_SET_PDEATHSIG of Linux's prctl."""


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
    """Jobs done by this process and by others beside it; at the end it takes back what none of them has begun."""
    before, copied = set(active_children()), _can_be_copied()
    context = get_context("fork" if copied else "spawn")
    left, handed = iter(jobs), dict[Future[tuple[R, ...]], tuple[int, J]]()
    unclaimed = [context.Semaphore() for _ in range(WAITING * (workers - 1))]
    places = set(range(len(unclaimed)))
    with one_thread_each(), ProcessPoolExecutor(workers - 1, context, _begin, (unclaimed, copied)) as pool:

        def hand_out() -> None:
            for place, job in zip(sorted(places), left, strict=False):
                places.remove(place)
                handed[pool.submit(_if_unclaimed, function, job, place)] = place, job

        try:
            hand_out()
            wait(handed, WAITED_FOR_S, FIRST_COMPLETED)
            while True:
                done = [future for future in handed if future.done()]
                for future in done:
                    place, job = handed.pop(future)
                    found = future.result()
                    unclaimed[place].release()
                    places.add(place)
                    for result in found:
                        yield job, result
                hand_out()
                if done:
                    continue
                own = list(islice(left, 1)) or _taken_back(handed, unclaimed)
                for job in own:
                    yield job, function(job)
                if not own and not handed:
                    return
                if not own:
                    wait(handed, return_when=FIRST_COMPLETED)
        finally:  # what workers still do is of no use to anyone; asked to end, one may wait for a lock of one that did
            for future in handed:
                future.cancel()
            for worker in set(active_children()) - before:
                worker.kill()


def _can_be_copied() -> bool:
    """Whether workers may be copies of this process, which are at work at once, where new ones import for seconds.

    Only on Linux do all libraries bear it, and only where no other thread of Python can leave a lock closed behind.
    """
    return sys.platform == "linux" and active_count() == 1 and current_thread() is main_thread()


_unclaimed: list[Semaphore] = []
"""In a worker: for every place of a job handed out, whether nobody has begun it yet."""


def _begin(unclaimed: Sequence[Semaphore], copied: bool) -> None:
    """Make ready a worker that has just begun."""
    end_with_parent()
    if copied:
        # at once, also amid compiled code: the lock of the folder, which it was copied with, is free only then
        ctypes.CDLL(None).prctl(_SIGNAL_AT_END_OF_PARENT, int(signal.SIGKILL))
        gc.freeze()  # what it was copied with stays
    _unclaimed[:] = unclaimed


def _if_unclaimed(function: Callable[[J], R], job: J, place: int) -> tuple[R, ...]:
    """Do a job that nobody has begun; what comes of it, or nothing."""
    return (function(job),) if _unclaimed[place].acquire(block=False) else ()


def _taken_back(handed: dict[Future[Any], tuple[int, J]], unclaimed: Sequence[Semaphore]) -> list[J]:
    """The last job handed out that nobody has begun, taken from what is handed; none where all are begun."""
    for future, (place, job) in reversed(handed.items()):
        if unclaimed[place].acquire(block=False):
            del handed[future]
            return [job]
    return []


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
    """Have this process and those started in the block compute in one thread each.

    There are as many processes as cores, of which this is one.
    """
    before = {name: os.environ.get(name) for name in THREADS}
    os.environ.update(dict.fromkeys(THREADS, "1"))
    try:
        with threadpool_limits(1):
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
