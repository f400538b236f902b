"""The page of friction over load, without a browser."""

from visitor import PARTING, in_slices, order

from app.features.load.tasks import first_slip
from solver import Scene
from solver.files import plain
from solver.scene import PARAMETERS
from solver.sweeps import row_of


def test_sweep_of_the_press_depth_publishes_a_point_per_slip_and_ends_with_the_page(session):
    order(session, "page", page="load")
    session.show(Scene(nodes=128, width=312.5, u_x_max=20.0, du_x=0.5, du_z=0.5), "fig6")
    order(session, "ask", what="sweep")
    calls = session.jobs.pool.jobs
    assert (
        len(session.features["pages"].page.sweep.waiting) == 12
        and session.features["pages"].page.published["busy"] == 0.0
    )
    calls = [job for job in calls if job.call[0] is first_slip]
    scene = calls[3].call[1]
    result, _ = in_slices(first_slip, scene)
    session.jobs.pool.answer(calls[3], result)
    session.jobs.pool.answer(calls[4], None)  # no slip
    session.jobs.pool.answer(calls[5], "no equilibrium")
    page = session.features["pages"].page.published
    assert page["swept"] == [{"scene": plain({name: getattr(scene, name) for name in PARAMETERS}), **result}]
    expected = row_of(scene)
    assert [result[name] for name in "UFL"] == [expected[name] for name in ("U_s (nm)", "F_s (N/m)", "L_s (N/m)")]
    assert page["texts"]["load-why"] == "Not computed at δ/δ₀ = 0.2: no equilibrium"
    order(session, "page", page="")
    assert all(job.done() for job in calls if job.call[0] is first_slip)


def test_a_run_that_pulls_off_before_a_slip_has_no_point_and_no_reason():
    assert row_of(PARTING)["outcome"] == "pulled off"
    assert in_slices(first_slip, PARTING)[0] is None


def test_sweep_of_a_path_that_sets_its_own_depth_says_why_there_is_none(session):
    session.show(Scene(path="points", points="0,-1; 0,0.2; 4,0.2"), "fig6")
    order(session, "page", page="load")
    order(session, "ask", what="sweep")
    assert session.features["pages"].page.published["texts"]["load-why"].startswith("No sweep: delta_bar")


def test_points_of_a_sweep_have_its_number_and_clearing_begins_another(session):
    """A message under way would bring back what a visitor has cleared."""
    order(session, "page", page="load")
    numbers = [session.features["pages"].page.published["sweep"]]
    for what in ("sweep", "clear", "clear"):
        order(session, "ask", what=what)
        numbers.append(session.features["pages"].page.published["sweep"])
    assert numbers == [0, 1, 2, 3]
