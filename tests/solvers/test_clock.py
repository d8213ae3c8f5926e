"""The time of a solve is that of the solve alone."""

from threading import Thread
from time import perf_counter

import numba

from codend.solvers.clock import Clock


def slow_to_compile():
    return numba.njit(lambda x: x @ x + x.sum())


def test_time_spent_on_compiling_is_left_out():
    import numpy as np

    kernel, began = slow_to_compile(), perf_counter()
    with Clock() as clock:
        kernel(np.ones(3))
        told = clock.ms
    assert told < 0.5e3 * (perf_counter() - began)


def test_what_another_thread_compiles_is_no_business_of_this_one():
    import numpy as np

    kernel, took = slow_to_compile(), []

    def compiled() -> None:
        began = perf_counter()
        kernel(np.ones(3))
        took.append(perf_counter() - began)

    other = Thread(target=compiled)
    with Clock() as clock:
        other.start()
        other.join()
        told = clock.ms
    assert told >= 1e3 * took[0]
