"""The pool of worker processes and the cache of finished runs, which all visitors share."""

import os
import signal
import time

import pytest
from helpers import until
from visitor import asked

from app.service import caller, worker
from app.service import pool as pools
from app.service.cache import Cache, size_of
from app.service.fair_queue import AGEING, FairQueue
from app.service.job import EXACT, HEAVY, LATER, NOBODY, SCREEN, Job
from app.service.packing import Frames
from app.service.pool import Pool
from solver import Scene, skeleton_of

pytestmark = pytest.mark.slow  # nearly all start processes, and end them
PATIENCE = 300  # s; a limit against hanging, not a claim about speed


@pytest.fixture(scope="module")
def single():
    """A pool of one worker, for tests that leave it idle."""
    workers = Pool(size=1)
    yield workers
    workers.close()


def test_a_hanging_task_is_ended_with_its_worker():
    workers = Pool(size=1, patience=0.2)
    stuck = asked(workers, time.sleep, 10 * PATIENCE)
    waiting = asked(workers, os.getpid)
    assert stuck.exception(PATIENCE).kind == "hang" and "no answer within" in str(stuck.exception())
    assert waiting.result(PATIENCE) > 0
    assert workers.replaced == 1
    workers.close()


FORKED = pytest.mark.skipif(caller.START != "forkserver", reason="processes are not forked here")


@pytest.mark.parametrize("killed", [os.getpid, pytest.param(os.getppid, marks=[pytest.mark.thorough, FORKED])])
def test_an_idle_worker_is_replaced_at_once_when_it_or_the_fork_server_is_killed(killed):
    workers = Pool(size=1)
    first = asked(workers, os.getpid).result(PATIENCE)
    os.kill(asked(workers, killed).result(PATIENCE), signal.SIGKILL)
    until(lambda: workers.processes() not in ([], [first]) and workers.status == "ready")
    assert asked(workers, os.getpid).result(PATIENCE) == workers.processes()[0] != first
    workers.close()


def send(size):
    """Bytes enough to keep a worker sending."""
    return bytes(size)


@pytest.mark.thorough
def test_workers_killed_while_sending_or_warming_up_are_replaced():
    workers = Pool(size=2)
    asked(workers, worker.ready).result(PATIENCE)
    for size in (10**8, 0):  # the second time while the new ones warm up
        begun = [asked(workers, send, size, seconds=PATIENCE) for _ in range(2)]
        until(lambda begun=begun: not workers.in_flight or any(job.slot for job in begun))
        for process in workers.processes():
            os.kill(process, signal.SIGKILL)
        for job in begun:
            assert job.exception(PATIENCE) is None or job.exception().kind == "crash"
    both_at_work(workers)
    workers.close()


def both_at_work(workers):
    """Wait until two jobs are done by two processes."""
    until(lambda: len({job.result(PATIENCE) for job in [asked(workers, busy) for _ in range(2)]}) == 2)


def busy():
    time.sleep(0.02)  # so that the other job finds another worker
    return os.getpid()


def until_removed(file):
    until(lambda: not file.exists())


def broken():
    raise ZeroDivisionError("a mistake")


def test_an_exception_in_a_task_keeps_the_worker_and_is_logged(single, caplog):
    error = asked(single, broken).exception(PATIENCE)
    assert error.kind == "error" and 'raise ZeroDivisionError("a mistake")' in error.reason
    assert "ZeroDivisionError" in caplog.text and single.replaced == 0


@pytest.mark.thorough
def test_waiting_tasks_fail_if_no_worker_can_start(monkeypatch):
    monkeypatch.setattr("app.service.pool.PAUSES", (0.0,))
    for name in ("start", "start_up"):  # of the first worker, and of the others
        monkeypatch.setattr(worker, name, os._exit)  # found by name in the worker: it ends with that
    workers = Pool(size=2)
    waiting = asked(workers, os.getpid)
    assert "no worker process can be started" in str(waiting.exception(PATIENCE))
    assert not workers.alive()[0]
    assert workers.status == "failing" and asked(workers, os.getpid).exception(PATIENCE).kind == "closed"
    workers.close()


def test_owners_take_turns_in_the_queue():
    queue, jobs = FairQueue(), {}
    for owner, number in (("a", 1), ("a", 2), ("a", 3), ("b", 1), ("c", 1), ("b", 2)):
        jobs[owner, number] = Job((), owner)
        queue.add(jobs[owner, number])
    turns = [("a", 1), ("b", 1), ("c", 1), ("a", 2), ("b", 2), ("a", 3)]
    assert [queue.position(jobs[turn]) for turn in turns] == list(range(6))
    assert [queue.take() for _ in range(6)] == [jobs[turn] for turn in turns]
    assert queue.take() is None and queue.position(jobs["a", 1]) is None


def test_a_cancelled_task_takes_no_turn_and_counts_before_nobody():
    queue = FairQueue()
    old, new, one, two = Job((), "a"), Job((), "a"), Job((), "b"), Job((), "b")
    for job in (old, one, two, new):
        queue.add(job)
    queue.remove(old)
    assert [queue.position(job) for job in (new, one, two, old)] == [0, 1, 2, None]
    assert [queue.take() for _ in range(4)] == [new, one, two, None]


def test_many_cancelled_tasks_of_an_owner_leave_nothing_in_the_queue():
    queue = FairQueue()
    for _ in range(1000):
        job = Job((), "a", LATER)
        queue.add(job)
        queue.remove(job)
    assert list(queue) == [] and queue.take() is None


def test_a_slow_run_gets_a_turn_while_sliders_are_dragged_all_the_time(monkeypatch):
    now = [0.0]
    for module in ("fair_queue", "job"):
        monkeypatch.setattr(f"app.service.{module}.monotonic", lambda: now[0])
    queue = FairQueue()
    slow = Job((), "a", HEAVY)
    queue.add(slow)
    served = []
    while slow not in served and now[0] < 60.0:
        queue.add(Job((), "b", SCREEN))  # the queue never gets empty
        now[0] += 0.1
        served.append(queue.take())
    assert abs(now[0] - HEAVY * AGEING) < 0.5 and served.count(slow) == 1  # HEAVY is two ranks above SCREEN


def test_a_run_that_has_begun_waits_for_its_turn_only_once(monkeypatch):
    """Each of its parts waited anew; but it never goes before what is there already."""
    now = [0.0]
    for module in ("fair_queue", "job"):
        monkeypatch.setattr(f"app.service.{module}.monotonic", lambda: now[0])
    queue = FairQueue()
    now[0] = 1.0
    begun = Job((), "c", EXACT)
    now[0] = 10.0
    waiting = [Job((), owner, SCREEN) for owner in "ab"]
    for job in (*waiting, begun):
        queue.add(job)
    now[0] += 0.1
    later = Job((), "e", SCREEN)
    queue.add(later)
    assert [queue.take() for _ in range(4)] == [*waiting, begun, later]


def test_cache_keeps_the_most_recently_used_runs_within_its_capacity():
    one = size_of(Frames((bytes(60), bytes(40)), 1, 1, 0.0))
    run_cache = Cache(capacity=2.5 * one)
    for E in (20.0, 30.0, 40.0):
        run_cache.put(Scene(E=E), Frames((bytes(60), bytes(40)), 1, 1, 0.0))
        run_cache.get(Scene(E=20.0))
    assert len(run_cache) == 2 and run_cache.currsize == 2 * one
    assert run_cache.get(Scene(E=20.0)) and run_cache.get(Scene(E=40.0)) and run_cache.get(Scene(E=30.0)) is None
    run_cache.put(Scene(E=50.0), Frames((bytes(int(run_cache.maxsize)),), 1, 1, 0.0))
    assert run_cache.get(Scene(E=50.0)) is None


def test_size_of_a_run_in_the_cache_is_about_that_of_its_arrays():
    """To 30 %: of a Skeleton most are small arrays, whose records weigh as well."""
    skeleton = skeleton_of(Scene(nodes=256, width=625.0, u_x_max=12.0))
    ends = [end for end in (*skeleton.trace.jumps, *(branch.slip for branch in skeleton.branches)) if end]
    arrays = [branch.v for branch in skeleton.branches] + [part for end in ends for part in (end.v, end.phi, end.psi)]
    run = Frames((bytes(10_000),), 1, 1, 0.0, skeleton=skeleton)
    assert size_of(run) == pytest.approx(10_000 + sum(array.nbytes for array in arrays), rel=0.3)


@pytest.mark.thorough
def test_a_silent_pool_counts_as_dead_unless_a_worker_is_idle(monkeypatch):
    workers = Pool(size=1)
    assert not workers.alive()[0]
    workers.start()
    assert workers.alive()[0]  # warming up
    asked(workers, worker.ready).result(PATIENCE)
    monkeypatch.setattr("app.service.pool.SILENT", -1.0)  # from now on only an idle worker counts
    until(lambda: workers.alive()[0])
    job = asked(workers, time.sleep, PATIENCE, seconds=PATIENCE)
    until(lambda: job.slot)
    assert not workers.alive()[0] and "no worker has answered" in workers.alive()[1]
    workers.close()


def test_closing_the_pool_leaves_no_process():
    workers = Pool(size=1)
    asked(workers, worker.ready).result(PATIENCE)
    (process,) = workers.processes()
    workers.close()
    with pytest.raises(ProcessLookupError):
        os.kill(process, 0)


@pytest.mark.once
@pytest.mark.parametrize(("rank", "quick"), [(HEAVY, LATER), (LATER, SCREEN)])
def test_expensive_tasks_leave_a_worker_for_quick_ones(rank, quick):
    """A QR code, which is computed later than what is on screen, waited a minute for a measurement."""
    workers = Pool(size=2)
    both_at_work(workers)
    slow = [asked(workers, time.sleep, 10 * PATIENCE, rank=rank, seconds=PATIENCE)]
    until(lambda: slow[0].slot)
    assert asked(workers, os.getpid, rank=quick).result(PATIENCE) > 0 and slow[0].slot
    slow += [asked(workers, time.sleep, 10 * PATIENCE, rank=rank, seconds=PATIENCE) for _ in range(2)]
    assert asked(workers, os.getpid).result(PATIENCE) > 0
    assert sum(job.slot is not None for job in slow) == 1
    assert [workers.position(job) for job in slow] == [None, 0, 1]
    workers.close()


@pytest.mark.once
def test_a_job_that_moves_up_takes_the_worker_that_was_kept_free(tmp_path):
    """It waited beside an idle worker until another job ended."""
    workers, blocks = Pool(size=2), tmp_path / "blocks"
    blocks.touch()
    both_at_work(workers)
    slow = asked(workers, until_removed, blocks, rank=LATER, seconds=PATIENCE)
    until(lambda: slow.slot)
    waiting = asked(workers, os.getpid, rank=LATER)
    assert waiting.waits
    workers.move_up(waiting, "a visitor", SCREEN)
    assert waiting.result(PATIENCE) > 0 and not slow.done()
    blocks.unlink()
    workers.close()


def test_exact_runs_rank_below_visible_tasks_and_above_background_tasks(single, tmp_path):
    done, waiting = [], tmp_path / "waiting"
    waiting.touch()
    busy = asked(single, until_removed, waiting, seconds=PATIENCE)
    jobs = {rank: asked(single, os.getpid, rank=rank, owner=rank) for rank in (LATER, EXACT, SCREEN)}
    assert not busy.done()  # all of them wait together
    for rank, job in jobs.items():
        job.add_done_callback(lambda _, rank=rank: done.append(rank))
    waiting.unlink()
    until(lambda: len(done) == len(jobs))
    assert done == [SCREEN, EXACT, LATER]


def test_a_single_worker_also_runs_background_tasks(single):
    assert asked(single, os.getpid, rank=LATER).result(PATIENCE) > 0


def test_background_tasks_of_the_server_do_not_count_as_in_flight(single):
    own = asked(single, worker.ready, owner=NOBODY)
    assert single.in_flight == 0
    visitors = asked(single, worker.ready, owner="a visitor")
    assert visitors.done() or single.in_flight == 1
    for job in (own, visitors):
        job.result(PATIENCE)


@pytest.mark.parametrize(("address", "warned"), [("tcp://10.0.0.2:8786", True), ("tls://10.0.0.2:8786", False)])
def test_a_cluster_without_tls_is_warned_of_when_the_server_starts(address, warned, monkeypatch, caplog):
    pytest.importorskip("distributed", reason="needs the extra `cluster`")
    monkeypatch.setattr(pools, "CLUSTER", address)
    made = pools.made()
    assert made.make.address == address
    assert ("can run any code" in caplog.text and "tls://" in caplog.text) == warned
