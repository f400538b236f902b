"""What an argument says of a column, against what the file says: used, refused with both, or named in a note."""

import numpy as np
import pytest

from solver import DataError, Scene, read_measurement, read_profile

X = np.linspace(0.0, 640.0, 257)
Z = 4.0 * np.cos(4.0 * np.pi * X / 640.0)


def curve(heading, **how):
    """A friction curve, 2 per nm, below this heading."""
    return read_measurement(Scene(), "\n".join([heading, *(f"{k},{2 * k}" for k in range(1, 41))]), **how)


def profile(heading, **how):
    """A profile of 640 by 8 nm below this heading."""
    return read_profile("\n".join([heading, *(f"{x:.9g},{z:.9g}" for x, z in zip(X, Z, strict=True))]), **how)


CONTRADICTED = [  # (function, heading, arguments, what the refusal says)
    (curve, "U_x (nm),F (N)", {"units": {"F": "N/m"}}, "'N/m', but the file names N; leave it out, or say what"),
    (curve, "U_x (nm),F (N/m)", {"units": {"F": "N"}}, "units['F'] = 'N', but the file names N/m; leave it out"),
    (curve, "U_x (nm),F (N)", {"units": {"F": "F_s"}}, "units['F'] = 'F_s', but the file names N"),
    (curve, "U_x (nm),F (N)", {"units": {"F": "2 N"}}, "units['F'] = '2 N', but the file names N; leave it out"),
    (curve, "U_x (nm),F (V)", {"units": {"F": "N"}}, 'names V; say what 1 V is, as "10 N"'),
    (curve, "U_x (s),F (N)", {"units": {"U_x": "nm"}}, 'names s; say what 1 s is, as "10 nm"'),
    (curve, "U_x (nm),A (nm)", {"units": {"A": "A_0"}}, "units['A'] = 'A_0', but the file names nm; leave it out"),
    (curve, "U_x (nm),F_bar (N/m)", {}, "F_bar has no unit, and N/m is one; give the column as F; call"),
    (curve, "U_x (nm),Force (N)", {"columns": {"F_bar": 2}}, "and N is one; give the column as F; call"),
    (curve, "U_x (nm),F_bar", {"units": {"F": "N"}}, "F_bar has no unit, and N is one"),
    (curve, "U_x (nm),F (N/m)", {"force": 1e3}, "force = 1000, but F is in N/m; leave force out"),
    (curve, "U_x (nm),F", {"units": {"F": "mN"}, "force": 1e3}, "force = 1000, but F is in mN; leave force out"),
    (curve, "U_x (nm),L (N)", {"kind": "load"}, "which column is what is not certain; needed: delta and L of a load"),
    (curve, "U_x (nm),F (N/m)", {"columns": {"F": "F [N]"}}, "columns['F'] = 'F [N]' is none of them; give a name"),
    (curve, "separation (nm),L (N)", {"deflection": 2.0, "sign": {"L": 1}}, "a separation has no lever in it"),
    (profile, "x (nm),z (nm)", {"unit": "um"}, "unit = 'um', but the file names nm; leave it out"),
    (profile, "x (nm),z (V)", {"units": {"z": "nm"}}, 'names V; say what 1 V is, as "10 nm"'),
    (profile, "x (nm),z (V)", {"unit": "nm"}, 'say what 1 V is, as units={"z": "10 nm"}'),
    (curve, "U_x (nm),F_bar", {"units": {"F_bar": "N/m"}}, "F_bar has no unit, and N/m is one; leave it out, or give"),
    (curve, "time (s),Fx (N)", {"units": {"U_x": "um"}, "speed": 1.0}, "has 'U_x', and no column is that; there"),
    (curve, "U_x (nm),F (N)", {"units": {"A": "um"}}, "units has 'A', and no column is that; there are U_x, F; leave"),
    (curve, "delta (nm),L (N)", {"deflection": -1.0}, "allowed: above 0, N/m, of a load in N; leave it out, or give"),
    (profile, "X units: um\nx (nm),z (nm)", {}, "x in 'nm or um'; allowed units: nm"),
]  # fmt: skip


@pytest.mark.parametrize(("read", "heading", "how", "said"), CONTRADICTED)
def test_an_argument_that_contradicts_the_file_is_refused_with_both(read, heading, how, said):
    with pytest.raises(DataError) as refused:
        read(heading, **how)
    assert said in str(refused.value)


def test_a_number_of_a_unit_says_what_1_in_the_file_is():
    found = curve("U_x (nm),F (N)", units={"F": "10 N/m"})
    assert found.units["F"] == "N/m" and found.segments[0].values["F"][0] == pytest.approx(20.0)
    assert np.ptp(profile("x (nm),z (V)", units={"z": "0.5 nm"}).z) == pytest.approx(4.0)
    assert curve("U_x (s),F (N)", units={"U_x": "3 nm"}).segments[0].x[-1] == pytest.approx(120.0)


def test_a_word_that_is_no_unit_is_named_in_a_note_beside_the_unit_that_is_given():
    found = curve("U_x (nm),F (raw)", units={"F": "N/m"})
    assert "F is read as N/m; the file says raw." in found.notes
    assert "z as nm, where the file says raw2;" in profile("x (nm),z (raw2)", units={"z": "nm"}).notes[0]


def test_two_units_of_one_column_are_settled_by_an_argument():
    assert profile("X units: um\nx (nm),z (nm)", units={"x": "nm"}).length == pytest.approx(640.0)


def test_a_column_is_named_with_its_unit_as_well():
    assert curve("Way [nm],Pull (N)", columns={"U_x": "Way [nm]", "F": "pull (n)"}).kind == "friction"


def test_the_remedy_for_a_unit_of_both_columns_reads_the_file():
    found = profile("x (nm),z (V)", unit="nm", units={"z": "0.5 nm"})
    assert np.ptp(found.z) == pytest.approx(4.0) and found.length == pytest.approx(640.0)


@pytest.mark.parametrize("name", ["F_bar", 2])
def test_a_normalised_force_with_a_unit_is_read_as_the_force_it_is_given_as(name):
    found = curve("U_x (nm),F_bar (N/m)", columns={"F": name}, units={"F": "N/m"})
    assert found.units["F"] == "N/m" and found.segments[0].values["F"][0] == pytest.approx(2.0)


def test_a_unit_by_another_prefix_is_the_same_unit():
    text = "U_x (nm),F (uN)"
    given, own = (curve(text, **how).segments[0].values["F"] for how in ({"units": {"F": "1000 nN"}}, {}))
    assert given == pytest.approx(own)


CALLED = [  # (function, heading, arguments, the end of the call, what fills its dots)
    (profile, "Lateral units: um\nx (nm),z (nm)", {}, {"units": {"x": ..., "z": "nm"}}, {"x": "nm"}),
    (curve, "U_x (nm),F_bar (N/m)", {}, {"columns": {"F": "F_bar"}}, {}),
    (curve, "U_x (nm),F (N/m)", {"columns": {"F": "F [N]"}}, {"columns": {"F": ...}}, {"F": "F"}),
    (profile, "x (nm),z (nm)", {"columns": {"x": 1, "z": "depth"}}, {"columns": {"x": 1, "z": ...}}, {"z": "z"}),
]


@pytest.mark.parametrize(("read", "heading", "how", "call", "answers"), CALLED)
def test_a_refusal_of_columns_ends_in_a_call_that_reads_the_file(read, heading, how, call, answers):
    with pytest.raises(DataError, match=r"; call read_\w+\(.*\)$") as refused:
        read(heading, **how)
    assert refused.value.call == call
    for values in call.values():
        values.update(answers)
    read(heading, **call)


def test_a_normalised_area_in_percent_is_read_once_its_column_is_given_as_an_area():
    heading = "U_x (nm),A_bar (%)"
    with pytest.raises(DataError, match=r"and % is one; give the column as A; call"):
        curve(heading)
    assert curve(heading, columns={"A": "A_bar"}, units={"A": "0.01 A_0"}).units["A"] == "A_0"


def approach(names, above="# spring constant: 0.5 N/m"):
    """A load of 2 nN per nm below a line that names the lever."""
    return "\n".join([above, names, *(f"{100 - x},{2 * x}" for x in range(41))])


def test_a_stiffness_that_the_file_names_is_in_the_call_and_a_note_and_another_one_is_named_beside_it():
    with pytest.raises(DataError, match=r'sign=\{"delta": -1\}, deflection=0.5\)$'):
        read_measurement(Scene(), approach("Z (nm),Fn (nN)"))
    found = read_measurement(Scene(), approach("height (nm),Fn (nN)"))
    assert any("spring constant = 0.5 N/m" in note and "deflection=0.5 takes it off" in note for note in found.notes)
    found = read_measurement(Scene(), approach("height (nm),Fn (nN)"), deflection=4.0)
    assert "deflection = 4 N/m, as given; the file says spring constant = 0.5 N/m." in found.notes
    assert not read_measurement(Scene(), approach("separation (nm),Fn (nN)")).notes


@pytest.mark.parametrize("columns", [{"F_bar": 2}, {"U_x": 1, "F_bar": 2}])
def test_the_call_for_a_force_that_was_given_as_one_without_a_unit_reads_the_file(columns):
    with pytest.raises(DataError) as refused:
        curve("U_x (nm),Force (N/m)", columns=columns)
    assert curve("U_x (nm),Force (N/m)", **refused.value.call).unit == pytest.approx(Scene().width * Scene().E)


def test_the_call_keeps_a_column_that_the_user_has_excluded():
    """Rows are then counted; with the column x that he does not want the profile is twice as long."""
    text = "\n".join(["x (foo),z", *(f"{2 * k},{z:.9g}" for k, z in enumerate(Z))])
    with pytest.raises(DataError) as refused:
        read_profile(text, columns={"x": None, "z": 2}, units={"x": "2.5 nm"})
    call = refused.value.call
    assert call["columns"] == {"x": None, "z": 2}
    assert read_profile(text, **call | {"units": {"x": "2.5 nm", "z": "nm"}}).length == pytest.approx(640.0, rel=0.01)
