"""Cautions about questionable parameters, and the accuracy measurement in the app."""

import re

import pytest
from served import PATIENCE, finished
from visitor import Page, order

from app.service import bench
from app.service.pool import HEAVY
from solver import Scene, simulate, whole_surface
from solver.cautions import cautions
from solver.isolated import Lost
from solver.run.frame import largest_overlap


def test_the_default_scene_needs_no_caution():
    assert cautions(Scene(), 0.3) == []


@pytest.mark.parametrize(
    ("scene", "widest", "said"),
    [
        (Scene(nodes=4096), 0.3, "smoothed away"),
        (Scene(delta_t=0.5), 0.3, "too wide"),
        (Scene(E=14.0, phi_ratio=2.0), 0.3, "the time step of the motion"),
        (Scene(radius=10.0), 0.61, "periodic neighbours"),
        (Scene(radius=1.0), 0.3, "slopes are not small"),
        (Scene(u_x_max=400.0), 0.3, "strained by up to 16 %"),
        (Scene(height=0.1), 0.3, "strained by up to 16 %"),
    ],
)
def test_each_questionable_parameter_gives_one_caution(scene, widest, said):
    (sentence,) = cautions(scene, widest)
    assert said in sentence


def test_too_weak_damping_gives_a_caution_with_a_safe_value():
    (sentence,) = cautions(Scene(damping=0.3), 0.3, safe_damping=0.42)
    assert "may flutter" in sentence and "Use 0.42 or more" in sentence
    assert cautions(Scene(damping=0.42), 0.3, safe_damping=0.42) == []


def test_surfaces_that_overlap_by_more_than_delta_n_give_a_caution_under_the_law_with_a_potential():
    scene = Scene(law="xu-needleman")
    (sentence,) = cautions(scene, overlap=1.7)
    assert "overlap by up to 1.7 δₙ" in sentence and "Use law=np1, or a smaller delta_bar" in sentence
    assert cautions(scene, overlap=1.0) == cautions(Scene(), overlap=1.7) == []


def test_a_pressed_contact_overlaps_and_a_flat_far_away_does_not():
    deep, far = (simulate(Scene(nodes=32, width=80.0, u_x_max=0.0, delta_bar=d)).frames for d in (1.0, -0.9))
    scene = deep[-1].scene
    expected = -(scene.profile + whole_surface(deep[-1])[1]).min() / scene.delta_n
    assert largest_overlap(deep) == pytest.approx(expected, abs=1e-6) and expected > 1.0
    assert largest_overlap(far) == largest_overlap([]) == 0.0


def test_cautions_start_at_their_limits_and_accumulate():
    assert cautions(Scene(nodes=1600, delta_t=1.25), 0.2) == []  # a / delta_t = 1.25
    assert cautions(Scene(radius=10.0), 0.6) == []
    assert cautions(Scene(E=16.0, phi_ratio=2.0), 0.3) == []
    assert cautions(Scene(width=4096.0, damping=0.4), 0.2) == []  # a / delta_t = 4
    assert cautions(Scene(delta_t=0.5, nu=0.4999), 0.2) == []  # such a layer does not move sideways
    assert len(cautions(Scene(nodes=4096, u_x_max=400.0, radius=1.0), 0.9)) == 4


def test_a_flat_gives_no_caution_about_neighbours_or_slopes():
    assert cautions(Scene(surface="flat", radius=1.0), 1.0) == []


@pytest.mark.slow
def test_cautions_are_published_after_new_and_known_runs(pool):
    page = Page(pool, Scene(nodes=4096, u_x_max=1.0, E=1000.0))
    page.order("hello")
    assert page.status()["cautions"] == []
    page.until("finished")
    assert "smoothed away" in page.status()["cautions"][0]
    other = Page(pool, page.session.scene, jobs=page.session.jobs)
    other.order("hello")
    assert other.status()["cautions"] == page.status()["cautions"]
    assert page.session.run.packed.widest == other.session.run.packed.widest > 0.0
    page.session.close()
    other.session.close()


def measuring(session):
    """The task of the measurement that was begun last."""
    return [task for task in session.jobs.pool.tasks if task.call[0] is bench.work][-1]


def measurement(session):
    return session.pages.page.report


def test_an_accuracy_measurement_reports_its_points_and_is_cancelled_by_another_scene(session):
    order(session, "page", page="accuracy")
    order(session, "ask", what="measure")
    task = measuring(session)
    assert measurement(session)["state"] == "waiting" and task.rank == HEAVY
    task.hear({"state": "measuring", "progress": 0.5, "points": []})
    assert measurement(session)["state"] == "measuring" and page_state(session)["texts"]["accuracy-state"] == "50%"
    order(session, "scene", E="80")
    assert measurement(session)["state"] == "cancelled" and measurement(session)["why"] == "the scene has changed"
    assert task.cancelled()
    task.hear({"state": "measuring", "progress": 0.6, "points": []})
    assert measurement(session)["state"] == "cancelled"


def test_a_measurement_that_takes_too_long_is_reported_with_advice(session):
    order(session, "page", page="accuracy")
    order(session, "ask", what="measure")
    measuring(session).set_exception(Lost("hang", "no answer"))
    assert measurement(session)["state"] == "failed" and "less expensive scene" in measurement(session)["why"]


def test_an_empty_accuracy_report_has_no_points():
    assert bench.points(None) == []


def page_state(session):
    return session.pages.page.published


def test_measured_accuracy_survives_closing_the_page_and_names_its_scene(session):
    point = {"series": "fast", "tolerance": 1e-5, "seconds": 0.03, "evaluations": 700, "error": 2e-6}
    order(session, "page", page="accuracy")
    assert page_state(session)["texts"]["accuracy-state"].startswith("takes")
    session.pages.page.report["scene"] = session.scene
    session.pages.page._show({"state": "done", "points": [point], "sentence": "It is right."})
    order(session, "page", page="")
    order(session, "page", page="accuracy")
    texts = page_state(session)["texts"]
    assert texts["accuracy-state"] == "done" and texts["accuracy-sentence"] == "It is right."
    for work in ("seconds", "evaluations"):
        view = session.pages.page.views[work]
        for label in ("mark fast", "fast"):
            assert view.parts[label].data_source.data[work] == [point[work]]
        assert view.parts["fast"].data_source.data["text"] == ["1e−5"]
        assert view.figure.x_range.start < point[work] < view.figure.x_range.end
    order(session, "scene", E="80")
    assert page_state(session)["texts"]["accuracy-state"].endswith("E = 70 GPa")


@pytest.mark.thorough
@pytest.mark.browser
def test_accuracy_measurement_shows_progress_beside_the_live_experiment(look):
    page = look("?nodes=64&width=160&radius=1&u_x_max=8&du_x=0.2&du_z=0.5&page=accuracy")
    finished(page)
    page.get_by_role("button", name="Measure now").click()
    page.wait_for_function("0 < document.querySelector('#accuracy progress').value", timeout=PATIENCE)
    page.wait_for_function("document.getElementById('accuracy-state').textContent === 'done'", timeout=PATIENCE)
    assert "tolerance" in page.locator("#accuracy-sentence").text_content()
    assert "python -m solver accuracy --quick" in page.locator("#accuracy-others").text_content()
    assert page.locator("#accuracy progress").is_hidden()
    for plot in ("seconds", "evaluations"):
        page.locator(f"#accuracy [data-view=accuracy_{plot}]").click()
        page.locator("#table").wait_for()
        rows = page.locator("#table tbody tr").all_inner_texts()
        for series in ("fast", "gfmd"):
            assert any(re.match(rf"{series}\t.*\t1e−\d+$", row) for row in rows)
        page.keyboard.press("Escape")
        page.locator("#table").wait_for(state="hidden")
    assert page.evaluate("punch.status.run - before") == 1


@pytest.mark.thorough
@pytest.mark.browser
def test_accuracy_measurement_is_cancelled_by_its_button_and_by_a_slider(look):
    page = look("?page=accuracy")
    finished(page)
    state = page.locator("#accuracy-state")
    for run, end in ((1, "Cancel"), (2, "ArrowRight")):
        page.get_by_role("button", name="Measure now").click()
        page.wait_for_function("document.getElementById('accuracy-state').textContent.endsWith('%')", timeout=PATIENCE)
        if end == "Cancel":
            page.locator("#accuracy").get_by_role("button", name="Cancel").click()
            page.wait_for_function("document.getElementById('accuracy-state').textContent === 'cancelled'")
        else:
            page.focus("#delta_bar")
            page.keyboard.press("ArrowRight")
            page.wait_for_function(
                "document.getElementById('accuracy-state').textContent.includes('scene has changed')", timeout=PATIENCE
            )
        finished(page, run=run)
    assert "cancelled" in state.text_content()
