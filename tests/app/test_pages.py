"""The pages without a browser: their contents match the solver, and a closed page costs nothing."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from visitor import messages, order

from app import pages
from app.pages import Sheet
from app.pages.law import page as law
from app.service import tasks
from app.service.worker import Part
from solver import CHOICES, Scene, toughness
from solver.files import plain
from solver.mechanics import cohesive_law
from solver.scene import PARAMETERS
from solver.sweeps import row_of

APP = Path(pages.__file__).parents[1]


LONGEST = 120  # characters of a line, as ruff holds for Python


@pytest.mark.parametrize("kind", ["js", "css", "html"])
def test_lines_of_scripts_styles_and_templates_have_at_most_120_characters(kind):
    files = list(APP.rglob(f"*.{kind}"))
    assert files
    lines = [(path.name, line) for path in files for line in path.read_text(encoding="utf-8").splitlines()]
    assert not [(name, line) for name, line in lines if len(line) > LONGEST]


def test_closed_pages_cause_no_tasks_and_no_messages(session):
    sent = messages(session)
    order(session, "hello")
    order(session, "scene", E="80")
    assert {message["kind"] for message in sent} == {"status"} and all(
        task.call[0].__module__ == "app.service.worker" for task in session.jobs.pool.tasks
    )


def test_sweep_of_the_press_depth_publishes_a_point_per_slip_and_ends_with_the_page(session):
    order(session, "page", page="load")
    session.show(Scene(nodes=128, width=312.5, u_x_max=20.0, du_x=0.5, du_z=0.5), "fig6")
    order(session, "ask", what="sweep")
    calls = session.jobs.pool.tasks
    assert len(session.pages.page.sweep.waiting) == 12 and session.pages.page.published["busy"] == 0.0
    calls = [task for task in calls if task.call[0] is tasks.first_slip]
    scene = calls[3].call[1]
    result = tasks.first_slip(scene)
    while isinstance(result, Part):
        result = tasks.first_slip(scene, result.state)
    calls[3].set_result(result)
    calls[4].set_result(None)  # no slip
    calls[5].set_result("no equilibrium")
    page = session.pages.page.published
    assert page["swept"] == [{"scene": plain({name: getattr(scene, name) for name in PARAMETERS}), **result}]
    expected = row_of(scene)
    assert [result[name] for name in "UFL"] == [expected[name] for name in ("U_s (nm)", "F_s (N/m)", "L_s (N/m)")]
    assert page["texts"]["load-why"] == "Not computed at δ/δ₀ = 0.2: no equilibrium"
    order(session, "page", page="")
    assert all(task.done() for task in calls if task.call[0] is tasks.first_slip)


def test_sweep_of_a_path_that_sets_its_own_depth_says_why_there_is_none(session):
    session.show(Scene(path="points", points="0,-1; 0,0.2; 4,0.2"), "fig6")
    order(session, "page", page="load")
    order(session, "ask", what="sweep")
    assert session.pages.page.published["texts"]["load-why"].startswith("No sweep: delta_bar")


def test_points_of_a_sweep_have_its_number_and_clearing_begins_another(session):
    """A message under way would bring back what a visitor has cleared."""
    order(session, "page", page="load")
    numbers = [session.pages.page.published["sweep"]]
    for what in ("sweep", "clear", "clear"):
        order(session, "ask", what=what)
        numbers.append(session.pages.page.published["sweep"])
    assert numbers == [0, 1, 2, 3]


def test_a_page_that_fails_leaves_the_run_alone(session, caplog, monkeypatch):
    order(session, "hello")
    order(session, "page", page="law")
    monkeypatch.setattr(session.pages.page, "scene_changed", lambda: 1 / 0)
    order(session, "scene", E="80")
    assert session.pursuit.scene.E == 80.0 and session.run.state != "failed" and "ZeroDivisionError" in caplog.text


def test_an_unknown_page_is_named_in_a_note(session):
    order(session, "hello")
    sent = messages(session)
    order(session, "page", page="secret")
    assert session.pages.page is None and {message["kind"] for message in sent} == {"status"}
    assert "no page “secret”" in session.status["notes"][0]


def test_a_page_that_is_opened_again_is_told_anew(session):
    sent = messages(session)
    for _ in range(2):
        order(session, "page", page="law")
    opened = [message.get("open") for message in sent if message["kind"] == "opened"]
    assert opened[0] == opened[-1] == "law" and {"kind": "opened"} in sent  # closed, it has no texts


def test_a_step_of_the_press_depth_sends_nothing_of_an_unchanged_interface_law(session):
    order(session, "hello")
    order(session, "page", page="law")
    sent = messages(session)
    order(session, "scene", delta_bar="0.21")
    assert {message["kind"] for message in sent} == {"status"}
    order(session, "scene", phi_ratio="0.5")
    law = [message["law"] for message in sent if message["kind"] == "opened"]
    assert law and law[0]["constants"] == cohesive_law.law_constants(session.scene).tolist()


def test_interface_law_page_explains_overlap(session):
    order(session, "page", page="law")
    for name, words in (("np1", "grows where the surfaces overlap"), ("xu-needleman", "changes sign below")):
        order(session, "scene", law=name)
        assert words in session.pages.page.published["texts"]["law-numbers"]


def test_interface_law_page_draws_the_toughness_and_says_how_shear_changes_it(session):
    order(session, "page", page="law")
    for values, words in (
        ({"phi_ratio": "1"}, "weaker than opened"),
        ({"phi_ratio": "8"}, "tougher than opened"),
        ({"phi_ratio": "1", "law": "xu-needleman"}, "as tough as opened"),
        ({"phi_ratio": "0"}, "by opening alone"),
    ):
        order(session, "scene", **values)
        page = session.pages.page
        for task in session.jobs.pool.tasks:
            if task.call[0] is tasks.relative_toughness and not task.done():
                task.set_result(task.call[0](*task.call[1:]))
        assert words in page.published["texts"]["law-toughness-text"]
        drawn = page.published["law"]["toughness"]
        if values["phi_ratio"] == "0":
            assert drawn is None
        else:
            expected = toughness(session.scene, np.radians(drawn["angle"]))
            assert drawn["value"] == pytest.approx(expected, rel=1e-6)


def test_a_page_with_nothing_of_its_own_opens_hears_what_happens_and_closes(session, monkeypatch):
    monkeypatch.setattr(pages, "listed", lambda: {"law": SimpleNamespace(TITLE="Blank", ORDER=0, Page=Sheet)})
    order(session, "page", page="law")
    order(session, "scene", E="80")
    order(session, "ask", what="ever")
    assert session.pages.page.published["open"] == "law"
    order(session, "page", page="")
    assert session.pages.page is None


def test_a_visitor_who_leaves_with_an_open_page_is_sent_nothing(session):
    order(session, "page", page="law")
    sent = messages(session)
    session.close()
    assert sent == []


def test_every_law_has_its_sentence_on_the_page_of_the_law():
    assert law.TEXTS.keys() == CHOICES["law"].keys()
