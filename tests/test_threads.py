"""BLAS has one thread while something is computed, and afterwards as many as before."""

import pytest
from threadpoolctl import threadpool_info, threadpool_limits

from solver import NotConverged, Scene, advance, cli, load_path
from solver.continuation.quasistatic import QuasiStatic
from solver.threads import one_thread

SCENE = Scene(surface="flat", phi_ratio=0.1, u_x_max=0.0, du_z=1.0)


def threads():
    return {library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"}


@pytest.fixture
def two():
    """BLAS has two threads outside."""
    with threadpool_limits(2, user_api="blas"):
        assert threads() == {2}  # where nothing could be limited, nothing would be shown
        yield


class Watched(QuasiStatic):
    """The fast method, which notes how many threads BLAS has meanwhile."""

    seen = None

    def increment(self, *given):
        type(self).seen = threads()
        return super().increment(*given)


def test_an_increment_has_one_thread_and_its_caller_as_many_as_before(two):
    for _ in load_path(SCENE, Watched):
        assert Watched.seen == {1} and threads() == {2}
        Watched.seen = None
    advance(SCENE, None, 1.0, Watched)
    assert Watched.seen == {1} and threads() == {2}


def test_it_is_so_after_a_failure_too(two):
    with pytest.raises(NotConverged), one_thread():
        with one_thread():
            assert threads() == {1}
        assert threads() == {1}
        raise NotConverged
    assert threads() == {2}


def test_a_command_has_one_thread_for_all_it_does(two, monkeypatch, tmp_path):
    seen = []
    monkeypatch.setattr(
        cli, "summarize", lambda *given: seen.append(threads()) or {"converged": True, "safe_damping": 0.0}
    )
    assert cli.main(["run", "--set", "surface=flat", "u_x_max=0", "du_z=1", "--csv", str(tmp_path / "csv")]) == 0
    assert seen == [{1}] and threads() == {2}
