"""What visitors share: worker processes that are replaced one by one, and the shelf of finished runs."""

import os
import time

import pytest

from app.service import worker
from app.service.finished import Finished, Shelf
from app.service.pool import Pool
from solver import Scene

PATIENCE = 60  # s; a limit against hanging, not a claim about speed


def test_a_worker_stuck_in_an_abandoned_slice_is_replaced_when_work_waits(monkeypatch):
    monkeypatch.setattr("app.service.pool.GRACE", 0.05)
    workers = Pool(size=1)
    stuck = workers.submit(time.sleep, 10 * PATIENCE)
    while not stuck.running():
        os.sched_yield()
    waiting = workers.submit(os.getpid)
    workers.abandon(stuck)
    assert waiting.result(PATIENCE) > 0
    assert workers.replaced == 1
    workers.close()


def test_the_shelf_keeps_what_was_used_last_within_its_bytes():
    shelf = Shelf(capacity=250)
    for E in (20.0, 30.0, 40.0):
        shelf.put(Scene(E=E), Finished((bytes(60), bytes(40)), 1, 1, 0.0))
        shelf.get(Scene(E=20.0))
    assert len(shelf) == 2 and shelf.size == 200
    assert shelf.get(Scene(E=20.0)) and shelf.get(Scene(E=40.0)) and shelf.get(Scene(E=30.0)) is None
    shelf.put(Scene(E=50.0), Finished((bytes(251),), 1, 1, 0.0))
    assert shelf.get(Scene(E=50.0)) is None


def test_plans_measured_by_one_worker_are_shared():
    workers = Pool(size=2)
    while workers.wisdom is None:
        workers.submit(worker.ready).result(PATIENCE)
    assert any(b"fftw" in part for part in workers.wisdom)
    worker.learn(workers.wisdom)  # as every other worker does
    workers.close()


def test_closing_the_pool_leaves_no_process():
    workers = Pool(size=1)
    workers.submit(worker.ready).result(PATIENCE)
    (process,) = workers.processes()
    workers.close()
    with pytest.raises(ProcessLookupError):
        os.kill(process, 0)


def test_work_in_the_background_leaves_a_worker_for_what_is_on_a_screen():
    workers = Pool(size=2)
    while workers.wisdom is None:  # until both are at work
        workers.submit(worker.ready).result(PATIENCE)
    slow = [workers.submit(time.sleep, 10 * PATIENCE, background=True) for _ in range(3)]
    assert workers.submit(os.getpid).result(PATIENCE) > 0
    assert sum(task.running() for task in slow) == 1
    workers.close()


def test_work_in_the_background_is_done_by_a_single_worker_too():
    workers = Pool(size=1)
    assert workers.submit(os.getpid, background=True).result(PATIENCE) > 0
    workers.close()
