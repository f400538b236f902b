"""The page "Map of regimes" without a browser: states handed on, refinement, labels, colours."""

import pickle

import numpy as np
import pytest
from visitor import messages, order

from app.features.regimes import tasks
from app.features.regimes.grid import COLUMNS, FIRST, ROWS, grid_of
from app.features.regimes.page import AT_ONCE, labels, limits, outlines
from app.features.regimes.store import stored
from solver import Scene
from solver.analysis.maps import REGIMES, Axis, Map, Point, computed_point

SMALL = Scene(nodes=64, width=160.0, radius=0.6, u_x_max=12.0, du_x=0.2, du_z=0.5, E=30.0)


def test_map_points_are_followed_from_the_bytes_of_their_neighbours():
    grid, known = Map(SMALL, Axis("delta_bar", 0.0, 0.2, 5), Axis("phi_ratio", 0.5, 1.0, 5)), {}
    for place in grid.places():
        known[place] = tasks.map_point(grid.task(place, known))
    assert all(skeleton is None or isinstance(skeleton, bytes) for _, skeleton in known.values())
    assert any(point.followed for point, _ in known.values())


def answered(session):
    """Answer every requested point, also later ones: slips in the left half, smooth sliding in the right."""
    done, slips = 0, REGIMES.index("slips by one site")
    while left := [job for job in session.jobs.pool.jobs if is_point(job) and not job.done()]:
        for job in left:
            done += 1
            i, j = job.call[1].i, job.call[1].j
            regime = REGIMES[slips if i <= COLUMNS // 2 else slips - 2]
            session.jobs.pool.answer(job, (Point(i=i, j=j, regime=regime, F_s=1e-4), None))
    return done


def is_point(job):
    return job.call[0] is tasks.map_point


@pytest.fixture
def page(session, monkeypatch):
    """The page, opened where no map is stored."""
    monkeypatch.setattr("app.features.regimes.page.stored", lambda grid: [])
    order(session, "page", page="regimes")
    return session.features["pages"].page


def test_the_map_of_the_default_experiment_is_there_when_the_page_opens(session):
    order(session, "page", page="regimes")
    page = session.features["pages"].page
    assert not page.sweep.waiting and len(page.known) == COLUMNS * ROWS and page.published["busy"] is None
    order(session, "ask", what="axes", x="delta_bar", y="E")
    assert len(page.sweep.waiting) == AT_ONCE and not page.known  # another map is computed


@pytest.mark.slow
@pytest.mark.parametrize("place", [(2, 22), (14, 18), (31, 3)])
def test_a_stored_map_has_what_its_scenes_give(place):
    """To 1e-3 of the force, as maps are followed; else run `python -m app.features.regimes.store`."""
    grid = grid_of(Scene(), FIRST, "shear")
    found, known = grid.task(place, {}), {(point.i, point.j): point for point in stored(grid)}[place]
    there = computed_point(found)[0]
    assert (known.regime, known.sites) == (there.regime, there.sites)
    quantities = [[getattr(point, name) or 0.0 for name in ("U_s", "F_s", "A_s", "A_0")] for point in (known, there)]
    assert quantities[0] == pytest.approx(quantities[1], rel=1e-3, abs=1e-6)


def test_map_is_refined_from_coarse_to_complete(session, page):
    first = [call[1] for call in page.sweep.waiting]
    corners = {(0, 0), (0, ROWS - 1), (COLUMNS - 1, 0), (COLUMNS - 1, ROWS - 1)}
    assert len(first) == AT_ONCE and {(task.i, task.j) for task in first} >= corners
    empty = page.published["texts"]
    assert (empty["regimes-none"], empty["regimes-low"]) == ("not computed yet", "")  # it said that nothing slips
    assert answered(session) == COLUMNS * ROWS
    told = page.published
    values = np.frombuffer(told["map"]["values"], "<f4")
    assert values == pytest.approx(COLUMNS * ROWS * [1e-4], rel=1e-6)  # N/m, everywhere
    assert {*(np.frombuffer(told["map"]["outline"], "<i2")[::2] / 2)} == {COLUMNS // 2 + 0.5}
    assert told["busy"] is None and told["texts"]["regimes-text"].startswith(f"{COLUMNS * ROWS} of {COLUMNS * ROWS}")


def test_a_whole_map_is_sent_in_fewer_bytes_the_more_of_it_is_known(session, page):
    """It took 1.9 MB as text: its whole image every eight points."""
    sent = messages(session)
    answered(session)
    maps = [message["map"] for message in sent if "map" in message]
    size = sum(len(map[name]) for map in maps for name in ("values", "codes", "outline"))
    assert size < 0.2e6 and len(maps) < 40


def test_a_click_on_the_map_starts_from_the_nearest_stored_skeleton(session, page, monkeypatch):
    scene = session.scene
    places = {"far": (8, 12), "near": (28, 20), "dropped": (27, 21)}
    scenes = {name: page.grid.task(place, {}).scene_there() for name, place in places.items()}
    page.known = {places[name]: (Point(), scene) for name, scene in scenes.items()} | {(29, 20): (Point(), None)}
    kept = {scenes[name]: pickle.dumps(name) for name in ("far", "near")}
    monkeypatch.setattr("app.features.regimes.page.skeletons", kept)
    there = page.grid.task((27, 20), {}).scene_there()
    assert page.nearer(there, scene) == page.nearer(there, None) == "near"
    assert page.nearer(there, there) is None  # what is on screen is nearer
    assert page.nearer(there.changed(nodes=512), None) is None


def test_outlines_separate_regimes_but_not_unknown_points():
    codes = np.array([[1, 1, 2], [1, -1, 2]])
    assert outlines(codes) == [(1.5, -0.5, 1.5, 0.5)]


def test_regime_labels_do_not_overlap_and_the_largest_region_has_one():
    codes = np.full((ROWS, COLUMNS), 2)
    codes[10:13, 14:19] = 3  # a small region in the middle of the largest one
    codes[:4] = 1
    found = labels(codes)
    assert found[0][2] == REGIMES[2] and REGIMES[1] in [name for *_, name in found]
    for k, (i, j, name) in enumerate(found):
        for x, y, other in found[:k]:
            assert abs(j - y) > 2 or abs(i - x) > 0.25 * (len(name) + len(other))


def test_colour_range_of_the_map_ignores_one_outlier():
    image = np.linspace(1.0, 2.0, 825).reshape(25, 33)
    image[3, 3], image[4, 4] = 1000.0, np.nan
    low, high = limits(image)
    assert 1.0 <= low < 1.1 and 1.9 < high <= 2.0


def test_a_cancelled_map_can_be_resumed(session, page):
    assert page.published["hidden"]["regimes-resume"]
    order(session, "ask", what="cancel")
    told = page.published
    assert told["busy"] is None and not told["hidden"]["regimes-resume"]
    order(session, "ask", what="resume")
    assert page.published["busy"] is not None
    answered(session)
    assert page.published["texts"]["regimes-text"].startswith(f"{COLUMNS * ROWS} of {COLUMNS * ROWS}")


def test_map_title_names_the_displayed_quantity(session, page):
    assert page.published["texts"]["regimes-quantity"] == "friction Fₛ of the first slip"
    order(session, "ask", what="of", of="L_min")
    assert page.published["texts"]["regimes-quantity"] == "largest pull, load L"


def test_a_map_that_could_not_be_drawn_is_begun_again(session, page):
    order(session, "ask", what="of", of="L_min")
    session.show(Scene(hold="load"), "fig6")  # whose punch cannot be raised
    assert page.published["texts"]["regimes-text"].startswith("Not drawn") and page.published["busy"] is None
    session.show(Scene(), "fig6")
    assert page.published["busy"] is not None and len(page.sweep.waiting) == AT_ONCE


def test_swapped_axes_make_a_new_map(session, page):
    order(session, "ask", what="axes", x="phi_ratio", y="delta_bar")
    assert (page.grid.x.name, page.grid.y.name) == ("phi_ratio", "delta_bar")
    assert page.published["map"]["axes"][0]["label"].startswith("friction")
