"""The page "Accuracy" in Python: it measures a scene, and draws what was measured before."""

import asyncio

import panel as pn
import pytest

from app.features.accuracy import research as accuracy
from app.service.pool import pool
from solver import Scene
from solver.accuracy.compare import Point

SMALL = Scene(nodes=64, width=160.0, radius=0.6, u_x_max=12.0, du_x=0.2, du_z=0.5, E=30.0)
pytestmark = pytest.mark.usefixtures("script")


def test_accuracy_measures_a_scene_without_a_server():
    page = accuracy.Accuracy(SMALL)
    shown = page.layout()
    assert isinstance(shown, pn.viewable.Viewable) and not page.points  # a visit costs nothing
    page.start(page.measure)
    assert "Tolerance 1e-08 nm gives F, L and A to" in " ".join(str(pane.object) for pane in shown.select(pn.pane.Str))


def test_cancel_frees_the_worker():
    page = accuracy.Accuracy(Scene())

    async def cancelled():
        page.start(page.measure)
        while not page.points:
            await asyncio.sleep(0.05)
        page.cancel()
        while pool.in_flight:
            await asyncio.sleep(0.05)

    asyncio.run(asyncio.wait_for(cancelled(), 300.0))
    assert page.text == "Cancelled." and page.share is None


def test_the_cost_of_a_tolerance_is_relative_to_the_largest_one():
    points = [
        Point("tolerance", "fast", value, 0.1, count, error, error, error)
        for value, count, error in ((1e-3, 100, 1e-4), (1e-8, 150, 1e-9))
    ]
    said = accuracy.cost(points)
    assert "to 1e-09 for 150 force evaluations" in said and "1.5 times those at 0.001 nm" in said
    assert "No run at tolerance 1e-05" in accuracy.cost(points, 1e-5)


def test_stored_points_are_of_both_methods_and_reach_a_millionth():
    points = [Point(**row) for row in accuracy.STORED["points"]]
    assert {point.series for point in points} == {"fast", "gfmd"}
    for series in ("fast", "gfmd"):
        assert min(point.branch_error for point in points if point.series == series) < 1e-6
