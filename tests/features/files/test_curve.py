"""A measured curve over the run on screen, without a browser: what is read, asked, compared, and kept for how long."""

import numpy as np
import pytest

from app.features.files.comparing import COLUMNS, LAID, compare, shown
from app.features.files.feature import kept
from app.features.files.tasks import Chosen, look
from solver import Scene, simulate
from solver.measured.curves import read_measurement

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
    seen, curve = look(Scene(), text(heading, x, y), Chosen())
    assert not seen["why"] and (curve.kind, curve.over) == (kind, over)
    drawn = shown(curve)
    assert np.allclose(np.concatenate([segment["x"] for segment in drawn["segments"]]), x, atol=1e-5)
    assert set(drawn["units"].values()) <= {"nm", "N/m"} and f"{kind.split()[0]}" in seen["says"]


def test_a_long_curve_is_thinned_out_to_what_a_page_draws():
    x = np.linspace(0.0, 30.0, 9001)
    seen, curve = look(Scene(), text("U_x (nm),F (N/m)", x, np.sin(x)), Chosen())
    assert "9,001 points" in seen["says"] and len(shown(curve)["segments"][0]["x"]) <= LAID + 1


def test_what_a_table_tells_is_filled_in_and_what_it_does_not_tell_is_asked():
    rows = text("Station,Piezo,Signal", U_X, 3.0 * U_X).replace(b"\n", b"\n7,", 31).replace(b"7,", b"7,", 1)
    seen, curve = look(Scene(), rows, Chosen())
    assert curve is None and seen["kind"] == "" and "kind of data" in seen["why"]
    assert [column["name"] for column in seen["table"]["columns"]] == ["Station", "Piezo", "Signal"]
    assert seen["table"]["rows"] == 31
    seen, curve = look(Scene(), rows, Chosen(kind="load"))
    assert curve is None and seen["columns"] == {"delta": 1} and "column of L" in seen["why"]
    chosen = {"kind": "load", "columns": {"delta": 1, "L": 2}}
    seen, curve = look(Scene(), rows, Chosen(**chosen, units={"delta": "nm"}))
    assert curve is None and "L has no unit" in seen["why"] and seen["units"]["delta"] == "nm"
    chosen["units"] = {"delta": "nm", "L": "0.5 nN"}
    seen, curve = look(Scene(), rows, Chosen(**chosen))
    assert curve is None and seen["asked"] == ["delta"] and "grow (1) or fall (-1)" in seen["why"]
    seen, curve = look(Scene(), rows, Chosen(**chosen, sign={"delta": 1}))
    assert not seen["why"] and curve.segments[0].values["L"][-1] == pytest.approx(9e-9)
    assert list(seen["fields"]) == ["deflection"]


def jpk(key, name="height"):
    """An approach as a program of an AFM exports it, with a spring of 0.5 N/m."""
    head = f"# {key}\n# segment: extend\n# columns: {name} vDeflection\n# units: m N\n"
    return (head + "\n".join(f"{1e-6 - 1e-9 * x:.6e} {1e-9 * x:.6e}" for x in range(31))).encode()


SPRINGS = (
    "springConstant: 0.5 N/m",
    "Spring Constant (N/m): 0.5",
    "spring constant = 500 pN/nm",
    "Force conversion: 500\n# Spring constant (N/m): 0.5",
    "Force control gain: 3\n# Spring constant (N/m): 0.5",
    "Spring constant calibrated: 12.03.2024\n# Spring constant (N/m): 0.5",
    "Spring constant: 45\n# Spring constant (N/m): 0.5",
    "springConstant: 2 V/nm\n# Stiffness of the lever: 0.5 N/m",
)


@pytest.mark.parametrize("key", SPRINGS)
def test_a_stiffness_of_the_lever_that_the_file_names_is_filled_in_and_can_be_removed(key):
    seen, curve = look(Scene(), jpk(key), Chosen())
    assert seen["deflection"] == 0.5 and curve.options["deflection"] == 0.5
    taken_off = curve.segments[0].x - curve.segments[0].x[0]
    assert taken_off[-1] == pytest.approx(30.0 - 1e9 * 30e-9 / 0.5)
    seen, curve = look(Scene(), jpk(key), Chosen(deflection=0))
    assert seen["deflection"] is None and np.ptp(curve.segments[0].x) == pytest.approx(30.0)
    assert look(Scene(), jpk(key), Chosen(deflection=2.0))[0]["deflection"] == 2.0


def test_the_lever_is_not_taken_off_a_separation_or_in_an_unknown_unit():
    for file in (jpk("springConstant: 0.5", "tipSampleSeparation"), jpk("springConstant: 0.5 V/nm")):
        seen, curve = look(Scene(), file, Chosen())
        assert seen["deflection"] is None and np.ptp(curve.segments[0].x) == pytest.approx(30.0)


@pytest.mark.parametrize("key", ["Sample stiffness: 3 N/m", "Frame stiffness: 5e6 N/m", "Force conversion: 500 N/m"])
def test_a_stiffness_of_something_else_is_no_lever(key):
    seen, curve = look(Scene(), jpk(key), Chosen())
    assert seen["deflection"] is None and "deflection" not in shown(curve)["notes"]


@pytest.mark.parametrize("key", ["springConstant: 45", "Spring constant calibrated: 2024"])
def test_a_stiffness_without_a_unit_is_named_and_not_filled_in(key):
    seen, curve = look(Scene(), jpk(key), Chosen())
    assert seen["deflection"] is None and f"The file says {key.replace(':', ' =')}" in shown(curve)["notes"]


def test_a_date_above_the_columns_is_no_stiffness():
    rows = "".join(f"{100 - k},{2e-9 * k}\n" for k in range(41))
    text = f"# Spring constant calibrated: 12.03.2024\nHeight (nm),Force (N)\n{rows}".encode()
    assert look(Scene(), text, Chosen(kind="load"))[1].kind == "load"


def test_a_refusal_names_a_unit_in_words_of_the_page():
    rows = text("U_x (nm),F (mN)", U_X, U_X)
    why = look(Scene(), rows, Chosen(units={"F": "N/m"}))[0]["why"]
    assert why == "the unit of F = 'N/m', but the file names mN; leave it out, or say what 1 mN is, as \"10 N/m\""


def test_a_normalised_force_with_a_unit_is_read_as_a_force_once_its_column_is_chosen():
    rows = text("U_x (nm),F_bar (N/m)", U_X, U_X)
    assert look(Scene(), rows, Chosen())[0]["why"].endswith("give the column as F")
    assert look(Scene(), rows, Chosen(columns={"U_x": 0, "F": 1}))[1].units["F"] == "N/m"


def test_friction_over_time_asks_for_the_speed_and_uses_it():
    rows = text("time (s),friction (N/m)", U_X, U_X)
    seen, curve = look(Scene(), rows, Chosen())
    assert curve is None and list(seen["fields"]) == ["speed"] and "speed" in seen["why"]
    _, curve = look(Scene(), rows, Chosen(speed=2.0))
    assert curve.segments[0].x[-1] == pytest.approx(12.0)


def test_a_loop_that_is_read_as_one_pull_names_the_kind_to_choose():
    loop = text(*AXES["loop"][:3])
    seen, curve = look(Scene(), loop, Chosen(kind="friction"))
    assert curve is None and "to and fro" in seen["why"]
    assert seen["why"].endswith("choose the kind 'friction loop, forth and back'")
    assert look(Scene(), loop, Chosen(kind="loop"))[1].kind == "loop"


def test_tables_of_one_file_are_offered_and_the_chosen_one_is_read():
    both = b"\n\n".join([FRICTION, text("U_x (nm),F (N/m)", U_X, 5.0 * U_X)])
    seen, curve = look(Scene(), both, Chosen())
    named = {"1": "from line 2", "2": "from line 35", "all": "all"}
    assert curve is None and seen["channels"] == named
    _, curve = look(Scene(), both, Chosen(channel="2"))
    assert curve.segments[0].values["F"][-1] == pytest.approx(30.0)


def test_pages_of_one_table_are_read_as_one():
    pages = b"\n\n".join([FRICTION, text("U_x (nm),F (N/m)", 6.0 + U_X, 3.0 * U_X)])
    seen, curve = look(Scene(), pages, Chosen(channel="all"))
    assert "62 points" in seen["says"] and curve.segments[0].x[-1] == pytest.approx(12.0)


def test_of_a_long_load_the_part_from_the_contact_on_is_proposed():
    """240 nm of contact after 3,140 nm without: what is used begins at most 5 % before it."""
    delta = np.linspace(-3140.0, 240.0, 3381)
    noise = 0.01 * np.random.default_rng(1).normal(size=delta.size)
    L = np.where(delta > 0.0, 0.01 * delta, 0.0) + np.where(abs(delta) < 5.0, -0.5, 0.0) + noise
    rows = text("indentation (nm),load (nN)", delta, L)
    seen, curve = look(Scene(), rows, Chosen())
    assert -252.0 < curve.segments[0].x[0] < 0.0 and curve.segments[0].x[-1] == 240.0
    assert "3,380 nm" in seen["says"] and "nm of it used" in seen["says"]
    _, whole = look(Scene(), rows, Chosen(part=[0.0, 0.5]))
    assert whole.segments[0].x[-1] < -1400.0


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"", "an empty file"),
        (b"%PDF-1.7 \0", "this is a PDF"),
        (b"\x89PNG\r\n\x1a\n\0", "a picture"),
        (b"PK\x03\x04\0\0", "an archive without a known file"),
        (bytes(20_000_000), "an empty file"),
        (b"0" * 20_000_000, "allowed"),
        (b",".join([b"1"] * 500) + b"\n" + b",".join([b"2"] * 500), "500 columns; allowed: up to 100"),
        (text("U_x (nm),F (N/m)", 1e200 * U_X, U_X), "check the units"),
    ],
)
def test_a_file_that_is_no_measurement_is_refused_in_one_sentence(content, said):
    seen, found = look(Scene(), content, Chosen())
    assert found is None and said in seen["why"] and len(seen["why"]) < 250 and not seen["says"]


SCENE = Scene(nodes=256, width=625.0, radius=10.0, u_x_max=8.0)


@pytest.fixture(scope="module")
def run():
    return simulate(SCENE)


def sent(result):
    """What the page sends of a run."""
    names = list(dict.fromkeys(str(frame.stage) for frame in result.frames))
    rows = []
    for frame in result.frames:
        slip = [event for event in frame.slips if event.stage == frame.stage]
        at = [1.0, slip[0].load, slip[0].F_bar * SCENE.width * SCENE.E] if slip else [0.0, 0.0, 0.0]
        rows.append([names.index(str(frame.stage)), frame.U_x, frame.delta, frame.F, frame.L, frame.A, *at])
    content = np.array(rows, "<f4").T.tobytes()
    assert len(rows[0]) == len(COLUMNS)
    return content, tuple(names), SCENE.width * SCENE.E, SCENE.width


UNITS = {"N/m": 1.0, "w E": 1.0 / (SCENE.width * SCENE.E), "N": 2e-3}


@pytest.mark.parametrize("unit", UNITS)
def test_curve_and_run_are_apart_as_python_says_and_the_points_come_into_units_of_the_run(run, unit):
    frames = [frame for frame in run.frames if frame.stage == "shear"][::2]
    U_x, F = np.array([(frame.U_x, 1.1 * frame.F + 2.0) for frame in frames]).T
    heading = "U_x (nm),F_bar" if unit == "w E" else f"U_x (nm),F ({unit})"
    rows = "\n".join([heading, *(f"{a:.9g},{UNITS[unit] * b:.9g}" for a, b in zip(U_x, F, strict=True))])
    _, curve = look(SCENE, rows.encode(), Chosen())
    found = compare(curve, *sent(run))
    expected = read_measurement(SCENE, rows).residuals(run)
    assert found["rms"]["F"] == pytest.approx(
        expected.rms["F"], rel=1e-3, abs=1e-3 * UNITS[unit] if unit == "w E" else 1e-4
    )
    assert found["outside"] == expected.outside == 0 and found["points"] == len(frames)
    times, plus = found["set"]["F"]
    seen = times * curve.segments[0].values["F"] + plus
    wanted = (F - 2.0) / 1.1 if unit == "N" else F
    assert np.allclose(seen, wanted, rtol=1e-3, atol=0.1)


def test_a_curve_that_the_run_cannot_be_compared_with_says_both_ranges_or_the_path(run):
    _, load = look(SCENE, text("delta (nm),L (N)", np.r_[U_X, U_X[::-1]], np.r_[U_X, U_X[::-1]]), Chosen())
    assert compare(load, *sent(run))["path"] == "unload"
    x = np.linspace(0.0, 3380.0, 300)
    _, long = look(SCENE, text("U_x (nm),F (N)", 100.0 + x, x), Chosen())
    found = compare(long, *sent(run))
    assert found == {"why": "3,380 nm here, 8 nm in the run, so it is drawn in its own range"}
    _, turned = look(SCENE, text("U_x (nm),F (N)", U_X, -U_X), Chosen())
    assert "brings the forces nearest to the run" in compare(turned, *sent(run))["why"]


def test_what_is_no_run_is_not_compared():
    _, curve = look(SCENE, FRICTION, Chosen())
    for content, stages in (
        (b"12345", ("shear",)),
        (b"\0" * 36, ()),
        (b"\0" * 36, ("none",)),
        (b"\xff" * 36, ("shear",)),
    ):
        assert "did not arrive whole" in compare(curve, content, stages, 1.0, 1.0)["why"]


def dropped(page, content, **chosen):
    """What the page says about a file that a visitor uses, and the curve."""
    page.messages.clear()
    page.file(content.decode(), **chosen)
    page.run_scheduled(lambda: any("file" in message for message in page.messages))
    seen = next(message["file"] for message in page.messages if "file" in message)
    return seen, next((message for message in page.messages if message["kind"] == "laid"), None)


@pytest.mark.slow
def test_the_server_keeps_the_last_friction_curve_until_its_visitor_leaves(page):
    first = dropped(page, FRICTION)[1]["key"]
    assert kept(first) == (FRICTION, {})
    seen, laid = dropped(page, b"nothing")
    assert laid is None and seen["why"] and kept(first)
    second = dropped(page, FRICTION + b"\n7,1", kind="friction")[1]["key"]
    assert kept(first) is None and kept(second)[1] == {"kind": "friction"}
    assert not dropped(page, text(*AXES["load"][:3]))[1]["key"] and kept(second) is None
    page.session.close()


@pytest.mark.slow
def test_removing_the_curve_leaves_nothing_on_the_server(page):
    key = dropped(page, FRICTION)[1]["key"]
    page.order("forget")
    feature = page.session.features["files"]
    assert kept(key) is None and kept("") is None and not feature.content and feature.curve is None
