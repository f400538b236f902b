"""Restoring and exporting scenes without a browser: addresses, profiles, files, Python code."""

import numpy as np
import pytest
from visitor import Page

from app.service import worker
from solver import Scene


@pytest.mark.slow
def test_restoring_a_scene_reuses_a_known_run_and_resets_the_preset(page):
    page.order("hello")
    page.until("finished")
    page.order("restore", preset="fig7-case2")
    page.order("restore", delta_bar="0", u_x_max="6")
    page.until("finished")
    assert page.session.preset == "fig6" and page.status()["known"]
    assert page.status()["address"] == {"u_x_max": "6"}


@pytest.mark.slow
def test_a_finished_run_is_stored_with_its_cautions_for_all_visitors_and_dropped_by_its_own(page, pool):
    page.session.scene = Scene(nodes=4096, u_x_max=1.0, E=1000.0)
    page.order("hello")
    assert page.status()["cautions"] == []
    page.until("finished")
    assert "smoothed away" in page.status()["cautions"][0]
    made, results = page.session.run.packed, page.session.jobs.results
    assert (made.blocks, made.skeleton) == ((), None) and (worker.compute, page.session.scene) in results
    other = Page(pool, page.session.scene, jobs=page.session.jobs)
    other.order("hello")
    assert other.status()["state"] == "finished" and other.session.pursuit.job is None
    assert other.status()["cautions"] == page.status()["cautions"]
    assert other.session.run.packed.widest == made.widest > 0.0
    np.testing.assert_array_equal(other.curve("F_bar"), page.curve("F_bar"))
    other.session.close()
