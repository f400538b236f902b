"""The tables of the layer, without a browser."""

from visitor import messages, order, say

from app.features.fringes import tasks
from app.session.run import Run
from solver import Scene


def test_table_of_a_layer_belongs_to_the_run_on_screen(session):
    sent = messages(session)
    session.pursuit.run = Run(2, Scene(height=2.0), 500, "finished", 0.0)
    say(session, {"do": "layer", "rows": 20, "modes": 32, "depth": 300.0})
    (call,) = session.features["fringes"].waiting
    assert call[1].height == 2.0
    session.features["fringes"]._answered(call, ((1, 2, 3), 1.0, b""))
    assert sent[-1]["geometry"][1] == 2.0 and sent[-1]["asked"] == {"rows": 20, "modes": 32, "depth": 300.0}


def test_repeated_requests_for_a_layer_table_compute_it_once(session):
    order(session, "hello")
    for rows in (100, 60, 100, 60):
        order(session, "layer", rows=rows, modes=100, depth=100.0)
    made = [job for job in session.jobs.pool.jobs if job.call[0] is tasks.layer_table]
    assert len(made) == 2 and not any(job.cancelled() for job in made)
    for job in made:
        session.jobs.pool.does(job)
    sent = messages(session)
    order(session, "layer", rows=100, modes=100, depth=100.0)
    assert [message["kind"] for message in sent].count("table") == 1  # what is known is sent at once
