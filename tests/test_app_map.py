"""The page "Map": rows from the workers, what they say against exact runs, and what a visitor sees."""

import json

import numpy as np
import pytest
from visitor import order

from app.service import tasks
from app.views.regimes import COLUMNS, ROWS, outlines
from solver import Scene
from solver.analysis.maps import REGIMES, Axis, Point
from solver.analysis.maps.run import computed

SMALL = Scene(nodes=64, width=160.0, radius=0.6, u_x_max=12.0, du_x=0.2, du_z=0.5, E=30.0)


def test_every_place_of_a_row_lies_between_known_ones():
    asked, known = list(tasks.between(17, 3)), set()
    for place, weights in asked:
        assert place not in known and set(weights) <= known and sum(weights.values()) in (0, pytest.approx(1.0))
        known.add(place)
    assert known == {(i, 3) for i in range(17)}


def test_a_row_is_what_exact_runs_tell(monkeypatch):
    x, y = Axis("delta_bar", 0.0, 0.2, 5), Axis("phi_ratio", 0.5, 1.0, 2)
    monkeypatch.setattr(tasks, "SLICE", 0.0)  # it gives way after every point
    made = tasks.map_row(SMALL, x, y, 1)
    parts = 0
    while isinstance(made, tasks.Part):
        parts, made = parts + 1, tasks.map_row(SMALL, x, y, 1, made.kept)
    assert parts == 4 and {(point.i, point.j) for point in made} == {(i, 1) for i in range(5)}
    assert any(point.followed for point in made)
    for point in made:
        exact, _ = computed(SMALL.changed(delta_bar=float(x.values[point.i]), phi_ratio=1.0))
        assert point.regime == exact.regime and point.U_s == pytest.approx(exact.U_s, abs=1e-3)


def test_a_visitor_gets_the_map_row_by_row_and_a_click_loads_a_scene(session):
    order(session, "page", page="regimes")
    rows = [task.call for task in session.pool.tasks if task.call[0] is tasks.map_row]
    assert sorted(call[-1] for call in rows) == list(range(ROWS))
    page = session.pages.page
    slips, slides = (REGIMES.index(name) for name in ("slips by one site", "smooth sliding"))
    for call in rows:
        j = call[-1]
        points = [Point(i=i, j=j, regime=REGIMES[slips if i < 9 else slides], F_s=1e-4) for i in range(COLUMNS)]
        page._take(call, points)
    image = page.views["map"].parts["map"].data_source.data["image"][0]
    scene = session.scene
    assert image[0, 0] == pytest.approx(1e-4 * scene.width * scene.E, rel=1e-6)  # N/m
    outline = np.array(page.views["map"].parts["outline"].data_source.data["i"])
    assert np.nanmin(outline) == np.nanmax(outline) == 8.5
    order(session, "ask", what="go", i=0.2, j=ROWS - 0.8)
    assert session.scene.delta_bar == pytest.approx(-0.3) and session.scene.phi_ratio == pytest.approx(2.0)
    assert json.loads(session.wire.page)["texts"]["regimes-said"].startswith(f"{COLUMNS * ROWS} of")


def test_an_outline_lies_between_regimes_and_not_beside_what_is_unknown():
    codes = np.array([[1, 1, 2], [1, -1, 2]])
    i, j = (np.array(each) for each in outlines(codes))
    assert np.nanmin(i) == np.nanmax(i) == 1.5  # one line, upright
    assert np.nanmin(j) == -0.5 and np.nanmax(j) == 0.5
