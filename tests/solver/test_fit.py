"""Fits recover the parameters of computed curves, and warn of what the data do not determine."""

import re
from io import StringIO

import numpy as np
import pytest

from solver import NotConverged, NotFollowed, Scene, follow, simulate, skeleton_of
from solver.measured.curves import read_measurement
from solver.measured.fit import fit
from solver.measured.measurement import DataError, Measurement, noise_of
from solver.measured.trial import Model

SMALL = Scene(nodes=64, width=160.0, radius=0.6, delta_bar=0.1, u_x_max=12.0, du_x=0.2, du_z=0.5, E=30.0)
WIDE = Scene(nodes=128, width=312.5, delta_bar=0.1, u_x_max=20.0)  # an eighth of the default
NOISE = 0.01  # of the largest force


@pytest.fixture(scope="module")
def skeleton():
    return skeleton_of(SMALL)


def measured(skeleton, scale=1.0, offset=0.0, points=200, load=False, noise=NOISE):
    """A curve of F_bar with noise, and with `load` one of L_bar."""
    U_x, random = np.linspace(0.1, skeleton.scene.u_x_max, points), np.random.default_rng(1)
    F, L = (c + noise * np.abs(c).max() * random.normal(size=points) for c in skeleton.curve(U_x)[:2])
    return Measurement.of(U_x, {"F_bar": scale * F + offset} | ({"L_bar": L} if load else {}))


def test_slips_and_noise_of_a_curve_are_recognised(skeleton):
    data = measured(skeleton)
    loads = [event.load for event in skeleton.slips]
    assert len(data.slips) == len(loads)
    for index, load in zip(data.slips, loads, strict=True):
        assert data.U_x[index - 1] <= load <= data.U_x[index]
    assert data.noise["F_bar"] == pytest.approx(NOISE * np.abs(skeleton.curve(data.U_x)[0]).max(), rel=0.2)


def test_slips_are_not_mistaken_for_noise():
    """A sawtooth that slips at each tenth point; the error of 4,000 differences is some 2 %."""
    noise = np.random.default_rng(2).normal(size=4000)
    assert noise_of(100.0 * (np.arange(4000) % 10) / 10.0 + noise) == pytest.approx(1.0, rel=0.06)


def test_a_smooth_wave_is_not_mistaken_for_noise():
    """As smooth sliding makes it, 24 points a period and an amplitude 100 times the noise."""
    noise = np.random.default_rng(2).normal(size=4000)
    assert noise_of(100.0 * np.sin(2.0 * np.pi * np.arange(4000) / 24.0) + noise) == pytest.approx(1.0, rel=0.15)


def test_slips_at_a_known_distance_share_one_load(skeleton):
    """Their residuals are equal; with a free width, and so an unknown distance, each has its own."""
    data = measured(skeleton, load=True)
    for free, alike in ((("phi_n",), True), (("phi_n", "width"), False)):
        model = Model(SMALL, data, free)
        off = model.residuals(model.start())[-len(data.slips) :]
        assert (np.ptp(off) < 1e-6) == alike


def test_a_fit_recovers_two_parameters_from_another_start(skeleton):
    result = fit(SMALL.changed(E=36.0, delta_bar=0.08), measured(skeleton, load=True), ("delta_bar", "E"))
    assert result.reached and not result.warnings
    for name in ("delta_bar", "E"):  # four standard errors: by chance once in 16,000
        assert abs(result.values[name] - getattr(SMALL, name)) < 4.0 * result.errors[name]
        assert 0.0 < result.errors[name] < 0.1 * getattr(SMALL, name)


@pytest.mark.parametrize("name, truth, end", [("nu", 0.3, 0.0), ("nu", 0.3, 0.4999), ("phi_ratio", 0.5, 0.0)])
def test_a_fit_that_starts_at_the_end_of_a_range_leaves_it(name, truth, end):
    """From the end itself the optimiser never moved; four standard errors: by chance once in 16,000."""
    data = measured(skeleton_of(SMALL.changed(**{name: truth})))
    result = fit(SMALL.changed(**{name: end}), data, [name])
    assert result.reached and abs(result.values[name] - truth) < 4.0 * result.errors[name] < 0.1 * truth


def test_a_fit_reaches_stick_slip_from_smooth_sliding():
    weak = SMALL.changed(phi_ratio=0.1)
    from_start = weak.changed(phi_ratio=0.02)
    assert not skeleton_of(from_start).slips
    result = fit(from_start, measured(skeleton_of(weak), load=True), ("phi_ratio", "delta_bar"))
    assert result.reached and result.values["phi_ratio"] == pytest.approx(0.1, abs=4.0 * result.errors["phi_ratio"])


def test_a_fit_recovers_the_scale_of_the_force(skeleton):
    result = fit(SMALL, measured(skeleton, scale=1.3), ("scale_F",))
    assert result.values["scale_F"] == pytest.approx(1.3, abs=4.0 * result.errors["scale_F"])


def test_a_contact_area_that_vanishes_and_comes_back_is_fitted():
    """It has kinks there. Interpolated over them it was wrong by a tenth of its largest value, and phi_n by 0.1 %."""
    scene = Scene(nodes=256, width=625.0, radius=0.6, delta_bar=-0.04, u_x_max=12.0, du_x=0.2)
    skeleton, U_x = skeleton_of(scene), np.linspace(0.1, 12.0, 120)
    F, L, A = skeleton.curve(U_x)
    assert (A == 0.0).any() and A.max() > 0.02
    result = fit(scene.changed(phi_n=2.1), Measurement.of(U_x, {"F_bar": F, "L_bar": L, "A_bar": A}), ["phi_n"])
    assert result.values["phi_n"] == pytest.approx(2.0, rel=2e-5) and result.reached


def test_a_free_offset_moves_points_along_a_curve_that_is_long_enough():
    """Points beyond u_x_max were compared with its end."""
    scene = Scene(nodes=64, width=160.0, radius=0.6, delta_bar=0.1, u_x_max=3.0)
    U_x = np.linspace(0.7, 3.6, 60)
    F = skeleton_of(scene.changed(u_x_max=4.0)).curve(U_x)[0]
    data = Measurement.of(U_x - 0.6, {"F_bar": F})
    result = fit(scene.changed(E=80.0), data, ["E", "offset_U"])
    assert result.values["E"] == pytest.approx(70.0, rel=1e-3)
    assert result.values["offset_U"] == pytest.approx(-0.6, abs=1e-3)


@pytest.mark.parametrize("noise", [0.0, 0.012])
def test_slips_show_at_eight_points_a_period(noise):
    """2.44 nm a period, every third increment of the default: each slip lies in one interval between points."""
    skeleton = skeleton_of(WIDE)
    data = measured(skeleton, points=round(8 * WIDE.u_x_max / WIDE.spacing), noise=noise)
    intervals = [(data.U_x[index - 1], data.U_x[index]) for index in data.slips]
    loads = [event.load for event in skeleton.slips if event.load < data.U_x[-1]]
    assert len(intervals) == len(loads) == 6
    assert all(low <= load <= high for (low, high), load in zip(intervals, loads, strict=True))


def test_predicted_slips_that_the_data_do_not_show_raise_a_warning():
    result = fit(WIDE, measured(skeleton_of(WIDE), points=18, noise=0.0), ("phi_ratio",))
    assert any(sentence.startswith("0 of 6 predicted slips") for sentence in result.warnings)


@pytest.mark.thorough
@pytest.mark.parametrize(("factor", "sites"), [(0.7, 1), (1.3, 2)])
def test_a_fit_reaches_slips_over_two_sites_or_names_the_distance_of_slips(factor, sites):
    """The truth slips by two sites. Continued runs keep the one site of a start; noise-free, so to 0.1 %."""
    truth = SMALL.changed(E=11.33, delta_bar=0.025, phi_ratio=1.6, u_x_max=30.0, damping=0.5, du_x=0.1, du_z=0.1)
    start = truth.changed(E=factor * truth.E)
    skeleton = skeleton_of(truth)
    assert (skeleton.sites, skeleton_of(start).sites) == (2, sites)
    result = fit(start, measured(skeleton, points=400, noise=0.0), ("E",))
    if sites == 2:
        assert result.reached and result.values["E"] == pytest.approx(truth.E, rel=1e-3)
    else:
        assert not result.reached and "the data slip every 5.02 nm, the curve every 2.5 nm" in result.warnings[0]


def test_a_chi_squared_far_above_one_raises_a_warning(skeleton):
    """The noise of the data is known too small by a factor of 10, so chi^2 is 100 times too large."""
    data = measured(skeleton)
    data = Measurement.of(data.U_x, data.values, {"F_bar": 0.1 * data.noise["F_bar"]})
    result = fit(SMALL, data, ("phi_n",))
    assert result.chi2 == pytest.approx(100.0, rel=0.5) and not result.reached
    assert "chi^2 is" in result.warnings[0]


def test_a_fit_with_a_wrong_fixed_parameter_names_it():
    """The truth has phi_ratio = 0.8. The curve fits with phi_n 90 standard errors off, as only phi_t shows in F."""
    data = measured(skeleton_of(SMALL.changed(phi_ratio=0.8)))
    result = fit(SMALL, data, ("phi_n",))
    assert result.reached and abs(result.values["phi_n"] - SMALL.phi_n) > 50.0 * result.errors["phi_n"]
    assert "phi_ratio = 1" in result.given and not result.warnings  # all fits to sparse curves carry such a note


@pytest.mark.slow
def test_a_second_minimum_within_the_noise_raises_a_warning():
    """Truth and start of one of 200 random fits: without a second search, E was 31 of its errors off in silence."""
    truth = SMALL.changed(u_x_max=24.0, E=17.21, phi_ratio=0.849, delta_bar=-0.016)
    random, U_x = np.random.default_rng(83), np.linspace(0.0, 24.0, 71)[1:]
    F = skeleton_of(truth).curve(U_x)[0]
    data = Measurement.of(U_x, {"F_bar": F + NOISE * np.abs(F).max() * random.normal(size=F.size)})
    free = "E", "delta_n", "phi_ratio"
    result = fit(truth.changed(E=20.24, phi_ratio=0.7785, delta_n=1.593), data, free)
    off = [abs(result.values[name] - getattr(truth, name)) / result.errors[name] for name in free]
    assert max(off) < 4.0 or any("fits within the noise, too; fix one" in each for each in result.warnings)
    assert result.warnings


def test_a_fit_of_an_instrument_constant_depends_on_no_other_parameter(skeleton):
    assert fit(SMALL, measured(skeleton), ("scale_F",)).warnings == ()


def test_a_start_that_slips_too_rarely_is_reported_with_a_remedy(skeleton):
    with pytest.raises(NotFollowed, match=r"^1 predicted slip, 3 measured; start from a scene that slips as often"):
        fit(SMALL.changed(phi_ratio=6.0), measured(skeleton), ("phi_ratio",))


def test_a_constant_force_is_rejected():
    U_x = np.arange(20.0)
    with pytest.raises(DataError, match=r"F is 0 at every point.*check"):
        Measurement.of(U_x, {"F_bar": 0.0 * U_x})


def test_a_fit_that_runs_out_of_time_reports_it(skeleton):
    with pytest.raises(NotConverged, match="within 0 s"):
        fit(SMALL, measured(skeleton), ("E",), limit=0.0)


def test_indistinguishable_parameters_raise_a_warning(skeleton):
    """F over E depends on phi_n/E only, so the data determine their ratio only."""
    result = fit(SMALL.changed(E=31.0), measured(skeleton), ("phi_n", "E", "scale_F"))
    assert any("phi_n" in sentence or "E" in sentence for sentence in result.warnings)


def test_a_curve_that_no_parameter_makes_does_not_fit(skeleton):
    data = measured(skeleton, offset=0.5 * float(skeleton.curve([5.0])[0][0]))
    result = fit(SMALL, data, ("phi_n",))
    assert not result.reached and "does not fit" in result.warnings[0]


@pytest.mark.parametrize(
    "text, said",
    [
        ("a,b\n1,2\n", "needed: U_x"),
        ("U_x (nm),F_bar\n" + "".join(f"{-k},{k}\n" for k in range(9)), "U_x falls from first to last; turn the signs"),
        (
            "U_x (nm),F_bar\n" + "".join(f"{k % 2},{k}\n" for k in range(20)),
            "1 after 2 points is a turn; sort the lines",
        ),
        ("U_x,F_bar\n1,2\n1,x\n", "line 3.*not a number"),
        ("U_x,F_bar\n1,2\n1,2,3\n", "line 3: 3 columns"),
        ("U_x (nm),F_bar\n1,2\n", "points: 1"),
        ("U_x,F_bar\n", "line 2: no points"),
        ("U_x (ft),F_bar\n1,2\n", "U_x in 'ft'; allowed units: nm"),
    ],
)
def test_an_unusable_file_is_rejected_with_line_and_remedy(tmp_path, text, said):
    file = tmp_path / "bad.csv"
    file.write_text(text)
    with pytest.raises(DataError, match=said):
        read_measurement(SMALL, file)


ROWS = [(0.5 * k, 0.25 * k * k) for k in range(1, 11)]
FORMS = {
    "heading of the page": ("U_x (nm),F (N/m)", ",", str),
    "semicolons and decimal commas": ("U_x (nm);F (N/m)", ";", lambda x: str(x).replace(".", ",")),
    "micrometres and millinewtons": ("U_x [um]\tF/mN/m", "\t", str),
    "tabs and decimal commas": ("U_x (nm)\tF (N/m)", "\t", lambda x: str(x).replace(".", ",")),
    "blanks": ("U_x (nm)  F (N/m)", "  ", str),
    "lines above the heading": ("Probe 3\n\n2024, run 7\nU_x (nm),F (N/m)", ",", str),
    "other columns": ('"t (s)","U_x (nm)","F (N/m)"', ",", str),
}


@pytest.mark.parametrize("form", FORMS)
def test_usual_forms_of_a_file_are_read(form):
    heading, separator, text = FORMS[form]
    length, force = (1e-3, 1e3) if "micro" in form else (1.0, 1.0)
    before = [text(0.5)] if "other" in form else []
    lines = [heading, *(separator.join((*before, text(x * length), text(F * force))) for x, F in ROWS)]
    data = read_measurement(SMALL, StringIO("\n".join(lines)))
    assert data.U_x == pytest.approx([x for x, _ in ROWS])
    assert data.values["F_bar"] * data.unit == pytest.approx([F for _, F in ROWS])


@pytest.mark.parametrize(
    "displacement", ["Ux (nm)", "u_x [nm]", "sliding distance in nm", "U_x / nm", "Lateral displacement (nm)"]
)
@pytest.mark.parametrize("force", ["force (N/m)", "F (N m^-1)", "F / mN/mm", "Friction force [N·m⁻¹]"])
def test_usual_headings_are_understood(displacement, force):
    lines = [f"{displacement},{force}", *(f"{x},{F}" for x, F in ROWS)]
    data = read_measurement(SMALL, "\n".join(lines))
    assert data.U_x == pytest.approx([x for x, _ in ROWS])
    assert data.values["F_bar"] * data.unit == pytest.approx([F for _, F in ROWS])


def test_further_columns_of_a_measurement_are_reported():
    data = read_measurement(SMALL, "\n".join(["t (s),U_x (nm),F (N/m)", *(f"0,{x},{F}" for x, F in ROWS)]))
    assert data.notes == ("Not used: t.",)


def test_the_curve_of_a_result_is_read_back_in_its_units(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = simulate(SMALL.changed(u_x_max=3.0))
    result.table.to_csv("curve.csv", index=False)
    data, shear = read_measurement(SMALL, "curve.csv"), [f for f in result.frames if f.stage == "shear"]
    for name in ("F_bar", "L_bar", "A_bar"):
        exact = np.array([getattr(frame, name) for frame in shear])
        # the table prints 0 for a force that the tolerance of the run does not tell from 0
        unknown = SMALL.tolerance / SMALL.delta_t * np.abs(exact).max()
        assert data.values[name] == pytest.approx(exact, rel=1e-12, abs=unknown)
    assert not data.notes


def test_a_fit_takes_the_name_of_a_file(tmp_path):
    file = tmp_path / "curve.csv"
    simulate(SMALL.changed(u_x_max=6.0)).table.to_csv(file, index=False)
    assert fit(SMALL.changed(phi_n=2.02), str(file), ["phi_n"]).values["phi_n"] == pytest.approx(2.0, rel=1e-3)


def test_a_fit_prints_values_with_errors_and_units_the_verdict_and_its_cautions(skeleton):
    shown = repr(fit(SMALL.changed(phi_n=2.1), measured(skeleton), ["phi_n"])).splitlines()
    assert re.fullmatch(r"phi_n = (1.9|2|2.0)\d* \+- [\d.e-]+ N/m", shown[0])
    assert shown[1].startswith("The curve fits within the noise: chi^2 = ")
    assert shown[-1].startswith("Given: ") and all(line.startswith("Caution: ") for line in shown[2:-1])


def test_areas_in_nm_grow_with_a_free_width(skeleton):
    """Derivatives of residuals by the width against central differences of the same states at two widths.

    Two runs, each with states of its own, would not do: whether a run keeps 16 or 18 states can depend on round-off.
    Between them its curve then differs by 5e-5, and the central difference by 0.05.
    """
    U_x, values = measured(skeleton).U_x, measured(skeleton).values
    for width in (None, SMALL.width):
        data = Measurement.of(U_x, values, unit=SMALL.width * SMALL.E, width=width)
        model = Model(SMALL, data, ("width",))
        x, step = np.array([SMALL.width]), 1e-3
        low, high = (model.trial(x + d, follow(skeleton, model.scene_of(x + d))).residuals for d in (-step, step))
        exact = model.trial(x, skeleton).jacobian[:, 0]
        assert (high - low) / (2.0 * step) == pytest.approx(exact, rel=1e-4, abs=1e-5 * np.abs(exact).max())


def test_rows_without_a_number_are_left_out_and_reported():
    lines = ["U_x (nm),F_bar", *(f"{x},{F}" for x, F in ROWS)]
    data = read_measurement(SMALL, StringIO("\n".join([*lines[:3], "1.2,", "1.3,nan", "", *lines[3:]])))
    assert data.U_x == pytest.approx([x for x, _ in ROWS])
    assert data.notes == ("2 rows without all numbers left out (line 4, 5).",)


def staged(*stages):
    """A file of ROWS in each of these stages."""
    return StringIO("\n".join(["U_x (nm),F (N/m),stage", *(f"{x},{F},{stage}" for stage in stages for x, F in ROWS)]))


def test_only_the_shear_of_a_run_is_read():
    assert read_measurement(SMALL, staged("2 shear", "3 unload")).U_x == pytest.approx([x for x, _ in ROWS])


def test_stages_of_retraction_without_delta_are_refused():
    with pytest.raises(
        DataError, match=r"^stage: 'unload', 'reload'; needed: rows of a stage of shear; keep those, or"
    ):
        read_measurement(SMALL, staged("unload", "reload"))


@pytest.mark.parametrize(
    ("heading", "names", "notes"),
    [
        ("U_x (nm),F_bar,L (N/m)", ["F_bar"], ["L is left out beside F_bar; give L_bar: w E may be free."]),
        ("U_x (nm),F (N/m),L_bar", ["F_bar"], ["L_bar is left out beside F; give L: w E may be free."]),
        ("U_x / nm,F_bar,L_bar", ["F_bar", "L_bar"], []),
        ("U_x (nm),F (N/m),L (N/m)", ["F_bar", "L_bar"], []),
    ],
)
def test_a_load_that_is_not_used_is_reported(heading, names, notes):
    data = read_measurement(SMALL, StringIO("\n".join([heading, *(f"{x},{F},{F}" for x, F in ROWS)])))
    assert (list(data.values), list(data.notes)) == (names, notes)


@pytest.mark.parametrize("text", ["\x01\x02rubbish\x7f,b\n", "U_x,F\n1,\x01\x02\n", "PK\0\0"])
def test_binary_content_is_rejected_and_not_echoed(text):
    with pytest.raises(DataError) as refused:
        read_measurement(SMALL, StringIO(text))
    assert str(refused.value).isprintable() and "\\x" not in str(refused.value)


def test_forces_in_newtons_per_metre_are_read(tmp_path):
    file = tmp_path / "curve.csv"
    file.write_text("U_x (nm),F (N/m)\n" + "".join(f"{k},{k * k}\n" for k in range(1, 11)))
    found = read_measurement(SMALL, file)
    assert found.values["F_bar"][-1] == pytest.approx(100.0 / (SMALL.width * SMALL.E))


def test_names_that_cannot_be_free_are_rejected(skeleton):
    with pytest.raises(ValueError, match="nodes"):
        fit(SMALL, measured(skeleton), ("nodes",))


@pytest.mark.parametrize(("free", "write"), [("phi_n", r"\['phi_n'\]"), ([], r"\['delta_bar'\]")])
def test_a_fit_needs_a_list_of_names(skeleton, free, write):
    with pytest.raises(ValueError, match=rf"free = .*: allowed: a list of names, one or more; write {write}"):
        fit(SMALL, measured(skeleton), free)


def test_a_fit_takes_names_that_come_one_by_one(skeleton):
    names = (name for name in ("E", "phi_n"))
    assert list(fit(SMALL, measured(skeleton), names).values) == ["E", "phi_n"]


# Before a fit computes


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (lambda U_x, F: (U_x, -F), r"^F is negative at \d+ of 200 points; turn its sign"),
        (lambda U_x, F: (U_x + 1000.0, F), r"^U_x begins at 1000.1 nm and spans 11.9 nm.*; subtract 1000.1 nm"),
        (lambda U_x, F: (U_x - 500.0, F), r"^U_x begins at -499.9 nm.*; subtract -499.9 nm"),
        (lambda U_x, F: (U_x, 1e6 * F), r"^F reaches .* N/m; an interface .*; check the unit of F"),
        (lambda U_x, F: (U_x, 1e-9 * F), r"^F reaches .* N/m; an interface .*; check the unit of F"),
    ],
)
def test_a_wrong_sign_origin_or_unit_is_named_before_anything_is_computed(skeleton, change, reason):
    """No time is left for a run."""
    data = measured(skeleton)
    U_x, F = change(data.U_x, data.values["F_bar"])
    with pytest.raises(DataError, match=reason):
        fit(SMALL, Measurement.of(U_x, {"F_bar": F}), ("E",), limit=0.0)


def test_swapped_arguments_are_named(skeleton):
    with pytest.raises(TypeError, match=r"^scene = .*: allowed: a Scene; the order is fit\(scene, measured, free\)"):
        fit(measured(skeleton), SMALL, ("E",))
    with pytest.raises(TypeError, match=r"^scene = 'f.csv': allowed: a Scene; the order is read_measurement"):
        read_measurement("f.csv", SMALL)
