"""The page "Fit" without a browser: files, example data, fits and messages."""

import re

import pytest
from visitor import order, send_file

from app.pages.fit.page import FREE, in_words
from app.service import tasks
from solver import Scene

SMALL = Scene(nodes=64, width=160.0, radius=0.6, u_x_max=12.0, du_x=0.2, du_z=0.5, E=30.0)
CURVE = "U_x,F\n" + "".join(f"{k},{k * 2.0}\n" for k in range(1, 20))


def page_state(session):
    return session.pages.page.published


def answer(session):
    """Do the newest task of the pool, as a worker would."""
    task = session.jobs.pool.tasks[-1]
    call, *arguments = task.call
    task.set_running_or_notify_cancel()
    task.set_result(call(*arguments))


def answer_with(task, result):
    task.set_running_or_notify_cancel()
    task.set_result(result)


@pytest.fixture
def page(session):
    session.scene = SMALL
    order(session, "page", page="fit")
    return session.pages.page


def test_example_data_stay_within_the_ranges_of_the_parameters():
    for scene in (SMALL.changed(delta_bar=-1.0), SMALL.changed(phi_ratio=100.0)):
        for seed in range(20):
            tasks.made_up_scene(scene, seed)  # SceneError for half of the seeds


def test_a_measurement_is_plotted_in_its_own_unit_and_fitted(session, page):
    order(session, "ask", what="example")
    answer(session)
    F = page.views["curve"].parts["measured"].data_source.data["F"]
    assert F.max() == pytest.approx(page.measured.values["F_bar"].max() * page.measured.unit)
    order(session, "ask", what="fit", free="phi_n,phi_ratio,delta_bar")
    answer(session)
    found = page_state(session)["fit"]
    assert list(found["values"]) == ["phi_n", "phi_ratio", "delta_bar"] and page_state(session)["busy"] is None
    off = page.views["residuals"].parts["residuals"].data_source.data["off"]
    assert off.std() == pytest.approx(1.0, abs=0.25)  # of the noise: 400 points tell it to 4 %, the estimate to some 10


def test_initially_free_parameters_are_identified_by_example_data_of_the_default_scene():
    free = tuple(name for name, (_, _, first) in FREE.items() if first)
    found = tasks.fitted(Scene(), tasks.made_up_curve(Scene(), 1)[0], free)
    assert len(free) == 2 and abs(found.correlations[0, 1]) < 0.9
    assert all(sentence.startswith("given ") for sentence in found.warnings)
    assert found.chi2 == pytest.approx(1.0, abs=0.5)


def test_an_invalid_measurement_is_reported_and_the_previous_one_stays(session, page):
    send_file(session, "measurement", CURVE)
    answer(session)
    assert "19 points" in page_state(session)["texts"]["fit-text"]
    send_file(session, "measurement", "U_x,F\n1,2\n1,x\n")
    answer(session)
    assert re.search(r"line 3: F = 'x'.*stays", page_state(session)["texts"]["fit-text"])
    assert page.measured.U_x.size == 19


def test_no_fit_starts_without_a_measurement_or_a_free_parameter(session, page):
    asked = len(session.jobs.pool.tasks)
    order(session, "ask", what="fit", free="phi_n")
    assert len(session.jobs.pool.tasks) == asked
    send_file(session, "measurement", CURVE)
    answer(session)
    order(session, "ask", what="fit", free="nodes,")
    assert page_state(session)["texts"]["fit-text"].startswith("No parameter is free")


def test_a_fit_continues_while_its_page_is_closed(session, page):
    order(session, "file", entry="measurement", text=CURVE)
    answer(session)
    order(session, "ask", what="fit", free="phi_n")
    task = session.jobs.pool.tasks[-1]
    order(session, "page", page="law")
    assert not task.cancelled()
    answer_with(task, "nothing slips")
    order(session, "page", page="fit")
    assert page_state(session)["busy"] is None and "nothing slips" in page_state(session)["texts"]["fit-text"]
    assert session.pages.page is page and page.measured.U_x.size == 19 and page_state(session)["fit"] is None
    session.close()
    assert not session.pages.closed


def test_a_new_file_cancels_the_running_fit(session, page):
    order(session, "file", entry="measurement", text=CURVE)
    answer(session)
    order(session, "ask", what="fit", free="phi_n")
    order(session, "file", entry="measurement", text=CURVE + "20,40\n")
    assert page_state(session)["busy"] is None
    answer(session)
    assert "20 points" in page_state(session)["texts"]["fit-text"]


def test_normalised_forces_are_plotted_with_the_current_stiffness(session, page):
    order(session, "file", entry="measurement", text=CURVE.replace("F", "F_bar"))
    answer(session)
    for E in (30.0, 60.0):
        order(session, "scene", E=f"{E}")
        assert page.views["curve"].parts["measured"].data_source.data["F"][-1] == pytest.approx(38.0 * 160.0 * E)


def test_example_data_state_their_parameters_and_a_rejected_file_is_marked(session, page):
    order(session, "ask", what="example")
    answer(session)
    order(session, "ask", what="fit", free="phi_ratio,delta_bar")
    answer(session)
    fit = page_state(session)["fit"]
    assert list(fit["truth"]) == ["phi_ratio", "delta_bar"] and page_state(session)["made"]
    assert fit["values"]["phi_ratio"] == pytest.approx(fit["truth"]["phi_ratio"], rel=0.1)
    order(session, "file", entry="measurement", text="nonsense")
    answer(session)
    assert page_state(session)["refused"] and "stays" in page_state(session)["texts"]["fit-text"]


def test_cancel_stops_the_fit(session, page):
    send_file(session, "measurement", CURVE)
    answer(session)
    order(session, "ask", what="fit", free="phi_n")
    task = session.jobs.pool.tasks[-1]
    order(session, "ask", what="cancel")
    assert task.cancelled() and page_state(session)["busy"] is None


def test_warnings_use_the_labels_of_the_page():
    said = in_words("phi_n and phi_ratio cannot be told apart: correlation -0.995")
    assert FREE["phi_n"][0][1:] in said and "phi_ratio" not in said and "−0.995" in said


def test_impossible_fits_return_a_sentence():
    assert isinstance(tasks.fitted(SMALL.changed(phi_ratio=0.0), _measured(), ("nodes",)), str)


def _measured():
    return tasks.measured_curve(CURVE, SMALL)[0]
