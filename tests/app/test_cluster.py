"""The pool on a dask cluster of two worker processes: equal frames, lost workers, a restarted scheduler."""

import os
import signal
import time

import pytest
from clusters import Local
from helpers import until
from visitor import asked

from app.service import worker
from app.service.caller import Caller
from app.service.pool import Pool
from solver import Scene

pytestmark = [pytest.mark.slow, pytest.mark.thorough]
pytest.importorskip("distributed", reason="needs the extra `cluster`")
PATIENCE = 300  # s; a limit against hanging, not a claim about speed


@pytest.fixture(scope="module")
def local(tmp_path_factory):
    cluster = Local(tmp_path_factory.mktemp("cluster"))
    cluster.start()
    yield cluster
    cluster.stop()


@pytest.fixture
def workers(local, monkeypatch):
    from app.service.cluster import Cluster

    monkeypatch.setattr("app.service.pool.PAUSES", (0.0, 0.2))
    pool = Pool(size=3, make=Cluster(local.address))  # one slot more than there are workers
    pool.start()
    until(lambda: pool.ready == 2)
    yield pool
    pool.close()


def test_cluster_frames_equal_local_frames_bitwise(workers):
    call = (worker.compute, Scene(u_x_max=12.0), None, 600.0, 600.0)  # through its first slip
    far = asked(workers, *call, seconds=600.0).result(PATIENCE)
    one = Caller()
    one.call(worker.start)
    here = one.call(*call)
    one.end()
    assert far.frames == here.frames > 120 and far.blocks == here.blocks


def test_cluster_uses_both_workers_and_abandons_a_hanging_call(workers):
    def busy():
        time.sleep(0.2)
        return os.getpid()

    begun = [asked(workers, busy) for _ in range(2)]
    assert len({job.result(PATIENCE) for job in begun}) == 2
    workers.patience = 0.2
    assert asked(workers, time.sleep, 2.0).exception(PATIENCE).kind == "hang"
    workers.patience = 5.0
    assert asked(workers, os.getpid).result(PATIENCE) > 0
    until(lambda: workers.ready == 2)


def test_cluster_reports_tracebacks_and_computes_again_what_a_killed_worker_had(workers, tmp_path):
    error = asked(workers, int, "x").exception(PATIENCE)
    assert error.kind == "error" and "ValueError" in error.reason

    def stubborn(path):  # sent by value, as workers cannot import this module
        if os.path.exists(path):
            return "the second time"
        with open(path + ".part", "w") as file:
            file.write(str(os.getpid()))
        os.rename(path + ".part", path)
        time.sleep(600.0)

    begun = asked(workers, stubborn, str(tmp_path / "there"), seconds=PATIENCE)
    until((tmp_path / "there").exists)
    os.kill(int((tmp_path / "there").read_text()), signal.SIGKILL)
    assert begun.result(PATIENCE) == "the second time"
    assert asked(workers, os._exit, 1, seconds=PATIENCE).exception(PATIENCE).kind == "crash"
    until(lambda: workers.ready == 2)  # nannies have started others


def test_the_items_of_a_generator_are_heard_from_a_cluster(workers):
    def news(count):
        yield from range(count)
        return "end"

    job = asked(workers, news, 3, streams=True)
    assert job.result(PATIENCE) == "end" and job.parts == [0, 1, 2]


def test_cluster_recovers_when_its_scheduler_restarts(local, workers, monkeypatch):
    monkeypatch.setattr("app.service.pool.GIVE_UP", 0.5)
    local.stop()
    until(lambda: workers.status == "failing")
    failure = asked(workers, os.getpid).exception(PATIENCE)
    assert failure.kind == "closed" and "continues as soon" in str(failure)
    local.start()
    until(lambda: workers.status == "ready")
    assert asked(workers, os.getpid).result(PATIENCE) > 0
