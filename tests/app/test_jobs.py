"""Jobs: shared between visitors, cancelled when unused, repeated after a lost worker."""

import asyncio
from time import sleep
from types import SimpleNamespace

import pytest
from visitor import SHORT, NoPool, waited

from app.service import metrics, worker
from app.service import pool as pools
from app.service.caller import Lost
from app.service.jobs import Jobs
from app.service.packing import Frames
from app.service.pool import HEAVY, LATER, SCREEN
from app.service.requests import Requests
from app.service.worker import Part

CALL = abs, -3


class Visitor:
    """A stand-in for a session: what is scheduled runs at once."""

    def __init__(self, jobs):
        self.jobs = jobs

    def later(self, call):
        call()


@pytest.fixture
def jobs():
    return Jobs(NoPool())


@pytest.fixture
def tasks(jobs):
    return jobs.pool.tasks


@pytest.fixture
def seen():
    return []


def requests(jobs, seen=None):
    return Requests(Visitor(jobs), lambda call, result: seen is not None and seen.append(result))


def test_equal_requests_of_visitors_are_computed_once(jobs, tasks, seen):
    first, second, third = (requests(jobs, seen) for _ in range(3))
    for each in (first, second):
        each.add([CALL])
    assert len(tasks) == 1 and first.part == 0.0
    tasks[0].set_result(3)
    assert seen == [3, 3] and first.part is None
    third.add([CALL])
    assert seen == [3, 3, 3] and len(tasks) == 1


def test_a_shared_call_is_cancelled_when_its_last_visitor_leaves(jobs, tasks):
    first, second = requests(jobs), requests(jobs)
    for each in (first, second):
        each.add([CALL])
    first.cancel()
    assert not tasks[0].cancelled()
    second.cancel()
    assert tasks[0].cancelled()


def test_a_cancelled_request_receives_no_results(jobs, tasks, seen):
    one, other = requests(jobs, seen), requests(jobs, seen)
    for each in (one, other):
        each.add([CALL])
    one.cancel()
    tasks[0].set_result(3)
    assert seen == [3]


def test_a_part_lost_with_its_worker_is_repeated_and_finally_reported(jobs, tasks, seen):
    requests(jobs, seen).add([CALL])
    for attempt in range(3):
        assert len(tasks) == attempt + 1 and not seen
        tasks[attempt].set_exception(Lost("crash", "gone"))
    assert isinstance(seen[0], Lost)


def test_the_result_is_the_sum_of_the_parts_and_each_call_has_the_state_of_the_one_before(jobs, tasks, seen):
    job = jobs.start(CALL, lambda job: seen.append(list(job.parts)), owner="me")
    for k in range(3):
        tasks[k].set_result(Part(state=k, made=10**k))
    tasks[3].set_result(1000)
    assert [task.call for task in tasks] == [CALL, (*CALL, 0), (*CALL, 1), (*CALL, 2)]
    assert seen == [[1], [1, 10], [1, 10, 100], [1, 10, 100, 1000]] and job.result == 1111


def test_a_job_with_expensive_parts_ranks_behind_others_until_they_are_cheap_again(jobs, tasks):
    jobs.start(CALL, lambda job: None, owner="me", rank=SCREEN)
    for k, heavy in enumerate((False, True, True, False)):
        tasks[k].set_result(Part(k, heavy=heavy))
    assert [task.rank for task in tasks] == [SCREEN, SCREEN, HEAVY, HEAVY, SCREEN]


def test_a_large_or_private_result_displaces_nothing_from_the_cache(jobs, tasks):
    mine = requests(jobs)
    mine.add([CALL])
    tasks[0].set_result(3)
    mine.add([("a large file",)])
    tasks[1].set_result(bytes(30_000_000))
    mine.add_one(("a file of mine",), lambda result: None, private=True)
    tasks[2].set_result(b"1")
    assert list(jobs.results) == [CALL]


def test_metrics_count_parts_of_runs_only(jobs, tasks):
    before = metrics.counted("slices")
    mine = requests(jobs)
    mine.add([CALL, (worker.compute, SHORT)])
    tasks[0].set_result(3)
    tasks[1].set_result(Frames(frames=7, evaluations=90))
    assert metrics.counted("slices") == before + 1


def test_equal_private_calls_are_not_shared(jobs, tasks):
    for each in (requests(jobs), requests(jobs)):
        each.add_one(CALL, lambda result: None, private=True)
    assert len(tasks) == 2


def test_a_cancelled_sweep_leaves_no_job(jobs, tasks):
    mine = requests(jobs)
    for k in range(1000):
        mine.ask((abs, -k), lambda result: None)
    mine.cancel()
    assert all(task.cancelled() for task in tasks) and not jobs._shared


def test_a_failure_of_a_busy_machine_is_not_kept_for_others(jobs, tasks, seen):
    for failure in (Lost("hang", "no equilibrium within 10 s"), ValueError("no equilibrium")):
        for _ in range(2):
            requests(jobs).add_one(CALL, seen.append)
            if not tasks[-1].done():
                tasks[-1].set_result(failure)
    assert len(tasks) == 3  # the second failure is that of the scene


def test_a_background_job_moves_up_when_a_visitor_needs_it_on_the_screen(jobs, tasks, seen):
    requests(jobs, seen).add([CALL])
    assert tasks[0].rank == LATER
    requests(jobs, seen).add_one(CALL, seen.append, rank=SCREEN)
    assert tasks[0].cancelled() and tasks[1].rank == SCREEN
    tasks[1].set_result(3)
    assert seen == [3, 3]


def test_a_coroutine_awaits_parts_and_result_of_a_job(jobs, tasks):
    async def collect():
        async def made():
            return [part async for part in jobs.parts(*CALL, owner="me")]

        waiting = asyncio.create_task(made())
        for result in (Part(1, 1), Part(2, 10), 100):
            await asyncio.sleep(0)
            tasks[-1].set_result(result)
            await asyncio.sleep(0)
        return await waiting, await jobs.result(*CALL, owner="me")

    assert waited(collect()) == ([1, 10, 100], 111)


def test_cancelling_a_coroutine_cancels_its_job(jobs, tasks):
    async def leave():
        waiting = asyncio.create_task(jobs.result(*CALL, owner="me"))
        await asyncio.sleep(0)
        assert len(tasks) == 1
        waiting.cancel()
        await asyncio.wait([waiting])

    waited(leave())
    assert tasks[0].cancelled() and not jobs._shared


def test_a_coroutine_receives_the_exception_of_its_job(jobs, tasks):
    async def fail():
        waiting = asyncio.create_task(jobs.result(*CALL, owner="me"))
        await asyncio.sleep(0)
        tasks[0].set_result(ValueError("no curve"))
        return await waiting

    with pytest.raises(ValueError, match="no curve"):
        waited(fail())


def items():
    """A generator as a worker runs it."""
    yield from (1, 2)
    return "end"


def test_items_of_a_generator_are_the_parts_of_its_job(jobs, tasks):
    heard = []
    job = jobs.start((items,), lambda job: heard.append(len(job.parts)), owner="me", streams=True)
    for part in (1, 2):
        tasks[0].hear(part)
    tasks[0].set_result("end")
    assert (job.parts, job.result, heard) == ([1, 2], "end", [1, 2, 2])


@pytest.mark.slow
@pytest.mark.parametrize(("call", "stops", "replaced"), [("items", 60.0, 0), ("no item", 0.5, 1), ("plain", 0.5, 1)])
def test_a_cancelled_call_stops_at_its_next_item_and_costs_its_worker_only_if_none_comes(
    pool, monkeypatch, call, stops, replaced
):
    from helpers import until

    monkeypatch.setattr(pools, "STOPS", stops)
    jobs, lost = Jobs(pool), pool.replaced
    made = {"items": (endless, 0.02), "no item": (endless, 600.0), "plain": (sleep, 600.0)}[call]
    job = jobs.start(made, print, owner="me", streams=call != "plain", seconds=600.0)
    until(lambda: job.task.running())
    task = job.task
    jobs.leave(job, print)
    until(lambda: task.done() and pool.ready == pool.size)
    assert pool.replaced == lost + replaced


def endless(pause):
    """A generator that never ends, with so many s between its items."""
    while True:
        yield SimpleNamespace()
        sleep(pause)
