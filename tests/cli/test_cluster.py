"""Commands on a real dask cluster of two worker processes: the same results, and what is lost there."""

import csv
import os
import time

import pytest
from clusters import Local
from helpers import until

from solver import cluster
from solver.cli import main
from solver.isolated import outcomes

pytestmark = pytest.mark.slow
distributed = pytest.importorskip("distributed", reason="needs the extra `cluster`")
SMALL = ["nodes=64", "width=160"]


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
def test_the_map_of_regimes_agrees_with_the_closed_form_and_on_a_cluster_with_itself(address, tmp_path):
    tables = []
    for place in ([], ["--scheduler", address]):
        assert main(["flats", "--points", "3", "--set", *SMALL, "--csv", str(tmp_path / "map.csv"), *place]) == 0
        tables.append(list(csv.DictReader((tmp_path / "map.csv").open())))
    assert tables[0] == tables[1] and len(tables[0]) == 9
    for row in tables[0]:
        assert float(row["mean"]) == pytest.approx(float(row["exact"]), abs=0.02)  # du_x = 0.2 delta_t ends slips late


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


def test_an_unreachable_cluster_is_named_in_one_line(capsys, monkeypatch, tmp_path):
    monkeypatch.setattr(cluster, "PATIENCE", 0.5)
    grid = ["map", "--x", "E=60:80:2", "--y", "delta_bar=0:0.1:2", "--csv", str(tmp_path / "map.csv")]
    assert main([*grid, "--scheduler", "tcp://127.0.0.1:1"]) == 2
    said = capsys.readouterr().err.strip().splitlines()
    assert said[-1].startswith("scheduler tcp://127.0.0.1:1: cannot be reached")
