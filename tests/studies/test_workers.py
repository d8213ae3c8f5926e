"""Jobs shared out over processes: every one once, by this process too, and none left running."""

from multiprocessing import active_children

import pytest

from codend.studies import workers
from codend.studies.workers import done_by_workers


def squared(number: int) -> int:
    return number * number


@pytest.mark.parametrize("waited_for_s", [0.0, 600.0])
@pytest.mark.parametrize("count", [0, 1, 25])
def test_every_job_is_done_once_whether_workers_are_ready_or_not(count, waited_for_s, monkeypatch):
    monkeypatch.setattr(workers, "WAITED_FOR_S", waited_for_s)
    found = list(done_by_workers(squared, iter(range(count)), 2))
    assert sorted(found) == [(number, number * number) for number in range(count)]
    assert not active_children()


def test_workers_end_when_nobody_asks_for_more(monkeypatch):
    monkeypatch.setattr(workers, "WAITED_FOR_S", 600.0)
    jobs = done_by_workers(squared, range(1000), 2)
    next(jobs)
    assert len(active_children()) == 1
    jobs.close()
    assert not active_children()
