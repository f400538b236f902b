"""Layouts that instruments and programs write: each is read right, or by the call that its refusal names."""

import json
import pickle
import re
from pathlib import Path

import numpy as np
import pytest

from solver import DataError, Scene, read_measurement, read_profile

ROOT = Path(__file__).parents[2]
X = np.linspace(0.0, 640.0, 257)  # nm
Z = 4.0 * np.cos(2.0 * np.pi * 2.0 * X / 640.0)  # nm
U = np.linspace(0.0, 300.0, 61)  # nm
F = 20.0 * np.tanh(U / 40.0) + 0.01 * np.sin(U)  # N/m, or N
DOWN = np.linspace(-10.0, 1.0, 60)  # delta, nm
LOAD = np.where(DOWN < 0.0, -0.5 * np.exp(DOWN), 20.0 * np.clip(DOWN, 0.0, None) ** 1.5 - 0.5)
DELTA, L = (np.append(y, y[::-1]) for y in (DOWN, LOAD))
COUNT, STEPS, TICKS = np.arange(X.size), np.arange(U.size), np.arange(DELTA.size)


def rows(*columns, sep=",", comma=False, end="", quoted=False):
    """Lines of columns of numbers or words; comma: decimal commas."""
    lines = []
    for row in zip(*columns, strict=True):
        cells = [cell if isinstance(cell, str) else f"{cell:.10g}" for cell in row]
        cells = [cell.replace(".", ",") for cell in cells] if comma else cells
        lines.append(sep.join(f'"{cell}"' for cell in cells) if quoted else sep.join(cells))
    return "\n".join(line + end for line in lines)


def beside_each_other(metadata, *columns):
    """Rows whose first two columns have words at the top alone."""
    keys = [*metadata, *[("", "")] * (len(columns[0]) - len(metadata))]
    return "\n".join(f"{a},{b},,{x:.9g},{y:.9g}," for (a, b), x, y in zip(keys, *columns, strict=True))


def jpk(segment, delta, load, columns="height vDeflection"):
    names = f'# columns: {columns}\n# fancyNames: "Height" "Vertical Deflection"\n# units: m N\n'
    return f"# segment: {segment}\n{names}{rows(1e-6 - delta * 1e-9, load * 1e-9, sep=' ')}\n\n"


def profile(found):
    assert found.length == pytest.approx(640.0) and np.ptp(found.z) == pytest.approx(8.0, rel=1e-3)


def friction(scale=1.0):
    """Checks a stroke or a loop of F, times a scale."""

    def check(found):
        assert found.kind in ("friction", "loop")
        segment = found.segments[0]
        assert np.ptp(segment.x) == pytest.approx(300.0) and segment.x.size == U.size
        assert segment.values["F"] == pytest.approx(scale * F, rel=1e-6, abs=1e-6 * scale)

    return check


def load(scale):
    """Checks an approach of LOAD, times a scale."""

    def check(found):
        assert found.kind == "load"
        segment = found.segments[0]
        assert segment.x - segment.x[0] == pytest.approx(DOWN - DOWN[0], abs=1e-6)
        assert segment.values["L"] == pytest.approx(scale * LOAD, rel=1e-6, abs=1e-7 * scale)

    return check


MATRIX = [Z * (k + 1) / 3 for k in range(5)]
WHOLE = {"columns": {"x": None, "z": 3}, "units": {"x": "2.5 nm", "z": "nm"}}
BY_NUMBER = {"columns": {"x": 1, "z": 2}}
FIRST = {"columns": {"U_x": 1, "F": 2}}
VOLTS = {"columns": {"time": 1, "F": 2}, "units": {"time": "s", "F": "10 N"}, "speed": 1000.0}
PROFILES = {  # name: (content, what fills the dots of a call)
    "a stylus without units": (f"Length,0.64 um\nLateral,Total Profile,\n{rows(X, Z, end=',')}",
                               {"columns": {"x": "Lateral", "z": 2}, "units": {"x": "nm", "z": "nm"}}),
    "names in German": (f"Messung 3;2.3.24\nWeg [µm];Höhe [nm]\n{rows(X / 1e3, Z, sep=';', comma=True)}", BY_NUMBER),
    "an older encoding": (f"Weg [µm];Höhe [µm]\n{rows(X / 1e3, Z / 1e3, sep=';')}".encode("cp1252"), BY_NUMBER),
    "an index without a name": (f",x (um),z (nm)\n{rows(COUNT, X / 1e3, Z)}", {}),
    "an index that the heading lacks": (f"x (um) z (nm)\n{rows(COUNT, X / 1e3, Z, sep=' ')}",
                                        {"columns": {"x": 2, "z": 3}, "units": {"x": "um", "z": "nm"}}),
    "an index before a named distance": (f"Index,Height (um),Distance (um)\n{rows(COUNT, Z / 1e3, X / 1e3)}", {}),
    "units in brackets below": (f"Profile 1\nx y\n[m] [m]\n{rows(X * 1e-9, Z * 1e-9, sep=' ')}", {}),
    "units below, comments below these": (f"Distance\tHeight\num\tnm\nB 1\tB 1\n{rows(X / 1e3, Z, sep=chr(9))}", {}),
    "units after a blank line": (f"Distance\tHeight\n\num\tnm\n\n{rows(X / 1e3, Z, sep=chr(9))}", {}),
    "a unit of each axis above": (f"X Units,mm\nZ Units,um\nX,Z\n{rows(X / 1e6, Z / 1e3)}", {}),
    "a unit of one axis above": (f"Horizontal units: um\nx,z\n{rows(X / 1e3, Z)}", {"units": {"z": "nm"}}),
    "two units of one column": (f"x (um),z (nm)\nnm,nm\n{rows(X, Z)}", {"units": {"x": "nm"}}),
    "two profiles side by side": (f"A;;B;\nx [nm];y [nm];x [nm];y [nm]\n{rows(X, Z, X, 0.5 * Z, sep=';')}", BY_NUMBER),
    "two profiles, one below the other": (f"x (nm),z (nm)\n{rows(X, Z)}\n\nB\nx (nm),z (nm)\n{rows(X, 2 * Z)}",
                                          {"channel": 1}),
    "a channel that is no map": (f"# Channel: Z\n# X[nm]  Z[nm]\n{rows(X, Z, sep='  ')}", {}),
    "numbers in quotes": (f'"Distance [um]","Height [um]"\n{rows(X / 1e3, Z / 1e3, quoted=True)}', {}),
    "commas in quoted names": (f'"Way, lateral (um)","Height, raw (nm)"\n{rows(X / 1e3, Z)}', BY_NUMBER),
    "a heading behind %": (f"% Model: test\n% x (nm), z (nm)\n{rows(X, Z)}", {}),
    "a heading behind //": (f"// x (nm); z (nm)\n{rows(X, Z, sep=';')}", {}),
    "UTF-16, tabs, CRLF": (f"x (um)\tz (nm)\n{rows(X / 1e3, Z, sep=chr(9))}\n".replace("\n", "\r\n").encode("utf-16"),
                           {}),
    "a spreadsheet": (f"\ufeffsep=;\nx / µm;z / nm;;\n{rows(X / 1e3, Z, sep=';', comma=True, end=';;')}", {}),
    "decimal commas between blanks": (f"x (nm) z (nm)\n{rows(X, Z, sep=' ', comma=True)}", {}),
    "exponents with commas": (f"x [m];z [m]\n{rows(X * 1e-9, Z * 1e-9, sep=';', comma=True)}".replace("e", "E"), {}),
    "the sign minus": (f"x (nm)\tz (nm)\n{rows(X, Z, sep=chr(9))}".replace("-", "\N{MINUS SIGN}"), {}),
    "text below": (f"x (nm),z (nm)\n{rows(X, Z)}\nEnd of data\nRa = 2 nm\n", {}),
    "a clock": (f"Clock,x (um),z (nm)\n{rows([f'12:00:{k % 60:02d}' for k in COUNT], X / 1e3, Z)}", {}),
    "a unit that is not known": (f"x (in),z (uin)\n{rows(X / 25.4e6, Z / 25.4)}", {"units": {"z": "25.4 nm"}}),
    "a slope beside a position": (f"# x-position [um]; y-slope [urad]\n{rows(X / 1e3, Z, sep=';')}",
                                  {"columns": {"z": 2}, "units": {"z": "nm"}}),
    "a torque beside a position": (f"x (um),y (Nm)\n{rows(X / 1e3, Z)}", {"units": {"z": "1 nm"}}),
    "x, y and another quantity": (f"X (um),Y (um),Intensity (V)\n{rows(X / 1e3, 0 * X, Z)}",
                                  {"columns": {"z": 3}, "units": {"z": "1 nm"}}),
    "x, y, z of one line": (f"X (um)  Y (um)  Z (nm)\n{rows(X / 1e3, 0 * X + 5, Z, sep='  ')}", {}),
    "x, y, z without names": (rows(X, 0.001 * X + 100.0, Z, sep=" "),
                              {"columns": {"x": 1, "z": 3}, "units": {"x": "nm", "z": "nm"}}),
    "two channels of heights": (f"x (nm)\tHeight Trace (nm)\tHeight Retrace (nm)\n{rows(X, Z, Z, sep=chr(9))}",
                                BY_NUMBER),
    "numbers of pixels": (f"pixel,height (nm)\n{rows(COUNT, Z)}",
                          {"columns": {"x": "pixel"}, "units": {"x": "2.5 nm", "z": "nm"}}),
    "heights alone": (f"Spacing (nm): 2.5\nHeight (nm)\n{rows(Z)}", {"units": {"x": "2.5 nm"}}),
    "a map in text": (rows(*MATRIX, sep="\t"), WHOLE),
    "a map with German names": (f"# Kanal: Hoehe\n# Breite: 0.64 um\n{rows(*MATRIX, sep=chr(9))}", WHOLE),
    "millimetres and micrometres without names": (rows(X / 1e6, Z / 1e3, sep="\t"), {"units": {"x": "mm", "z": "um"}}),
}  # fmt: skip
CURVES = {  # name: (content, check, what fills the dots of a call, or the roles in place of those it proposes)
    "a label before the names": (f"# columns: delta L sd\n{rows(DELTA, L, 0 * L, sep=' ')}", load(1.0),
                                 {"units": {"delta": "nm", "L": "N/m"}}),
    "a tensile test": (f'"Time","Extension","Load"\n"(s)","(mm)","(N)"\n{rows(TICKS, DELTA / 1e6, L, quoted=True)}',
                       load(1.0), {"kind": "load"}),
    "a tensile test in German": (f"Standardweg;Standardkraft\nmm;N\n{rows(U / 1e6, F, sep=';', comma=True)}",
                                 friction(), FIRST),
    "a press": (f"Displacement (mm),Force (N)\n{rows(DELTA / 1e6, L)}", load(1.0), {"kind": "load"}),
    "a press that counts downwards": (f"Crosshead (mm),Force (N)\n{rows(DELTA / -1e6, -L)}", load(1.0),
                                      {"kind": "load", "sign": {"delta": -1, "L": -1}}),
    "pounds over inches": (f"Crosshead (in),Load (lbf)\n{rows(DELTA / 25.4e6, L / 4.4482216152605)}", load(1.0),
                           {"kind": "load"}),
    "an indenter": (f"Points = 120\n\nDepth (nm)\tLoad (µN)\tTime (s)\n{rows(DELTA, L, TICKS, sep=chr(9))}",
                    load(1e-6), {}),
    "an indenter, units below": (f"Way Into Surface\tLoad On Sample\nnm\tmN\n{rows(DELTA, L, sep=chr(9))}", load(1e-3),
                                 {"columns": {"delta": 1, "L": 2}}),
    "heading on line 4": (f"Machine 7\nrun 3\n\nStation 1 Way (mm)\tStation 1 F (N)\n{rows(U / 1e6, F, sep=chr(9))}",
                          friction(), FIRST),
    "an oscilloscope": (f"Model,7\nSample Interval,1e-3\n\nTIME,CH1\n{rows(U / 1e3, F / 10)}", friction(), VOLTS),
    "an oscilloscope, units below": (f"Zeit;Kanal A\n(ms);(V)\n\n{rows(U, F / 10, sep=';', comma=True)}", friction(),
                                     VOLTS | {"units": {"time": "ms", "F": "10 N"}}),
    "an oscilloscope, units as names": (f"x-axis,1,2\nsecond,Volt,Volt\n{rows(U / 1e3, F / 10, F)}", friction(), VOLTS),
    "metadata beside the first rows": (beside_each_other([("Length", "61"), ("Units", "V")], U / 1e3, F / 10),
                                       friction(), VOLTS | {"columns": {"time": 4, "F": 5}}),
    "numbers of samples": (f"X,CH1,Start,Increment,\nSequence,Volt,0.0,5e-3,\n{rows(STEPS, F / 10, end=',,,')}",
                           friction(), VOLTS | {"units": {"time": "0.005 s", "F": "10 N"}}),
    "a tribometer with two forces": ("Fx,Fz,Z,V1,V2,T,Ff\nN,N,mm,mm/sec,mm/sec,sec,N\n\n"
                                     + rows(F, 0 * F + 2, 0 * F, 0 * F, 0 * F, U, F / 2), friction(),
                                     {"columns": {"time": "T", "F": "Fx"}, "speed": 1.0}),
    "two forces": (f"Depth (nm),Force (N),Load (N)\n{rows(DELTA, 0 * L, L)}", load(1.0), {"columns": {"L": "Load"}}),
    "a force and one of an axis": (f"U_x (nm),F (N),Fy (N)\n{rows(U, F, 0 * F)}", friction(), {"columns": {"F": "F"}}),
    "forces along two axes": (f"U_x (nm),Fx (N),Fy (N)\n{rows(U, 0 * F, F)}", friction(), {"columns": {"F": "Fy"}}),
    "a load counted downwards": (f"time (s),Fx (N),Fz (N)\n{rows(U, F, 0 * F - 2)}", friction(),
                                 {"sign": {"L": -1}, "speed": 1.0}),
    "a coefficient over metres": (f"Distance (m),COF\n{rows(U / 1e9, F)}", friction(),
                                  {"columns": {"F": 2}, "units": {"F": "N"}}),
    "a position and a force": (f"Position (mm)\tForce (N)\n{rows(U / 1e6, F, sep=chr(9))}", friction(),
                               {"kind": "friction"}),
    "a stress over a strain": (f"Strain (%),Stress (MPa)\n{rows(U, F)}", friction(),
                               FIRST | {"units": {"U_x": "1 nm", "F": "1 N"}}),
    "trace and retrace": (f"U_x (nm),F trace (nN),F retrace (nN)\n{rows(U, F, F - 10)}", friction(1e-9),
                          {"columns": {"F": 2}}),
    "curves side by side": (f"U_x (nm);F (N/m);U_x (nm);F (N/m)\n{rows(U, F, U, 2 * F, sep=';')}", friction(), FIRST),
    "pages with a heading each": (f"U_x (nm),F (N)\n{rows(U[:30], F[:30])}\n\nU_x (nm),F (N)\n{rows(U[30:], F[30:])}",
                                  friction(), {"channel": "all"}),
    "a text export of segments": (jpk("extend", DOWN, LOAD) + jpk("retract", DOWN[::-1], LOAD[::-1]), load(1e-9), {}),
    "segments of other columns": (jpk("extend", DOWN, LOAD) + jpk("retract", LOAD, DOWN, "vDeflection height"),
                                  load(1e-9), {"channel": 1}),
    "names with units glued on": (f"Ramp_Ex_nm\tDefl_pN_Ex\n{rows(DOWN, 1e3 * LOAD, sep=chr(9))}", load(1e-9),
                                  {"columns": {"delta": 1, "L": 2}, "units": {"delta": "nm", "L": "pN"}}),
    "a height without a name": (rows(-DELTA, L, sep="\t"), load(1e-9),
                                {"columns": {"delta": 1, "L": 2}, "units": {"delta": "nm", "L": "nN"},
                                 "sign": {"delta": -1, "L": 1}}),
    "a height that grows": (f"Height (nm),Force (nN)\n{rows(DELTA, L)}", load(1e-9), {"sign": {"delta": 1, "L": 1}}),
    "a header of a program": (f"LabX\nX_Dimension\tTime\n***End***\nX_Value\tForce\tNote\n{rows(U, F, sep=chr(9))}",
                              friction(), FIRST | {"units": {"U_x": "nm", "F": "N"}}),
    "words among the columns": (f"Phase;U_x (nm);F (N/m)\n{rows(['forth'] * U.size, U, F, sep=';')}", friction(), {}),
    "title rows": (f"Series A;;\nPeter;3.4.2024;\nU_x;F;\nnm;N/m;\n{rows(U, F, sep=';', comma=True, end=';')}",
                   friction(), {}),
    "numbers only": (rows(U, F, sep=" "), friction(), FIRST | {"units": {"U_x": "nm", "F": "N/m"}}),
}  # fmt: skip


def read_as_asked(read, content, answers):
    """What a file is read as once the dots of the calls that its refusals name are filled in."""
    given, calls = {}, []
    for _ in range(3):
        try:
            return read(content, **given)
        except DataError as refused:
            assert str(refused).rpartition("; call read_")[2], refused
            assert refused.call and refused.call not in calls, refused
            calls.append(refused.call)
            given = {name: filled(name, value, answers, str(refused)) for name, value in refused.call.items()}
            if not answers.get("columns", {}).keys() <= given.get("columns", answers.get("columns", {})).keys():
                assert "needed: " in str(refused)  # it lists the other roles
                given = answers
    raise AssertionError(f"refused three times: {calls}")


def filled(name, value, answers, message):
    """An argument of a call; what it leaves open is taken from the answers."""
    answer = answers.get(name, {})
    if value is ...:
        assert name in answers, message
        return answer
    if not isinstance(value, dict):
        return value
    assert "needed: " in message or all(role in answer for role, each in value.items() if each is ...), message
    return {role: answer.get(role) if each is ... else each for role, each in value.items()}


@pytest.mark.parametrize("layout", PROFILES)
def test_a_profile_is_read_right_or_by_the_call_that_its_refusal_names(layout):
    content, answers = PROFILES[layout]
    profile(read_as_asked(read_profile, content, answers))


@pytest.mark.parametrize("layout", CURVES)
def test_a_curve_is_read_right_or_by_the_call_that_its_refusal_names(layout):
    content, check, answers = CURVES[layout]
    check(read_as_asked(lambda text, **given: read_measurement(Scene(), text, **given), content, answers))


@pytest.mark.parametrize(
    ("beginning", "what"),
    [
        (b"\x89PNG\r\n\x1a\n", "a picture, whose heights are lost; export them"),
        (b"\xff\xd8\xff\xe0", "a picture"),
        (b"%PDF-1.7\n", "a PDF; export its numbers"),
        (b"\x1f\x8b\x08\0", "an archive; unpack it"),
        (b"\x7fELF\2\1", "a program; choose a file of a measurement"),
        (b"\0\0", "an empty file"),
    ],
)
def test_what_is_no_measurement_is_named(beginning, what):
    content = beginning + bytes(1000)
    for read in (read_profile, lambda content: read_measurement(Scene(), content)):
        with pytest.raises(DataError, match=f"^this is {what}"):
            read(content)


def test_the_table_of_a_refusal_can_be_sent_as_json_and_the_refusal_to_another_process():
    text = f"Machine 7\nZeit;Weg [mm];Stufe\n{rows(U, U / 1e6, ['a'] * U.size, sep=';')}"
    with pytest.raises(DataError) as refused:
        read_profile(text)
    again = pickle.loads(pickle.dumps(refused.value))
    assert (str(again), again.call) == (str(refused.value), {"columns": {"x": ..., "z": ...}})
    table = json.loads(json.dumps(again.table.to_json(), allow_nan=False))
    assert table["columns"][1:] == [
        {"name": "Weg", "unit": "mm", "low": 0.0, "high": 3e-4},
        {"name": "Stufe", "unit": None, "low": None, "high": None},
    ]
    assert table["above"][0] == "Machine 7" and table["rows"] == U.size and table["first"][0] == ["0", "0", "a"]


def test_commas_that_may_separate_thousands_are_refused():
    text = "U_x (nm);F (N/m)\n" + "\n".join(f"{1000 + 5 * k:,};{k}" for k in range(40))
    with pytest.raises(DataError, match=r"^line 2: commas with three digits behind each may separate thousands"):
        read_measurement(Scene(), text)


BEGINS = {  # heading of an example in docs/files.md: the columns below it
    "Weg [µm];Höhe [nm]": (X / 1e3, Z),
    "Height (nm)": (Z,),
    "Position (um),Force (mN)": (np.append(U, U[::-1]) / 1e3, np.append(F, F[::-1] - 10.0)),
    "Zeit (ms);Kanal A (V)": (U, F / 10.0),
    "Z-Sense (nm),T-B (V)": (-DOWN, LOAD / 400.0),
    "Shear force (N),Area (mm2)": (F, 12.5 - F / 4.0),
}
EXAMPLES = re.findall(
    r"^\| `([^`]*)`.* \| `(read_\w+\(.*\))` \|$", (ROOT / "docs/files.md").read_text(encoding="utf-8"), re.M
)


@pytest.mark.parametrize(("heading", "call"), EXAMPLES)
def test_the_examples_of_the_documentation_are_refused_plainly_and_read_by_their_call(heading, call):
    text = f"{heading}\n{rows(*BEGINS[heading], sep=';' if ';' in heading else ',')}"
    names = {"file": text, "scene": Scene(), "read_profile": read_profile, "read_measurement": read_measurement}
    with pytest.raises(DataError, match="; call read_"):
        eval(re.sub(r"\bfile\b.*", "file)", call), names)
    found = eval(call, names)
    assert getattr(found, "length", 640.0) == pytest.approx(640.0)
    assert getattr(found, "kind", None) in (None, "loop", "load", "friction", "area over force")


def test_the_documentation_has_an_example_of_each_kind():
    assert {heading for heading, _ in EXAMPLES} == BEGINS.keys()
