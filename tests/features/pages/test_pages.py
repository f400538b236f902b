"""The pages without a browser: their contents match the solver, and a closed page costs nothing."""

from types import SimpleNamespace

from visitor import messages, order

from app.features.pages import feature
from app.features.pages.sheet import Sheet


def test_closed_pages_cause_no_jobs_and_no_messages(session):
    sent = messages(session)
    order(session, "hello")
    order(session, "scene", E="80")
    assert {message["kind"] for message in sent} == {"status"} and all(
        job.call[0].__module__ == "app.service.worker" for job in session.jobs.pool.jobs
    )


def test_a_page_that_fails_leaves_the_run_alone(session, caplog, monkeypatch):
    order(session, "hello")
    order(session, "page", page="law")
    monkeypatch.setattr(session.features["pages"].page, "scene_changed", lambda: 1 / 0)
    order(session, "scene", E="80")
    assert session.pursuit.scene.E == 80.0 and session.run.state != "failed" and "ZeroDivisionError" in caplog.text


def test_an_unknown_page_is_named_in_a_note(session):
    order(session, "hello")
    sent = messages(session)
    order(session, "page", page="secret")
    assert session.features["pages"].page is None and {message["kind"] for message in sent} == {"status"}
    assert "no page “secret”" in session.status["notes"][0]


def test_a_page_with_nothing_of_its_own_opens_hears_what_happens_and_closes(session, monkeypatch):
    monkeypatch.setattr(feature, "listed", lambda: {"law": SimpleNamespace(TITLE="Blank", ORDER=0, Page=Sheet)})
    order(session, "page", page="law")
    order(session, "scene", E="80")
    order(session, "ask", what="ever")
    assert session.features["pages"].page.published["open"] == "law"
    order(session, "page", page="")
    assert session.features["pages"].page is None


def test_a_visitor_who_leaves_with_an_open_page_is_sent_nothing(session):
    order(session, "page", page="law")
    sent = messages(session)
    session.close()
    assert sent == []
