"""Exports, loops and uploaded profiles in the app, without a browser."""

import blocks
import numpy as np
import pytest
from visitor import Page, slices

from app.session import pursuit
from solver import Scene, load_path
from solver.analysis.work import work_of

SHORT = Scene(nodes=256, width=625.0, radius=10.0, u_x_max=6.0)


@pytest.fixture
def page(pool, monkeypatch):
    """A visitor whose run came in parts, however fast the solver."""
    monkeypatch.setattr(pursuit, "FIRST", 0.002)
    visit = Page(pool, SHORT)
    visit.order("hello")
    visit.until("finished")
    yield visit
    visit.session.close()


def test_work_of_a_loop_does_not_depend_on_slicing(page):
    scene = SHORT.changed(path="loop", u_x_max=4.0)
    frames = list(load_path(scene))
    expected = work_of(frames)
    works = []
    for piece in slices(scene, 0.005):
        for block in piece.blocks:
            works += list(blocks.columns(block)[1]["work"])
    assert np.asarray(works) == pytest.approx(expected, abs=1e-5 * np.abs(expected).max())
