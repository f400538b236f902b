"""Work in slices: no slice occupies a worker for long, and results equal those of uninterrupted work."""

import pickle
from math import inf

import numpy as np
import pytest
from visitor import SHORT, unpacked, whole_run

from app.service import worker
from solver import Scene

FLAT = Scene(surface="flat", phi_ratio=0.1, u_x_max=40.0, du_x=0.5, damping=inf)


def test_a_finished_run_returns_only_packed_frames_and_its_skeleton():
    made = whole_run(SHORT)
    assert len(pickle.dumps(made)) < sum(map(len, made.blocks)) + len(pickle.dumps(made.skeleton)) + 2000


@pytest.mark.slow
def test_a_run_of_the_default_scene_sends_at_most_700_kB_to_a_worker_and_500_kB_back():
    """Wherever it is cut: here after each of 220 increments, among them the first slip and repeated states."""
    sent, part = [], worker.Part(None)
    while isinstance(part, worker.Part):
        budget = 0.0 if len(sent) < 220 else inf
        to, part = len(pickle.dumps((Scene(), part.state))), worker.compute(Scene(), part.state, budget, inf)
        sent.append((to, len(pickle.dumps(part))))
    to, back = np.max(sent, axis=0)
    assert to <= 700_000 and back <= 500_000


def test_an_increment_out_of_time_is_postponed_and_finally_ends_the_run(monkeypatch):
    monkeypatch.setattr(worker, "QUICK", 0.0)
    part = worker.compute(SHORT, None, 60.0)
    assert part.heavy and not part.made.failure
    monkeypatch.setattr(worker, "SLOW", 0.0)
    last = worker.compute(SHORT, part.state, 60.0)
    assert "Not converged at" in last.failure and "0 s of processor time" in last.failure


def test_a_run_in_two_slices_ends_as_in_one():
    part = worker.compute(SHORT, None, 0.0)
    rest = worker.compute(SHORT, part.state, inf, limit=inf)
    whole = whole_run(SHORT)
    assert part.made.frames + rest.frames == whole.frames
    assert unpacked(rest.blocks[-1])[1]["F_bar"][-1] == pytest.approx(
        unpacked(whole.blocks[-1])[1]["F_bar"][-1], rel=1e-5
    )
