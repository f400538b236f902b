"""The page "Fit" in Python: example data, measured curves, and parameters that fit them."""

from functools import partial
from types import SimpleNamespace

import panel as pn
import pytest

from app import interface
from app.features.fit import research as fit
from solver import Scene

SMALL = Scene(nodes=64, width=160.0, radius=0.6, u_x_max=12.0, du_x=0.2, du_z=0.5, E=30.0)
ROWS = "".join(f"{k},{k * 2.0}\n" for k in range(1, 20)).encode()
pytestmark = pytest.mark.usefixtures("script")


def test_a_fit_finds_the_parameters_of_example_data_and_gives_them_to_the_sliders(monkeypatch):
    monkeypatch.setattr(fit, "randrange", lambda most: 1)
    page = fit.Fit(SMALL)
    assert isinstance(page.layout(), pn.viewable.Viewable) and len(page.curve[0]) > 50
    page.start(page.example)
    assert "400 points" in page.text and page.truth.keys() == set(fit.FREE.values())
    page.start(page.fit)
    assert page.fitted.values["phi_ratio"] == pytest.approx(page.truth["phi_ratio"], rel=0.1)
    table = page.rows()
    assert list(table["parameter"]) == ["friction / adhesion φₜ/φₙ", "press depth δ/δ₀"]
    page.apply(None)
    assert page.scene.phi_ratio == float(f"{page.fitted.values['phi_ratio']:.5g}")


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"", "this is an empty file"),
        (b"U_x,F\n1,2\n1,x\n", "line 3: 'x' is not a number"),
        (b"U_x (nm),F (mN)\n" + ROWS, "divide it by the width of the contact"),
        (b"\xff\xfe\x00", "line 1: "),
        (b"Weg (um),Kraft (mN)\n" + ROWS, "read it over the run of the experiment"),
        (b"1" * 2_000_001, "2000001 bytes; allowed: 2000000"),
    ],
)
def test_an_unusable_file_is_reported_and_the_previous_measurement_stays(content, said):
    page = fit.Fit(SMALL)
    page.start(partial(page.read, b"U_x (nm),F (N/m)\n" + ROWS))
    assert "19 points" in page.text
    page.start(partial(page.read, content))
    assert said in page.text and page.measured.U_x.size == 19
    assert "read_measurement" not in page.text  # no calls in Python


def test_the_page_fit_reads_the_curve_over_the_run_of_the_experiment_or_asks_for_the_file(monkeypatch):
    curve = SimpleNamespace(
        kept={"key": (b"U_x (nm),Force\n" + ROWS, {"columns": {"F": 2}, "units": {"F": "N/m"}})}.get
    )
    monkeypatch.setattr(interface, "classes", lambda: {"files": curve})
    for key, said in (("key", "19 points"), ("gone", "Choose the file again")):
        page = fit.Fit(SMALL)
        page.key = key
        page.layout()
        assert said in page.text


def test_no_fit_starts_without_a_measurement_or_a_free_parameter():
    page = fit.Fit(SMALL)
    page.start(page.fit)
    assert page.text.startswith("There is no measurement")
    page.start(partial(page.read, b"U_x (nm),F (N/m)\n" + ROWS))
    page.free = []
    page.start(page.fit)
    assert page.text.startswith("No parameter is free")
