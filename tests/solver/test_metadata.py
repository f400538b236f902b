"""What a file says of its numbers is used, or named: nothing is read by a default in its place, nothing goes unsaid."""

import numpy as np
import pytest

from solver import Scene, read_measurement, read_profile, simulate
from solver.measured.measurement import Measurement
from solver.surfaces import DataError

SCENE = Scene()
X = np.arange(40)
TRIANGLE = [*range(20), *range(20, 0, -1)]  # to and fro


def lines(heading, *columns):
    """A table of columns, of texts or numbers, below its heading."""
    return "\n".join([heading, *(",".join(map(str, row)) for row in zip(*columns, strict=True))])


def read(text, **how):
    return read_measurement(SCENE, text, **how)


def wave(points=64):
    return 3.0 * np.sin(np.pi * np.arange(points) / 16)


def force_curve(heights, measured):
    """Two segments as a force microscope exports them, with the setpoint of the height and the measured one."""
    head = "# segment: {}\n# columns: height vDeflection {}\n# units: m N m\n"
    rows = [f"{1e-6 - 1.39e-9 * at:.5e} {max(at, -2) * 1e-9:.3e} {1e-6 - 1e-9 * at:.5e}" for at in heights]
    return "\n".join([head.format("extend", measured), *rows, "", head.format("retract", measured), *rows[::-1]])


@pytest.mark.parametrize("measured", ["measuredHeight", "capacitiveSensorHeight", "smoothedMeasuredHeight"])
def test_a_measured_height_comes_before_the_setpoint_of_the_piezo(measured):
    curve = read(force_curve(range(-10, 21), measured))
    assert [np.ptp(segment.x) for segment in curve.segments] == pytest.approx([30.0, 30.0])
    assert "Not used: height." in curve.notes


def test_of_two_measured_heights_the_calibrated_one_is_read():
    text = force_curve(range(-10, 21), "capacitiveSensorHeight").replace(
        "vDeflection capacitiveSensorHeight", "vDeflection capacitiveSensorHeight measuredHeight"
    )
    rows = [(line, line.split()) for line in text.replace("m N m", "m N m m").split("\n")]
    both = (f"{line} {2.0 * float(row[2]):.6e}" if line and line[0] != "#" else line for line, row in rows)
    assert np.ptp(read("\n".join(both)).segments[0].x) == pytest.approx(60.0)


@pytest.mark.parametrize(
    ("first", "second", "names"), [(1, 2, ["approach", "retract"]), (0, 1, ["approach", "retract"])]
)
def test_numbers_of_segments_are_names_only_where_the_surfaces_move_that_way(first, second, names):
    numbers = [first if k < 20 else second for k in range(40)]
    curve = read(lines("delta (nm),L (nN),segment", TRIANGLE, np.power(TRIANGLE, 1.5), numbers))
    assert [segment.name for segment in curve.segments] == names
    assert sum(segment.x.size for segment in curve.segments) == 40
    assert any("numbers of segment" in note for note in curve.notes) == (first == 1)


def test_numbered_strokes_of_a_loop_are_all_read_and_a_phase_is_no_segment():
    force = [1.0 if k < 20 else -1.0 for k in range(40)]
    loop = read(lines("U_x (nm),F (N/m),segment", TRIANGLE, force, [1 + (k >= 20) for k in range(40)]))
    assert loop.kind == "loop" and sum(segment.x.size for segment in loop.segments) == 40
    curve = read(lines("delta (nm),L (nN),Phase (deg)", TRIANGLE, np.power(TRIANGLE, 1.5), [1] * 40))
    assert [segment.name for segment in curve.segments] == ["approach", "retract"]


@pytest.mark.parametrize("beside", ["Time (s)", "Linear Position (mm)"])
def test_a_displacement_beside_a_time_or_another_length_may_be_wear_and_is_asked_for(beside):
    text = lines(f"{beside},Friction force (N),Displacement (um)", X, 3.0 + np.sin(X), 0.1 * X)
    with pytest.raises(DataError, match="the way along the surface") as refused:
        read(text)
    assert refused.value.call["columns"] == {"U_x": ..., "F": "Friction force"}
    assert read(text, columns={"U_x": "Displacement"}).units["U_x"] == "nm"


def test_commas_in_quotes_separate_thousands_where_points_are_decimal():
    force = [f'"{value:,.1f}"' for value in 1100.0 + 7.0 * X]
    curve = read(lines("U_x (um),F (N),", 0.5 * X, force, [""] * 40))
    assert curve.segments[0].values["F"] == pytest.approx(1100.0 + 7.0 * X)
    assert "Commas in quotes separate thousands." in curve.notes


def test_commas_in_quotes_are_decimal_where_no_thousands_would_fit_and_else_refused():
    decimal = read(lines("U_x (nm),F (N/m)", X, [f'"{k},{k % 10}"' for k in X]))
    assert decimal.segments[0].values["F"] == pytest.approx(X + 0.1 * (X % 10))
    with pytest.raises(DataError, match="thousands"):
        read(lines("U_x (nm),F (N/m)", X, [f'"1,{100 + k}"' for k in X]))


def test_a_separator_in_quotes_is_none():
    curve = read(lines("U_x (nm),F (N/m),what", X, X**0.5, [f'"run {k}, first"' for k in X]))
    assert curve.segments[0].values["F"] == pytest.approx(X**0.5)


@pytest.mark.parametrize(
    ("text", "left", "least"),
    [
        ("U_x (nm)\tF (N/m)\tT (C)\n" + "\n".join(f"{k}\t{k + 1}" + "\t99" * (k > 4) for k in range(40)), 5, 5),
        (lines("U_x (nm),F (N/m)", X[:7], X[:7]) + "\n" + lines("U_x (nm),F (N/m)", X[7:], X[7:]), 7, 7),
        ("U_x(nm) F(N/m) T(C)\n" + "\n".join(f"{k:5d}{'' if k == 20 else k + 1:>9}{99.0:7.1f}" for k in X), 1, 0),
    ],
)
def test_rows_of_numbers_that_are_not_used_are_counted(text, left, least):
    curve = read(text)
    assert any(note.startswith(f"{left} row{'s' * (left > 1)} apart from the table") for note in curve.notes)
    x = curve.segments[0].x
    assert x.min() == least and x.size == 40 - left and not np.any(curve.segments[0].values["F"] == 99.0)


@pytest.mark.parametrize("second", ["U_x (um),F (N/m)", "F (N/m),U_x (nm)", "time (s),COF"])
def test_tables_of_other_columns_or_units_are_not_read_as_one(second):
    text = lines("U_x (nm),F (N/m)", X[:20], X[:20]) + "\n\n" + lines(second, X[20:], X[20:])
    with pytest.raises(DataError, match="table 2, from line 24, has other columns or units"):
        read(text, channel="all")
    assert read(text, channel=1).segments[0].x.size == 20
    same = lines("U_x (nm),F (N/m)", X[:20], X[:20]) + "\n\n" + lines("U_x (nm),F (N/m)", X[20:], X[20:])
    assert read(same, channel="all").segments[0].x.size == 40


@pytest.mark.parametrize(("above", "cell"), [("", "-1.#IND"), ("", "1.#QNAN"), ("# missing value: -999\n", "-999")])
def test_what_stands_for_no_number_is_none(above, cell):
    force = [cell if k == 20 else k + 1.0 for k in X]
    curve = read(above + lines("U_x (nm),F (N/m)", X, force))
    assert curve.segments[0].x.size == 39 and curve.segments[0].values["F"].min() == 1.0
    assert any("1 row without all numbers" in note for note in curve.notes)


@pytest.mark.parametrize(
    ("heading", "how", "unit"),
    [
        ("Position (z), mm\tFz, gf", {"columns": {"delta": 1, "L": 2}}, "gf"),
        ("delta (nm)\tDefl_pN_Ex", {"columns": {"L": 2}}, "pN"),
        ("# Force unit: mN\ndelta (nm)\tL", {}, "mN"),
    ],
)
def test_an_argument_does_not_contradict_a_unit_wherever_it_stands(heading, how, unit):
    text = heading + "\n" + "\n".join(f"{k}\t{k**1.5 + 1.0}" for k in X)
    size = {"gf": 9.80665e-3, "pN": 1e-12, "mN": 1e-3}[unit]
    assert read(text, **how).segments[0].values["L"] == pytest.approx(size * (X**1.5 + 1.0))
    with pytest.raises(DataError, match=f"the file names {unit}"):
        read(text, **how, units={"L": "N"})


def test_two_units_of_one_column_are_asked_for_also_from_lines_above():
    with pytest.raises(DataError, match="nm or um"):
        read_profile("x (nm),z (nm)\n# unit: um\n" + lines("", 5 * np.arange(64), wave()).lstrip())
    with pytest.raises(DataError, match="'N or mN'"):
        read("# Units: mN\n" + lines("U_x (nm),F (N)", X, X + 1.0))
    profile = read_profile("# XUnit: um\n# ZUnit: nm\n" + lines("x,z", 0.005 * np.arange(64), wave()))
    assert profile.length == pytest.approx(320.0) and np.ptp(profile.z) == pytest.approx(6.0)


def test_a_distance_of_rows_and_a_factor_that_the_file_says_are_named():
    with pytest.raises(DataError, match=r"'# Pitch: 0\.5 um' names um"):
        read_profile("# Pitch: 0.5 um\nHeight (nm)\n" + "\n".join(map(str, wave())))
    profile = read_profile("# z factor: 0.001\n" + lines("x (nm),z (nm)", 5 * np.arange(64), wave()))
    assert "Not used: the file says '# z factor: 0.001'." in profile.notes


def test_of_columns_in_volt_and_in_units_those_in_units_are_meant():
    load = np.power(TRIANGLE, 1.5)
    columns = TRIANGLE, load, 0.1 * X, [0.1] * 40, [0.4] * 40
    curve = read(lines("Depth (nm),Load (uN),Time (s),Depth (V),Load (V)", *columns))
    assert curve.kind == "load" and curve.units == {"delta": "nm", "L": "N"}
    assert curve.segments[0].values["L"].max() == pytest.approx(1e-6 * load.max())


def test_a_row_of_separators_above_units_is_no_row_and_a_last_column_of_remarks_may_be_left_out():
    text = "Point,delta,L\n,,\n,[nm],[N]\n" + lines("", X, X, X**1.5).lstrip()
    assert read(text).segments[0].x.size == 40
    assert read("U_x (nm)\tF (N/m)\tComment\n" + "\n".join(f"{k}\t{k + 1}" for k in X)).segments[0].x.size == 40


def test_a_quantity_that_is_zero_throughout_is_left_out_and_the_curve_itself_refused():
    curve = read(lines("U_x (nm),F (N/m),L (N/m),A (nm)", X, X + 1.0, 0 * X, 0 * X))
    assert set(curve.values) == {"F_bar"} and curve.notes[-2:] == tuple(
        f"{q} is 0 at every point: not used." for q in "LA"
    )
    with pytest.raises(DataError, match="L is 0 at every point"):
        read(lines("delta (nm),L (N)", X, 0 * X))
    bars = Measurement.of(X * 1.0, {"F_bar": X + 1.0, "L_bar": 0.0 * X})
    assert set(bars.values) == {"F_bar"} and bars.notes == ("L_bar is 0 at every point: not used.",)


def test_the_table_of_a_retraction_is_read_without_a_question(tmp_path):
    """Its load falls with the indentation where the surfaces attract: no sign is asked of a run's own columns."""
    result = simulate(Scene(path="unload", du_x=0.5, du_z=0.5))
    result.save(tmp_path / "run.csv")
    compared = read_measurement(result.scene, tmp_path / "run.csv").residuals(result)
    assert compared.rms["L"] < 1e-6
