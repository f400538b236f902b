"""Slow motion without a browser."""

import numpy as np
import pytest

from solver import Scene


@pytest.mark.slow
def test_motion_through_a_slip_is_sent_on_request_or_a_reason(page):
    page.session.scene = Scene(u_x_max=12.0)
    page.order("hello")
    page.until("finished")
    slips, run = page.curve("slip"), page.session.pursuit.run.number
    k = len(slips) - 1 - int(np.argmax(slips[::-1] > 0))
    page.order("film", run=run, frame=k)
    page.run_scheduled(lambda: page.chunks[-1][0] == ("film", k))
    film = page.curve("U_x")
    assert set(page.curve("index")) == {108} or set(page.curve("index")) == {109}
    assert len(film) > 40 and np.ptp(film) == 0.0 and film[0] == pytest.approx(10.8036, abs=1e-3)
    page.order("film", run=run, frame=k - 5)
    page.run_scheduled(lambda: page.messages)
    assert page.messages.pop() == {"kind": "slip", "why": "no branch ends here"}
    page.order("film", run=run + 1, frame=k)  # of another run than that on screen
    assert page.messages.pop() == {"kind": "slip", "why": "the run on screen has changed; try again"}
    page.order("film", run=run, frame=5000)
    page.run_scheduled(lambda: page.messages)
    assert page.messages.pop()["why"]
