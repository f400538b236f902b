"""Parameters are found again in curves computed with them; what the data do not tell is said."""

import re
from pathlib import Path

import numpy as np
import pytest

from solver import Scene, skeleton_of
from solver.analysis.fit import fit
from solver.analysis.measurement import Measurement, MeasurementError, noise_of, read_measurement
from solver.analysis.spread import deviations, spread_of
from solver.analysis.trial import Model

SMALL = Scene(nodes=64, width=160.0, radius=0.6, delta_bar=0.1, u_x_max=12.0, du_x=0.2, du_z=0.5, E=30.0)
NOISE = 0.01  # of the largest force


@pytest.fixture(scope="module")
def skeleton():
    return skeleton_of(SMALL)


def measured(skeleton, seed=1, scale=1.0, offset=0.0, points=200, load=False):
    """A curve of F_bar with noise, and if asked for of L_bar."""
    U_x, random = np.linspace(0.1, SMALL.u_x_max, points), np.random.default_rng(seed)
    F, L = (c + NOISE * np.abs(c).max() * random.normal(size=points) for c in skeleton.curve(U_x)[:2])
    return Measurement.of(U_x, {"F_bar": scale * F + offset} | ({"L_bar": L} if load else {}))


def test_slips_and_noise_of_a_curve_are_found(skeleton):
    data = measured(skeleton)
    loads = [event.load for event in skeleton.slips]
    assert len(data.slips) == len(loads)
    for index, load in zip(data.slips, loads, strict=True):
        assert data.U_x[index - 1] <= load <= data.U_x[index]
    assert data.noise["F_bar"] == pytest.approx(NOISE * np.abs(skeleton.curve(data.U_x)[0]).max(), rel=0.2)


def test_slips_are_not_taken_for_noise():
    """A sawtooth that slips at each tenth point; the error of 4,000 differences is some 2 %."""
    noise = np.random.default_rng(2).normal(size=4000)
    assert noise_of(100.0 * (np.arange(4000) % 10) / 10.0 + noise) == pytest.approx(1.0, rel=0.06)


def test_a_wave_is_not_taken_for_noise():
    """As smooth sliding makes it, 24 points a period and an amplitude 100 times the noise."""
    noise = np.random.default_rng(2).normal(size=4000)
    assert noise_of(100.0 * np.sin(2.0 * np.pi * np.arange(4000) / 24.0) + noise) == pytest.approx(1.0, rel=0.15)


def test_slips_that_repeat_themselves_have_one_place(skeleton):
    """At a known distance of each other, they all lie off by as much; with a free scale each lies where it lies."""
    data = measured(skeleton, load=True)
    for free, alike in ((("phi_n",), True), (("phi_n", "scale_U"), False)):
        model = Model(SMALL, data, free)
        off = model.residuals(model.start(None))[-len(data.slips) :]
        assert (np.ptp(off) < 1e-6) == alike


def test_what_made_the_curve_is_found_from_elsewhere(skeleton):
    found = fit(SMALL.changed(E=36.0, delta_bar=0.08), measured(skeleton, load=True), ("delta_bar", "E"))
    assert found.reached and found.warnings == ()
    for name in ("delta_bar", "E"):  # four standard errors: by chance once in 16,000
        assert abs(found.values[name] - getattr(SMALL, name)) < 4.0 * found.errors[name]
        assert 0.0 < found.errors[name] < 0.1 * getattr(SMALL, name)


def test_slips_are_found_from_where_it_slides_smoothly():
    weak = SMALL.changed(phi_ratio=0.1)
    from_start = weak.changed(phi_ratio=0.02)
    assert not skeleton_of(from_start).slips
    found = fit(from_start, measured(skeleton_of(weak), load=True), ("phi_ratio", "delta_bar"))
    assert found.reached and found.values["phi_ratio"] == pytest.approx(0.1, abs=4.0 * found.errors["phi_ratio"])


def test_the_scale_of_the_force_is_found(skeleton):
    found = fit(SMALL, measured(skeleton, scale=1.3), ("scale_F",))
    assert found.values["scale_F"] == pytest.approx(1.3, abs=4.0 * found.errors["scale_F"])


def test_what_the_data_do_not_tell_is_said(skeleton):
    """F over E depends on phi_n/E only, so these two are one."""
    found = fit(SMALL.changed(E=31.0), measured(skeleton), ("phi_n", "E", "scale_F"))
    assert any("phi_n" in sentence or "E" in sentence for sentence in found.warnings)


def test_a_curve_that_no_parameter_makes_is_not_said_to_fit(skeleton):
    found = fit(SMALL, measured(skeleton, offset=0.5 * float(skeleton.curve([5.0])[0][0])), ("phi_n",), starts=1)
    assert not found.reached and "no start led" in found.warnings[0]


@pytest.mark.parametrize(
    "text, said",
    [
        ("a,b\n1,2\n", "needed: U_x"),
        ("U_x,F_bar\n1,2\n1,3\n", "line 3.*sort"),
        ("U_x,F_bar\n1,x\n", "line 2.*not a number"),
        ("U_x,F_bar\n1,nan\n", "line 2.*finite"),
        ("U_x,F_bar\n1,2,3\n", "line 2: 3 columns"),
        ("U_x,F_bar\n1,2\n", "1 points"),
    ],
)
def test_a_bad_file_is_refused_with_line_and_remedy(tmp_path, text, said):
    file = tmp_path / "bad.csv"
    file.write_text(text)
    with pytest.raises(MeasurementError, match=said):
        read_measurement(file, SMALL)


def test_forces_in_newtons_per_metre_are_read(tmp_path):
    file = tmp_path / "curve.csv"
    file.write_text("U_x,F\n" + "".join(f"{k},{k * k}\n" for k in range(1, 11)))
    found = read_measurement(file, SMALL)
    assert found.values["F_bar"][-1] == pytest.approx(100.0 / (SMALL.width * SMALL.E))


def test_names_that_cannot_be_free_are_refused(skeleton):
    with pytest.raises(ValueError, match="nodes"):
        fit(SMALL, measured(skeleton), ("nodes",))


@pytest.mark.thorough
def test_a_spread_is_what_draws_make_of_it(skeleton):
    of = deviations(SMALL, {"phi_n": "2%", "E": "0.3"})
    assert of == pytest.approx({"phi_n": 0.02 * SMALL.phi_n, "E": 0.3})
    found = spread_of(skeleton, of, 60)
    assert not found.lost
    # the deviation of 60 draws is right to 9 %
    assert found.drawn.std(axis=0)[:2] == pytest.approx(found.slips[0][:2], rel=0.4)
    low, high = found.interval("F_s")
    assert low < found.sensitivities.slips[0].event.F_bar < high


@pytest.mark.parametrize("text", ["-3%", "x", "0"])
def test_a_spread_that_is_none_is_refused(text):
    with pytest.raises(ValueError, match="phi_n"):
        deviations(SMALL, {"phi_n": text})


def test_the_example_of_the_readme_runs(capsys):
    text = (Path(__file__).parents[1] / "README.md").read_text(encoding="utf-8")
    section = text.partition("## What matters, what fits, what spreads\n")[2].partition("\n## ")[0]
    exec(re.search(r"```python\n(.*?)```", section, re.DOTALL)[1], {})
    assert len(capsys.readouterr().out.splitlines()) == 3
