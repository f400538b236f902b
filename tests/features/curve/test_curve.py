"""A measured curve over the run on screen, without a browser: what is read, what is kept, and for how long."""

import numpy as np
import pytest

from app.features.curve.feature import kept
from app.features.curve.tasks import LAID, read_curve
from solver import Scene

U_X = np.linspace(0.0, 6.0, 31)
AXES = {
    "friction": ("U_x (nm),F (N/m)", U_X, 3.0 * U_X, "U_x"),
    "load": ("delta (nm),L (N/m)", U_X, 2.0 * U_X - 1.0, "delta"),
    "area over displacement": ("U_x (nm),A (nm)", U_X, 100.0 - U_X, "U_x"),
    "area over force": ("F (N/m),A (nm)", U_X, 100.0 - U_X, "F"),
    "loop": ("U_x (nm),F (N/m)", np.r_[U_X, U_X[-2::-1]], np.r_[U_X, U_X[-2::-1] - 6.0], "U_x"),
}


def text(heading, x, y):
    return "\n".join([heading, *(f"{a:.6g},{b:.6g}" for a, b in zip(x, y, strict=True))]).encode()


FRICTION = text(*AXES["friction"][:3])


@pytest.mark.parametrize("kind", AXES)
def test_five_kinds_of_measured_curves_are_read_with_their_abscissa_and_units(kind):
    heading, x, y, over = AXES[kind]
    curve, why = read_curve(Scene(), text(heading, x, y))
    assert why is None and (curve["kind"], curve["over"]) == (kind, over)
    seen = np.concatenate([segment["x"] for segment in curve["segments"]])
    assert np.allclose(seen, x, atol=1e-5)
    assert curve["points"] == x.size and set(curve["units"].values()) <= {"nm", "N/m"}


def test_a_long_curve_is_thinned_out_to_what_a_drag_can_compare():
    x = np.linspace(0.0, 30.0, 9001)
    curve, _ = read_curve(Scene(), text("U_x (nm),F (N/m)", x, np.sin(x)))
    assert curve["points"] == 9001 and len(curve["segments"][0]["x"]) <= LAID + 1


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"wavelength,colour\n1,2\n3,4\n", "U_x"),
        (b"", "this is an empty file"),
        (text("U_x (nm),F (N/m)", 1e200 * U_X, U_X), "check the units"),
        (text("time (s),F (N/m)", U_X, U_X), "give speed="),
    ],
)
def test_a_file_that_is_no_curve_is_refused_in_words(content, said):
    curve, why = read_curve(Scene(), content)
    assert curve is None and said in why


def test_friction_over_time_is_read_with_the_speed_that_the_visitor_gives():
    curve, _ = read_curve(Scene(), text("time (s),F (N/m)", U_X, U_X), speed=2.0)
    assert curve["segments"][0]["x"][-1] == pytest.approx(12.0)


def dropped(page, content):
    """The message about a file that a visitor drops."""
    page.messages.clear()
    page.order("curve", content=content)
    page.run_scheduled(lambda: page.messages)
    return page.messages[-1]


@pytest.mark.slow
def test_the_server_keeps_the_last_curve_until_its_visitor_leaves(page):
    first = dropped(page, FRICTION)["key"]
    assert kept(first) == (FRICTION, None, None)
    refused = dropped(page, b"nothing")
    assert refused["curve"] is None and refused["why"] and kept(first) == (FRICTION, None, None)
    second = dropped(page, FRICTION + b"\n7,1")["key"]
    assert kept(first) is None and kept(second)
    page.session.close()
    assert kept(second) is None


@pytest.mark.slow
def test_removing_the_curve_leaves_nothing_on_the_server(page):
    key = dropped(page, FRICTION)["key"]
    page.order("forget")
    assert kept(key) is None and kept("") is None
