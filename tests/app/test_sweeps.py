"""Requests of pages to workers: shared between visitors, cancelled when unused, repeated after a lost worker."""

import numpy as np
import pytest
from visitor import SHORT, NoPool, order

from app.service import tasks, worker
from app.service.cache import size_of
from app.service.requests import Requests, SharedRequests
from solver.analysis.friction_laws import INDENTATIONS, critical_modulus, onset
from solver.isolated import Lost
from solver.presets import presets


class Visitor:
    """A stand-in for a session: what is scheduled runs at once."""

    def __init__(self, pool):
        self.pool, self.doc = pool, self

    def add_next_tick_callback(self, call):
        call()


@pytest.fixture
def pool():
    return NoPool()


def test_equal_requests_of_visitors_are_computed_once(pool):
    shared, seen = SharedRequests(), []
    sweeps = [Requests(Visitor(pool), lambda call, result, k=k: seen.append((k, result)), shared) for k in range(3)]
    for sweep in sweeps[:2]:
        sweep.add([(abs, -3)])
    assert len(pool.tasks) == 1 and sweeps[0].part == 0.0
    pool.tasks[0].set_result(3)
    assert sorted(seen) == [(0, 3), (1, 3)] and sweeps[0].part is None
    sweeps[2].add([(abs, -3)])
    assert seen[-1] == (2, 3) and len(pool.tasks) == 1


def test_a_shared_call_is_cancelled_when_its_last_visitor_leaves(pool):
    shared = SharedRequests()
    first, second = (Requests(Visitor(pool), lambda call, result: None, shared) for _ in range(2))
    for sweep in (first, second):
        sweep.add([(abs, -3)])
    first.cancel()
    assert not pool.tasks[0].cancelled()
    second.cancel()
    assert pool.tasks[0].cancelled()


def test_a_cancelled_sweep_receives_no_results(pool):
    seen = []
    sweep, other = (
        Requests(Visitor(pool), lambda call, result: seen.append(result), shared) for shared in [SharedRequests()] * 2
    )
    sweep.add([(abs, -3)])
    other.add([(abs, -3)])
    sweep.cancel()
    pool.tasks[0].set_result(3)
    assert seen == [3]


def test_a_call_lost_with_its_worker_is_retried_and_finally_reported(pool):
    seen = []
    sweep = Requests(Visitor(pool), lambda call, result: seen.append(result), SharedRequests())
    sweep.add([(abs, -3)])
    for attempt in range(3):
        assert len(pool.tasks) == attempt + 1 and not seen
        pool.tasks[attempt].set_exception(Lost("crash", "gone"))
    assert isinstance(seen[0], Lost)


def test_partial_results_are_accumulated_on_the_server(pool, monkeypatch):
    monkeypatch.setattr(tasks, "SLICE", 0.0)  # one increment each, behind the approach
    seen = []
    sweep = Requests(Visitor(pool), lambda call, result: seen.append(result), SharedRequests())
    sweep.add([(tasks.whole_run, SHORT)])
    while not seen:
        call, *arguments = pool.tasks[-1].call
        pool.tasks[-1].set_result(call(*arguments))
    whole = worker.compute(SHORT, None, 600.0)
    assert len(pool.tasks) > 1 and (seen[0].frames, seen[0].skeleton is None) == (whole.frames, False)
    kept = [task.call[2] for task in pool.tasks[1:]]
    assert all(isinstance(each, bytes) for each in kept)


def test_least_recently_used_results_are_dropped(pool):
    shared = SharedRequests(capacity=2 * size_of(((abs, -1), 1)))
    sweep = Requests(Visitor(pool), lambda call, result: None, shared)
    for k in range(3):
        sweep.add([(abs, -k)])
        pool.tasks[k].set_result(k)
    sweep.add([(abs, 0)])
    assert len(pool.tasks) == 4


# the pages


def done(session, call_of=lambda call: True):
    """Do the tasks, as workers would."""
    for task in session.pool.tasks:
        if not task.done() and call_of(task.call):
            task.set_result(task.call[0](*task.call[1:]))


def of_kind(kind):
    return lambda call: call[0] is kind


def page_state(session):
    return session.pages.page.published


@pytest.mark.slow
def test_friction_of_flat_runs_lies_on_the_exact_curve(session):
    session.restore({"preset": "fig4a-blue"})
    order(session, "page", page="stickslip")
    done(session, of_kind(tasks.flat_friction))
    parts = session.pages.page.views["mean"].parts
    runs, exact = parts["runs"].data_source.data, parts["exact"].data_source.data
    assert len(runs["ratio"]) == 9
    expected = np.interp(np.log(runs["ratio"]), np.log(exact["ratio"]), exact["mean"])
    assert np.asarray(runs["mean"]) == pytest.approx(expected, abs=0.02)  # a run stops every 0.2 nm of the drop
    assert parts["low"].left == pytest.approx(
        critical_modulus(presets()["fig4a-blue"].scene) / (0.2 * np.sqrt(2 / np.e))
    )


def test_a_click_on_the_stick_slip_map_loads_that_flat_scene(session):
    order(session, "page", page="stickslip")
    order(session, "ask", E=200.0, phi_t=0.02)
    scene = session.scene
    assert (scene.surface, scene.E, scene.phi_ratio, scene.delta_bar) == ("flat", 200.0, 0.01, 0.0)
    assert session.preset == "fig4a-blue"


def test_legend_of_the_stick_slip_map_ends_at_its_largest_value(session):
    """Mean friction of a soft layer over tau_max falls as the lattice gets finer."""
    order(session, "page", page="stickslip")
    told = []
    for nodes in (512, 1024, 2048):
        session.change({"nodes": str(nodes)})
        told.append(float(session.pages.page.published["texts"]["stickslip-most"]))
        shown = session.pages.page.views["map"].parts["map"].glyph.color_mapper
        assert told[-1] == pytest.approx(shown.high, rel=0.05)
    assert told[0] > told[1] > told[2]


def test_area_laws_request_the_current_series_first_then_figure_8(session):
    session.change({"phi_ratio": "0.5"})
    order(session, "page", page="arealaws")
    asked = [task.call[1] for task in session.pool.tasks if task.call[0] is tasks.onset_of]
    assert [scene.delta_bar for scene in asked[:10]] == [*INDENTATIONS, 1.0]
    assert {scene.phi_ratio for scene in asked[:10]} == {0.5}
    assert len(asked) == 40 and len({(s.phi_n, s.phi_ratio) for s in asked}) == 4


def test_area_laws_show_each_onset_when_it_is_computed(session):
    order(session, "page", page="arealaws")
    assert session.pages.page.views["runs"].figure.y_range.end == 1.0  # in thousandths, before anything is known
    task = next(t for t in session.pool.tasks if t.call[0] is tasks.onset_of and t.call[1].delta_bar == 0.1)
    done(session, lambda call: call[:2] == task.call[:2])  # slice by slice
    found = onset(task.call[1])
    data = session.pages.page.views["threshold"].parts["points0"].data_source.data
    assert (data["F"], data["A"]) == (pytest.approx([1000 * found.F_s]), pytest.approx([1000 * found.A_s]))
    row = page_state(session)["tables"]["arealaws-rows"][0]
    assert row[0] == "0.10" and float(row[3]) == pytest.approx(6693, rel=0.01)
    assert page_state(session)["busy"] == pytest.approx(1 / 30)
    order(session, "ask", what="cancel")
    assert page_state(session)["busy"] is None


def test_an_interface_is_added_once_and_replaces_the_oldest(session):
    order(session, "page", page="arealaws")
    for ratio in ("0.5", "0.4", "0.3"):
        order(session, "scene", phi_ratio=ratio)
        assert not page_state(session)["hidden"]["arealaws-add"]
        order(session, "ask", what="add")
        assert page_state(session)["hidden"]["arealaws-add"]
    names = [pick["label"] for _, pick, *_ in page_state(session)["tables"]["arealaws-series"]]
    asked = [task for task in session.pool.tasks if task.call[0] is tasks.onset_of and not task.cancelled()]
    assert len(asked) == 50  # nothing is computed any longer for the series that had to go
    assert len(names) == 5 and names[-1] == "φₙ = 2, φₜ/φₙ = 0.3" and names[0] == "φₙ = 2, φₜ/φₙ = 1"


def test_runs_of_the_stick_slip_page_can_be_cancelled(session):
    order(session, "page", page="stickslip")
    assert page_state(session)["busy"] == 0.0
    order(session, "ask", what="cancel")
    assert page_state(session)["busy"] is None
    assert all(task.cancelled() for task in session.pool.tasks if task.call[0] is tasks.flat_friction)
