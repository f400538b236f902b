"""Jobs: shared between visitors, cancelled when unused, repeated after a lost worker."""

import asyncio
from time import sleep
from types import SimpleNamespace

import pytest
from visitor import SHORT, NoPool, waited

from app.service import metrics, worker
from app.service import pool as pools
from app.service.caller import Lost
from app.service.fair_queue import FairQueue
from app.service.job import HEAVY, LATER, SCREEN
from app.service.jobs import Jobs
from app.service.packing import Frames
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
def given(jobs):
    """The jobs that the pool has been given, as often as it was."""
    return jobs.pool.jobs


@pytest.fixture
def answer(jobs):
    """Let the call of the job that was given last, or of another, return this."""
    return lambda made, k=-1: jobs.pool.answer(jobs.pool.jobs[k], made)


@pytest.fixture
def seen():
    return []


def requests(jobs, seen=None):
    return Requests(Visitor(jobs), lambda call, result: seen is not None and seen.append(result))


def test_equal_requests_of_visitors_are_computed_once(jobs, given, answer, seen):
    first, second, third = (requests(jobs, seen) for _ in range(3))
    for each in (first, second):
        each.add([CALL])
    assert len(given) == 1 and first.part == 0.0
    answer(3)
    assert seen == [3, 3] and first.part is None
    third.add([CALL])
    assert seen == [3, 3, 3] and len(given) == 1


def test_a_visitor_whose_part_fails_keeps_no_result_from_others(jobs, given, answer, seen, caplog):
    def fail(job):
        raise ZeroDivisionError("a mistake")

    jobs.start(CALL, fail, owner="one")
    requests(jobs, seen).add([CALL])
    answer(Part(0, 1))
    answer(2)
    assert seen == [3] and len(given) == 2 and "a mistake" in caplog.text


def test_who_leaves_while_a_result_comes_is_told_nothing(jobs, given, answer, seen):
    mine = requests(jobs, seen)
    mine.add([CALL])
    (told,) = given[0].listeners
    mine.cancel()
    told(given[0])  # the thread of the worker had this listener already
    assert given[0].cancelled() and seen == []


def test_a_shared_call_is_cancelled_when_its_last_visitor_leaves(jobs, given, answer):
    first, second = requests(jobs), requests(jobs)
    for each in (first, second):
        each.add([CALL])
    first.cancel()
    assert not given[0].cancelled()
    second.cancel()
    assert given[0].cancelled()


def test_a_cancelled_request_receives_no_results(jobs, given, answer, seen):
    one, other = requests(jobs, seen), requests(jobs, seen)
    for each in (one, other):
        each.add([CALL])
    one.cancel()
    answer(3, 0)
    assert seen == [3]


def test_a_part_lost_with_its_worker_is_repeated_and_finally_reported(jobs, given, answer, seen):
    requests(jobs, seen).add([CALL])
    for attempt in range(3):
        assert len(given) == attempt + 1 and not seen
        answer(Lost("crash", "gone"))
    assert isinstance(seen[0], Lost)


def test_the_result_is_the_sum_of_the_parts_and_each_call_has_the_state_of_the_one_before(jobs, given, answer, seen):
    job = jobs.start(CALL, lambda job: seen.append(list(job.parts)), owner="me")
    states = [job.state]
    for k in range(3):
        answer(Part(state=k, made=10**k))
        states.append(job.state)
    answer(1000)
    assert given == [job] * 4 and states == [(), (0,), (1,), (2,)]
    assert seen == [[1], [1, 10], [1, 10, 100], [1, 10, 100, 1000]] and job.result() == 1111


def test_a_job_with_expensive_parts_ranks_behind_others_until_they_are_cheap_again(jobs, given, answer):
    job, queue, ranks = jobs.start(CALL, lambda job: None, owner="me", rank=SCREEN), FairQueue(), []
    for heavy in (False, True, True, False):
        answer(Part(0, heavy=heavy))
        queue.add(job)
        ranks.append(queue.take().queued)
    assert ranks == [SCREEN, HEAVY, HEAVY, SCREEN]


def test_a_large_or_private_result_displaces_nothing_from_the_cache(jobs, given, answer):
    mine = requests(jobs)
    mine.add([CALL])
    answer(3, 0)
    mine.add([("a large file",)])
    answer(bytes(30_000_000))
    mine.add_one(("a file of mine",), lambda result: None, private=True)
    answer(b"1")
    assert list(jobs.results) == [CALL]


def test_metrics_count_parts_of_runs_only(jobs, given, answer):
    before = metrics.counted("slices")
    mine = requests(jobs)
    mine.add([CALL, (worker.compute, SHORT)])
    answer(3, 0)
    answer(Frames(frames=7, evaluations=90))
    assert metrics.counted("slices") == before + 1


def test_equal_private_calls_are_not_shared(jobs, given, answer):
    for each in (requests(jobs), requests(jobs)):
        each.add_one(CALL, lambda result: None, private=True)
    assert len(given) == 2


def test_a_cancelled_sweep_leaves_no_job(jobs, given, answer):
    mine = requests(jobs)
    for k in range(1000):
        mine.ask((abs, -k), lambda result: None)
    mine.cancel()
    assert all(job.cancelled() for job in given) and not jobs._shared


def test_a_failure_of_a_busy_machine_is_not_kept_for_others(jobs, given, answer, seen):
    for failure in (Lost("hang", "no equilibrium within 10 s"), ValueError("no equilibrium")):
        for _ in range(2):
            requests(jobs).add_one(CALL, seen.append)
            if not given[-1].done():
                answer(failure)
    assert len(given) == 3  # the second failure is that of the scene


def test_a_background_job_moves_up_when_a_visitor_needs_it_on_the_screen(jobs, given, answer, seen):
    requests(jobs, seen).add([CALL])
    assert given[0].rank == LATER
    requests(jobs, seen).add_one(CALL, seen.append, rank=SCREEN)
    assert len(given) == 1 and given[0].rank == SCREEN
    answer(3)
    assert seen == [3, 3]


def test_a_coroutine_awaits_parts_and_result_of_a_job(jobs, given, answer):
    async def collect():
        async def made():
            return [part async for part in jobs.parts(*CALL, owner="me")]

        waiting = asyncio.create_task(made())
        for result in (Part(1, 1), Part(2, 10), 100):
            await asyncio.sleep(0)
            answer(result)
            await asyncio.sleep(0)
        return await waiting, await jobs.result(*CALL, owner="me")

    assert waited(collect()) == ([1, 10, 100], 111)


def test_cancelling_a_coroutine_cancels_its_job(jobs, given, answer):
    async def leave():
        waiting = asyncio.create_task(jobs.result(*CALL, owner="me"))
        await asyncio.sleep(0)
        assert len(given) == 1
        waiting.cancel()
        await asyncio.wait([waiting])

    waited(leave())
    assert given[0].cancelled() and not jobs._shared


def test_a_coroutine_receives_the_exception_of_its_job(jobs, given, answer):
    async def fail():
        waiting = asyncio.create_task(jobs.result(*CALL, owner="me"))
        await asyncio.sleep(0)
        answer(ValueError("no curve"))
        return await waiting

    with pytest.raises(ValueError, match="no curve"):
        waited(fail())


def items():
    """A generator as a worker runs it."""
    yield from (1, 2)
    return "end"


def test_items_of_a_generator_are_the_parts_of_its_job(jobs, given, answer):
    heard = []
    job = jobs.start((items,), lambda job: heard.append(len(job.parts)), owner="me", streams=True)
    for part in (1, 2):
        job.heard(part)
    answer("end")
    assert (job.parts, job.result(), heard) == ([1, 2], "end", [1, 2, 2])


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
    until(lambda: job.slot)
    jobs.leave(job, print)
    until(lambda: job.slot is None and pool.ready == pool.size)
    assert job.cancelled() and pool.replaced == lost + replaced


def endless(pause):
    """A generator that never ends, with so many s between its items."""
    while True:
        yield SimpleNamespace()
        sleep(pause)
