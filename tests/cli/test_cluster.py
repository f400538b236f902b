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
SMALL = ["nodes=64", "width=160", "radius=0.6", "u_x_max=20"]


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
def test_a_map_computed_on_a_cluster_has_the_regimes_and_slips_of_one_computed_here(address, tmp_path):
    tables = []
    for place in ([], ["--scheduler", address]):
        axes = ["--x", "E=50:80:3", "--y", "delta_bar=0:0.1:2"]
        assert main(["map", *axes, "--set", *SMALL, "--csv", str(tmp_path / "map.csv"), *place]) == 0
        rows = csv.DictReader((tmp_path / "map.csv").open())
        tables.append({(row["i"], row["j"]): (row["regime"], float(row["U_s"])) for row in rows})
    assert len(tables[0]) == 6 and tables[0].keys() == tables[1].keys()
    for place, (regime, U_s) in tables[0].items():
        assert tables[1][place] == (regime, pytest.approx(U_s, abs=1e-5))


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
