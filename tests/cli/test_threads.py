"""BLAS has one thread while something is computed, and afterwards as many as before."""

import os
from threading import Thread

import pytest
from helpers import blas_threads
from threadpoolctl import threadpool_limits

from app.service.caller import ONE_THREAD, Caller
from solver import NotConverged, Scene, advance, cli, files, load_path, summarize
from solver.continuation.quasistatic import QuasiStatic
from solver.threads import one_thread

SCENE = Scene(surface="flat", phi_ratio=0.1, u_x_max=0.0, du_z=1.0)


@pytest.fixture
def two():
    """BLAS has two threads outside."""
    with threadpool_limits(2, user_api="blas"):
        assert blas_threads() == {2}  # where nothing could be limited, nothing would be shown
        yield


class Watched(QuasiStatic):
    """The fast method, which notes how many threads BLAS has meanwhile."""

    seen = None

    def increment(self, *given):
        type(self).seen = blas_threads()
        return super().increment(*given)


def test_an_increment_has_one_blas_thread_and_its_caller_keeps_two(two):
    for _ in load_path(SCENE, Watched):
        assert Watched.seen == {1} and blas_threads() == {2}
        Watched.seen = None
    advance(SCENE, None, 1.0, Watched)
    assert Watched.seen == {1} and blas_threads() == {2}


def test_blas_threads_are_restored_after_a_failure(two):
    with pytest.raises(NotConverged), one_thread():
        with one_thread():
            assert blas_threads() == {1}
        assert blas_threads() == {1}
        raise NotConverged
    assert blas_threads() == {2}


def test_the_limit_holds_until_the_last_of_two_threads_has_ended(two):
    inner = one_thread()
    with one_thread():
        other = Thread(target=inner.__enter__)
        other.start()
        other.join()
    assert blas_threads() == {1}
    inner.__exit__(None, None, None)
    assert blas_threads() == {2}


def test_a_command_has_one_blas_thread(two, monkeypatch, tmp_path):
    seen = []
    monkeypatch.setattr(files, "summarize", lambda *given: seen.append(blas_threads()) or summarize(*given))
    assert cli.main(["run", "--set", "surface=flat", "u_x_max=0", "du_z=1", "--csv", str(tmp_path / "csv")]) == 0
    assert seen == [{1}] and blas_threads() == {2}


def test_a_worker_process_has_one_blas_thread_and_leaves_the_environment_of_its_caller(monkeypatch):
    """In the process the variables are set before its libraries are loaded."""
    for name in ONE_THREAD:
        monkeypatch.delenv(name, raising=False)
    before = dict(os.environ)
    caller = Caller()
    try:
        assert dict(os.environ) == before
        assert caller.call(os.getenv, "OMP_NUM_THREADS") == "1" and caller.call(blas_threads) == {1}
    finally:
        caller.end()
