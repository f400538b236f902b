"""Maps and sweeps on any executor: processes of this machine, threads, a real dask cluster of two worker processes."""

import os
import subprocess
import sys
from concurrent.futures import BrokenExecutor, ThreadPoolExecutor

import pytest
from clusters import Local
from helpers import until

from solver import Axis, Map, Scene, explore_map
from solver.executors import outcomes, processes

SMALL = {"nodes": 64, "width": 160.0, "radius": 0.6, "u_x_max": 20.0}
GRID = Map(Scene(**SMALL), Axis("E", 50.0, 80.0, 3), Axis("delta_bar", 0.0, 0.1, 2))


@pytest.fixture
def client(tmp_path):
    distributed = pytest.importorskip("distributed", reason="needs the extra `cluster`")
    local = Local(tmp_path)
    local.start()
    with distributed.Client(local.address, set_as_default=False) as client:
        until(lambda: len(client.ncores()) == 2)
        yield client
    local.stop()


SCRIPT = """
from solver import Axis, Map, Scene, explore_map
grid = Map(Scene(nodes=64, width=160.0, u_x_max=0.0), Axis("delta_bar", 0.0, 0.1, 2), Axis("E", 60.0, 70.0, 2))
{}print([point.regime for point in explore_map(grid)])
"""


@pytest.mark.parametrize("guard", ["", 'if __name__ == "__main__": '])
def test_a_script_without_a_guard_is_answered_by_one_sentence(tmp_path, guard):
    script = tmp_path / "map.py"
    script.write_text(SCRIPT.format(guard))
    run = subprocess.run([sys.executable, script], capture_output=True, text=True, timeout=120)
    if guard:
        assert run.stdout.count("sticks") == 4 and not run.stderr
    else:
        assert run.stderr.count("Traceback") == 1 and len(run.stderr) < 1200
        assert run.stderr.splitlines()[-1].endswith('put the call of explore_map under `if __name__ == "__main__":`')


def explored(executor):
    return {(point.i, point.j): point for point in explore_map(GRID, executor)}


@pytest.mark.slow
@pytest.mark.thorough
def test_a_map_computed_on_a_cluster_has_the_regimes_and_slips_of_one_computed_here(client):
    here, there = explored(None), explored(client.get_executor())
    assert len(here) == 6 and here.keys() == there.keys()
    for place, point in here.items():
        assert there[place].regime == point.regime
        assert there[place].U_s == pytest.approx(point.U_s, abs=1e-5)


def test_items_are_taken_as_calls_end_and_failures_are_outcomes():
    taken, ended = [], []

    def items():
        for k in range(6):
            taken.append(len(ended))
            yield k

    with ThreadPoolExecutor(2) as executor:
        for item, result in outcomes(lambda k: 6 // k, items(), executor, ahead=2):
            ended.append(item)
            assert isinstance(result, ZeroDivisionError) if item == 0 else result == 6 // item
    assert sorted(ended) == [*range(6)]
    assert all(before >= k - 1 for k, before in enumerate(taken))  # two at a time: the k-th waits for k - 1 of them


def test_a_process_that_dies_is_the_outcome_of_all_that_its_executor_had_left():
    with processes(1) as executor:
        found = dict(outcomes(os._exit, [1, 2, 3], executor, ahead=1))
    assert len(found) == 3 and all(isinstance(result, BrokenExecutor) for result in found.values())
