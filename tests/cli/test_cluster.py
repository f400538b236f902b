"""Maps and calls on a real dask cluster of two worker processes: the same results, and what is lost there."""

import os
import sys
import time

import pytest
from clusters import Local
from helpers import until

from solver import Axis, Map, Scene, cluster, explored
from solver.isolated import Lost, outcomes

pytestmark = pytest.mark.slow
distributed = pytest.importorskip("distributed", reason="needs the extra `cluster`")
SMALL = {"nodes": 64, "width": 160.0, "radius": 0.6, "u_x_max": 20.0}


@pytest.fixture(scope="module")
def address(tmp_path_factory):
    local = Local(tmp_path_factory.mktemp("cluster"))
    local.start()
    until(lambda: workers(local.address) == 2)
    yield local.address
    local.stop()


def workers(address):
    """How many the scheduler knows; 0 without a scheduler."""
    try:
        with distributed.Client(address, timeout=1, set_as_default=False) as client:
            return len(client.ncores())
    except OSError:
        return 0


@pytest.mark.thorough
def test_a_map_computed_on_a_cluster_has_the_regimes_and_slips_of_one_computed_here(address):
    grid = Map(Scene(**SMALL), Axis("E", 50.0, 80.0, 3), Axis("delta_bar", 0.0, 0.1, 2))
    here, there = ({(p.i, p.j): p for p in explored(grid, place)} for place in (None, address))
    assert len(here) == 6 and here.keys() == there.keys()
    for place, point in here.items():
        assert there[place].regime == point.regime
        assert there[place].U_s == pytest.approx(point.U_s, abs=1e-5)


@pytest.mark.thorough
def test_failing_calls_on_a_cluster_cost_no_other_result(address):
    ((_, error),) = outcomes(int, ["x"], address, 60.0)
    assert error.kind == "error" and "ValueError" in error.reason
    for limit in (10.0, 60.0):  # the longer one where the machine is slow
        found = dict(outcomes(time.sleep, [0.0, 2 * limit], address, limit))
        if found[0] is None:
            break
    assert found[0] is None and found[1].kind == "hang"
    ((_, lost),) = outcomes(os._exit, [1], address, 60.0)
    assert lost.kind == "crash"
    until(lambda: workers(address) == 2)
    assert sorted(dict(outcomes(abs, range(10), address, 60.0)).values()) == [*range(10)]


def test_an_unreachable_cluster_is_named_in_one_line(monkeypatch):
    monkeypatch.setattr(cluster, "PATIENCE", 0.5)
    grid = Map(Scene(), Axis("E", 60.0, 80.0, 2), Axis("delta_bar", 0.0, 0.1, 2))
    with pytest.raises(Lost, match=r"^scheduler tcp://127.0.0.1:1: cannot be reached"):
        list(explored(grid, "tcp://127.0.0.1:1"))


def test_a_cluster_without_dask_is_refused_with_a_remedy(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    grid = Map(Scene(), Axis("E", 60.0, 80.0, 2), Axis("delta_bar", 0.0, 0.1, 2))
    with pytest.raises(Lost, match=r'^scheduler: dask is missing; pip install "mixed-mode-contact\[cluster\]"'):
        list(explored(grid, "tcp://127.0.0.1:1"))
