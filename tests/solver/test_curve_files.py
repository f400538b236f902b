"""Curves of every kind that instruments and runs write are read with their units and segments, or refused."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from solver import DataError, Scene, SceneError, fit, read_measurement, simulate
from solver.continuation.state import OutOfTime
from solver.measured import loop_fit
from solver.measured.loop_fit import POINTS, LoopModel
from solver.measured.measurement import Measurement, turns_of
from solver.measured.stroke_fit import uncertainty

SMALL = Scene(nodes=64, width=160.0, radius=0.6, delta_bar=0.1, u_x_max=8.0, du_x=0.2, du_z=0.5, E=30.0)
NOISE = 0.01  # of the largest force
DOWN = np.linspace(-10.0, 1.0, 60)  # delta, nm
LOAD = np.where(DOWN < 0.0, -0.5 * np.exp(DOWN), 20.0 * np.clip(DOWN, 0.0, None) ** 1.5 - 0.5)  # N/m


def table(heading, *columns, above="", separator=","):
    """The text of a file with these columns."""
    rows = (separator.join(f"{number:.9g}" for number in row) for row in zip(*columns, strict=True))
    return "\n".join([*above.splitlines(), heading, *rows])


def there_and_back(x, *ys):
    """x and each y, followed by themselves in reverse."""
    return [np.append(column, column[::-1]) for column in (x, *ys)]


def names_of(found):
    return [segment.name for segment in found.segments]


@pytest.fixture(scope="module")
def loop():
    return simulate(SMALL.changed(path="loop"))


def measured_loop(loop, first=0):
    """A Recording of a computed loop with noise, from its point `first` on."""
    frames = [frame for frame in loop.frames if frame.stage != "approach"]
    F = np.array([frame.F for frame in frames])
    F += NOISE * np.abs(F).max() * np.random.default_rng(1).normal(size=F.size)
    return read_measurement(SMALL, table("U_x (nm),F (N/m)", [frame.U_x for frame in frames][first:], F[first:]))


# A load over an approach

LOADS = {  # {heading, in which delta and load have these factors: (factor of delta, factor of the load, unit)}
    "delta (nm),L (N/m)": (1.0, 1.0, "N/m"),
    "indentation depth (um);normal force (mN/m)": (1e-3, 1e3, "N/m"),
    "height (nm),force (nN)": (-1.0, 1e9, "N"),
    "Separation / nm,Load / N": (-1.0, 1.0, "N"),
}


@pytest.mark.parametrize("heading", LOADS)
def test_a_load_over_an_approach_is_read_in_its_unit(heading):
    along, force, unit = LOADS[heading]
    separator = next(mark for mark in ";\t," if mark in heading)
    delta, L = there_and_back(DOWN, LOAD)
    found = read_measurement(SMALL, table(heading, along * delta, force * L, separator=separator))
    assert (found.kind, names_of(found), found.units["L"]) == ("load", ["approach", "retract"], unit)
    approach = found.segments[0]
    assert approach.x - approach.x[0] == pytest.approx(DOWN - DOWN[0], abs=1e-6)
    assert approach.values["L"] == pytest.approx(LOAD, rel=1e-6)
    assert found.free == ("delta" not in heading and "indentation" not in heading)


def test_a_pause_between_approach_and_retraction_is_a_hold():
    delta, L = (np.concatenate([y, np.full(30, y[-1]), y[::-1]]) for y in (DOWN, LOAD))
    found = read_measurement(SMALL, table("delta (nm),L (N/m)", delta, L))
    assert names_of(found) == ["approach", "hold", "retract"]
    assert found.segments[1].x.size == pytest.approx(30, abs=3)


def filled(refused, **dots):
    """The arguments of the call that a refusal names, its dots filled in."""
    call = {name: dict(value) if isinstance(value, dict) else value for name, value in refused.value.call.items()}
    for name, value in dots.items():
        if isinstance(value, dict):
            assert all(call[name][key] is ... for key in value), call
            call[name] |= value
        else:
            assert call[name] is ...
            call[name] = value
    assert "..." not in repr(call) and "Ellipsis" not in repr(call)
    return call


def test_columns_side_by_side_a_voltage_and_a_sensor_that_may_count_either_way_are_asked_for():
    heading = "Extend Z-Sense(nm),Extend T-B(V),Retract Z-Sense(nm),Retract T-B(V)"
    text = table(heading, -DOWN, LOAD, -DOWN[::-1], LOAD[::-1], above="Force Constant, nN/nm:\t2.0\n")
    with pytest.raises(
        DataError, match=r'Retract Z-Sense.*call read_measurement\(scene, source, kind="load", columns=\{'
    ) as refused:
        read_measurement(SMALL, text, kind="load")
    columns = {"delta": "Extend Z-Sense", "L": "Extend T-B"}
    call = filled(refused, columns=columns, units={"L": "500 nN"}) | {"sign": {"delta": -1}}
    with pytest.raises(DataError, match=r"^Extend T-B in 'V'; allowed units: N/m.* or what 1 is, as \"0.5 nN\""):
        read_measurement(SMALL, text, kind="load", columns=columns)
    found = read_measurement(SMALL, text, **call)
    assert names_of(found) == ["approach"] and found.units["L"] == "N" and found.free
    assert found.segments[0].values["L"] == pytest.approx(LOAD * 500e-9, rel=1e-6)
    assert found.segments[0].x == pytest.approx(DOWN, abs=1e-6)
    stiff = read_measurement(SMALL, text, **call, deflection=2.0)
    assert stiff.segments[0].x == pytest.approx(DOWN - 250.0 * LOAD, rel=1e-6)


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_sensor_that_may_count_either_way_asks_for_its_sign_and_names_the_likely_one(way):
    text = table("Z-Sense(nm)\tforce (uN)", *there_and_back(way * DOWN, 1e6 * LOAD), separator="\t")
    with pytest.raises(DataError, match=rf'to contact\? .*sign=\{{"delta": {way:g}\}}\)$') as refused:
        read_measurement(SMALL, text)
    found = read_measurement(SMALL, text, **filled(refused))
    assert names_of(found) == ["approach", "retract"] and found.segments[0].x == pytest.approx(DOWN)


def test_a_displacement_and_a_force_may_be_of_a_press_and_ask_for_the_kind():
    text = table("Displacement (um),Force (mN)", *there_and_back(1e-3 * DOWN, 1e3 * LOAD))
    with pytest.raises(DataError, match=r"or into it \(load\).*kind=...\)$") as refused:
        read_measurement(SMALL, text)
    pressed = read_measurement(SMALL, text, **filled(refused, kind="load"))
    assert (pressed.kind, names_of(pressed), pressed.units["L"]) == ("load", ["approach", "retract"], "N")
    assert pressed.segments[0].values["L"] == pytest.approx(LOAD) and pressed.segments[0].x == pytest.approx(DOWN)
    assert read_measurement(SMALL, text, kind="loop").kind == "loop"
    with pytest.raises(DataError, match=r"^U_x goes to and fro in 2 strokes; call .*kind=\"loop\"\)$"):
        read_measurement(SMALL, text, kind="friction")


@pytest.mark.parametrize("heading", ["time (s),Fx (N/m),Fz (N/m)", "U_x (nm),F (N/m),L (N/m)"])
def test_a_load_that_may_be_counted_downwards_asks_for_its_sign(heading):
    text = table(heading, TIMED, np.sin(TIMED), -2.0 - TIMED)
    speed = 5.0 if "time" in heading else None
    with pytest.raises(DataError, match=r"^L is negative.*sign=\{\"L\": ...\}\)$") as refused:
        read_measurement(SMALL, text, speed=speed)
    found = read_measurement(SMALL, text, **filled(refused, sign={"L": -1}))
    assert found.values["L_bar"] * found.unit == pytest.approx(2.0 + TIMED)
    without = read_measurement(SMALL, text, speed=speed, columns={"L": None})
    assert "L_bar" not in without.values


def test_a_load_that_falls_towards_contact_asks_for_its_sign():
    text = table("delta (nm),L (N/m)", *there_and_back(DOWN, -LOAD))
    with pytest.raises(DataError, match=r"^L falls as the surfaces approach") as refused:
        read_measurement(SMALL, text)
    found = read_measurement(SMALL, text, **filled(refused, sign={"L": -1}))
    assert found.segments[0].values["L"] == pytest.approx(LOAD)


def test_names_units_and_segments_that_a_file_labels_are_read():
    """As the text exports of some force microscopes have them, one table for each segment."""
    above = (
        '# columns: height vDeflection seriesTime\n# fancyNames: "Height" "Deflection" "Series Time"\n# units: m N s'
    )
    text = ""
    for name, way in (("extend", slice(None)), ("pause", slice(50, None)), ("retract", slice(None, None, -1))):
        rows = table(f"# segment: {name}\n{above}", 1e-6 - 1e-9 * DOWN[way], 1e-9 * LOAD[way], DOWN[way], separator=" ")
        text += f"{rows}\n\n"
    found = read_measurement(SMALL, text)
    assert (found.kind, names_of(found), found.units["L"]) == ("load", ["approach", "hold", "retract"], "N")
    assert found.segments[0].x - found.segments[0].x[0] == pytest.approx(DOWN - DOWN[0], abs=1e-5)
    assert found.segments[2].values["L"] == pytest.approx(1e-9 * LOAD[::-1], rel=1e-6)


def test_a_part_of_a_long_curve_is_compared_with_a_run_that_is_shorter():
    """A curve of 3 um, beside a run of some 10 nm: only the part around the contact has both."""
    result = simulate(SMALL.changed(path="unload"))
    frames = [frame for frame in result.frames if frame.stage == "approach"]
    delta, L = (np.array([getattr(frame, name) for frame in frames]) for name in ("delta", "L"))
    far = np.linspace(-3000.0, delta[0] - 1.0, 300)
    text = table("height (nm),force (N)", -np.append(far, delta), np.append(0.0 * far, 1e-9 * L))
    whole = read_measurement(SMALL, text, sign={"L": 1})  # it pulls all the way
    with pytest.raises(ValueError, match=r"the curve covers -3000 .. .* nm, the run .* part=\(from, to\)"):
        whole.residuals(result)
    part = read_measurement(SMALL, text, part=(delta[0] - 0.5, delta[-1] + 0.5), sign={"L": 1})
    assert part.segments[0].x == pytest.approx(delta) and "points are used, from" in " ".join(part.notes)
    assert part.residuals(result).scale == pytest.approx(1e9, rel=1e-3)
    with pytest.raises(DataError, match=r"^part = .*: 0 points of -3000 .. .* nm; give a part of that"):
        read_measurement(SMALL, text, part=(100.0, 200.0), sign={"L": 1})


@pytest.mark.parametrize("x", [np.repeat([0.0, 40.0], 20), np.append(np.zeros(30), 4000.0 + np.arange(30.0))])
def test_a_scale_and_a_zero_need_points_at_three_places(x):
    data = read_measurement(SMALL, table("U_x (nm),F (N)", x, np.sin(np.arange(x.size))))
    with pytest.raises(
        ValueError, match=r"^a scale and a zero need three points at different places.* the run 0 .. 8 nm"
    ):
        data.residuals(simulate(SMALL))


def test_a_load_is_compared_with_a_run_whose_zero_and_scale_are_not_known():
    result = simulate(SMALL.changed(path="unload"))
    frames = [frame for frame in result.frames if frame.stage in ("approach", "unload")]
    delta, L = (np.array([getattr(frame, name) for frame in frames]) for name in ("delta", "L"))
    same = read_measurement(SMALL, table("delta (nm),L (N/m)", delta, L)).residuals(result)
    assert same.rms["L"] < 1e-6 * np.abs(L).max() and same.shift == 0.0
    far = read_measurement(SMALL, table("height (nm),force (nN)", 500.0 - delta, 3.0 * L + 40.0)).residuals(result)
    assert far.shift == pytest.approx(500.0, abs=0.01)
    assert far.scale == pytest.approx(1.0 / 3e-9, rel=1e-3)
    assert far.rms["L"] < 1e-3 * np.abs(L).max()
    assert "delta shifted by 500" in repr(far) and "N/m per N" in repr(far)
    with pytest.raises(ValueError, match=r"no stage for the segment 'retract'.*; compute it with path='unload'"):
        read_measurement(SMALL, table("delta (nm),L (N/m)", delta, L)).residuals(simulate(SMALL))


# A loop


def test_a_loop_is_read_in_segments_and_compared_with_its_run(loop):
    data = measured_loop(loop)
    assert (data.kind, names_of(data), data.virgin) == ("loop", ["forth", "back", "forth"], True)
    found = data.residuals(loop)
    assert found.rms["F"] / found.noise["F"] == pytest.approx(1.0, abs=0.2)
    closed = measured_loop(loop, first=41)
    assert (names_of(closed), closed.virgin) == (["back", "forth"], False)
    assert closed.residuals(loop).rms["F"] == pytest.approx(found.rms["F"], rel=0.2)


def test_the_file_of_a_computed_loop_is_read_as_one(tmp_path, loop):
    loop.save(tmp_path / "loop.csv")
    found = read_measurement(SMALL, tmp_path / "loop.csv")
    assert (found.kind, names_of(found)) == ("loop", ["forth", "back", "forth"])
    assert found.residuals(loop).rms == pytest.approx({"F": 0.0, "L": 0.0, "A": 0.0}, abs=1e-6)


def test_the_file_of_a_computed_retraction_is_read_as_a_load(tmp_path):
    result = simulate(SMALL.changed(path="unload"))
    result.save(tmp_path / "unload.csv")
    found = read_measurement(SMALL, tmp_path / "unload.csv")
    assert (found.kind, names_of(found)) == ("load", ["approach", "retract", "approach"])
    assert found.residuals(result).rms["L"] < 1e-6


@pytest.mark.once
@pytest.mark.parametrize("first", [0, 41])
def test_a_fit_of_a_loop_finds_what_made_it_alone_and_by_an_executor(loop, first):
    data = measured_loop(loop, first)
    found = fit(SMALL.changed(E=33.0), data, ["E"])
    assert found.values["E"] == pytest.approx(30.0, abs=4.0 * found.errors["E"]) and found.errors["E"] < 0.2
    assert found.reached and not found.warnings
    if not first:
        with ThreadPoolExecutor(2) as executor:
            spread = fit(SMALL.changed(E=33.0), data, ["E"], executor=executor)
        assert spread.values == pytest.approx(found.values, rel=1e-6) and spread.reached


def test_the_derivatives_of_a_loop_are_those_of_its_residuals_and_it_leaves_the_end_of_a_range(loop):
    """Points beside slips have large residuals, and the loss of the search scales their derivatives down."""
    model = LoopModel(SMALL, measured_loop(loop), ("phi_ratio",), np.inf)
    jacobian, caution = model.search(np.array([0.0]), POINTS, np.inf)
    _, x, _ = model.best
    assert not caution and x[0] == pytest.approx(1.0, abs=0.05)
    assert jacobian == pytest.approx(model.jacobian(x, POINTS[-1]), rel=1e-9)


def test_chi_squared_of_a_loop_that_does_not_fit_counts_every_point(loop):
    found = fit(SMALL.changed(phi_ratio=0.8), measured_loop(loop), ["E"])
    assert not found.reached and np.abs(found.residuals).max() > 5.0
    assert found.chi2 == pytest.approx((found.residuals**2).sum() / (found.residuals.size - 1)) and found.chi2 > 5.0


def test_a_fit_of_a_loop_takes_the_time_of_its_first_pull_off_its_limit(loop, monkeypatch):
    clock, left = [0.0], []

    def pull(*_):
        clock[0] += 20.0
        raise TimeoutError

    def search(model, *_):
        left.append(model.left)
        raise OutOfTime("no more")

    monkeypatch.setattr(loop_fit, "thread_time", lambda: clock[0])
    monkeypatch.setattr(loop_fit, "fit_of_stroke", pull)
    monkeypatch.setattr(LoopModel, "search", search)
    with pytest.raises(OutOfTime):
        fit(SMALL, measured_loop(loop), ["E"], limit=50.0)
    assert left == [30.0]


def test_a_fit_of_a_loop_under_a_held_load_is_refused_in_words_of_the_fit(loop):
    with pytest.raises(SceneError, match=r"^hold = 'load': allowed in a fit of a loop: delta; use hold=delta"):
        fit(SMALL.changed(hold="load"), measured_loop(loop), ["E"], limit=0.0)


@pytest.mark.filterwarnings("error")
def test_without_derivatives_a_deviation_is_infinite_and_no_warning_of_numpy_is_printed():
    assert uncertainty(np.zeros((1, 2)))[0].tolist() == [np.inf, np.inf]


def test_rows_of_a_loop_are_over_the_units_of_their_names(loop):
    """Forces over w E, areas over w."""
    frames = [frame for frame in loop.frames if frame.stage != "approach"]
    columns = [[getattr(frame, name) for frame in frames] for name in ("U_x", "F", "A")]
    found = fit(SMALL, read_measurement(SMALL, table("U_x (nm),F (N/m),A (nm)", *columns)), ["E"])
    areas = [row[2] for row in found.rows if row[1] == "A_bar"]
    assert max(areas) == pytest.approx(max(frame.A_bar for frame in frames), rel=1e-6)


def test_small_ways_back_are_noise_and_no_segments():
    x = np.linspace(0.0, 10.0, 200) + 0.05 * np.random.default_rng(1).normal(size=200)
    assert turns_of(x) == [0, 199]
    found = read_measurement(SMALL, table("U_x (nm),F (N/m)", x, np.sin(x)))
    assert isinstance(found, Measurement) and np.all(np.diff(found.U_x) >= 0.0)
    assert "put in order" in found.notes[0]


# Friction over time

TIMED = np.linspace(0.0, 2.0, 50)


@pytest.mark.parametrize(
    ("above", "speed", "heading"),
    [
        ("Speed: 5 nm/s\n", 5.0, "Time (s),Fx (N/m),Fz (N/m)"),
        ("", 5.0, "t (s),friction (N/m),normal load (N/m)"),
        ("Velocity = 240\n", 5.0, "Fx,Fz,T"),
    ],
)
def test_friction_over_time_takes_the_speed_that_is_given(above, speed, heading):
    F, L = 3.0 * np.sin(TIMED), 2.0 + TIMED
    columns = (F, L, TIMED) if heading == "Fx,Fz,T" else (TIMED, F, L)
    rows = table(heading, *columns, above=above)
    if heading == "Fx,Fz,T":  # a row of units
        rows = rows.replace("Fx,Fz,T\n", "Fx,Fz,T\nN/m,N/m,sec\n")
    found = read_measurement(SMALL, rows, speed=speed)
    assert found.U_x == pytest.approx(5.0 * TIMED)
    assert found.values["F_bar"] * found.unit == pytest.approx(F, abs=1e-8)
    assert found.values["L_bar"] * found.unit == pytest.approx(L)


def test_what_is_given_beside_what_the_file_says_is_named_or_refused():
    said = table("Time (s),Fx (N/m)", TIMED, np.sin(TIMED), above="Speed: 5 nm/s\n")
    assert "speed = 2 nm/s as given; the file says Speed = 5 nm/s." in read_measurement(SMALL, said, speed=2.0).notes
    with pytest.raises(DataError, match="speed = 2: used with friction over time only"):
        read_measurement(SMALL, table("U_x (nm),F (N/m)", TIMED, TIMED), speed=2.0)
    for unit in ("F (N/m)", "F/F_s"):
        with pytest.raises(DataError, match=r"force = 3, but F is in .*; leave force out"):
            read_measurement(SMALL, table(f"U_x (nm),{unit}", TIMED, TIMED), force=3.0)


@pytest.mark.parametrize("force", [0.0, -1.0, np.nan, np.inf])
def test_a_force_per_unit_is_above_zero_and_a_sign_is_no_part_of_it(force):
    with pytest.raises(DataError, match=f"force = {force:g}; allowed: above 0"):
        read_measurement(SMALL, table("U_x (nm),F", TIMED, 1.0 + TIMED), force=force)


def test_of_two_friction_forces_and_a_height_beside_a_load_one_is_asked_for():
    """A tribometer's table: Z and Fz alone would be a load."""
    text = table("Fx,Fz,Z,T,Ff\ng,g,mm,sec,g", np.sin(TIMED), 2.0 + TIMED, TIMED, TIMED, np.sin(TIMED))
    with pytest.raises(DataError, match=r'columns=\{"time": "T", "F": ...\}\)$') as refused:
        read_measurement(SMALL, text, speed=5.0)
    found = read_measurement(SMALL, text, **filled(refused, columns={"F": "Ff"}), part=(2.0, 8.0))
    assert (found.kind, found.units["F"]) == ("friction", "N") and np.ptp(found.segments[0].x) <= 6.0


def test_friction_over_time_without_a_speed_is_refused_with_what_the_file_says():
    text = table("Time (s),Fx (N/m),Fz (N/m)", TIMED, TIMED, TIMED, above="Velocity = 240\n")
    with pytest.raises(DataError, match=r"the file says Velocity = 240; call .*, speed=...\)$") as refused:
        read_measurement(SMALL, text)
    assert read_measurement(SMALL, text, **filled(refused, speed=240.0)).U_x == pytest.approx(240.0 * TIMED)


def test_several_tables_are_asked_for():
    first, second = (table("Time (s),Fx (N/m)", TIMED, k * np.sin(TIMED)) for k in (1.0, 2.0))
    text = f"{first}\n\nStep No. 2\n{second}"
    with pytest.raises(
        DataError, match=r"^2 tables: 1 'from line 2', 2 'from line 55', 'all'; call .*channel=...\)$"
    ) as refused:
        read_measurement(SMALL, text, speed=5.0)
    found = read_measurement(SMALL, text, **filled(refused, channel=2))
    assert found.U_x.size == TIMED.size and found.values["F_bar"] * found.unit == pytest.approx(2.0 * np.sin(TIMED))
    with pytest.raises(DataError, match="channel = 3: allowed: 1 'from line 2', 2 'from line 55', 'all'; give one"):
        read_measurement(SMALL, text, speed=5.0, channel=3)
    with pytest.raises(DataError, match="time goes back"):  # of both as one
        read_measurement(SMALL, text, speed=5.0, channel="all")
    assert read_measurement(SMALL, first, speed=5.0, channel="all").U_x.size == TIMED.size
    short = read_measurement(SMALL, f"{first}\n\nStep No. 2\nTime (s),Fx (N/m)\n1,2\n2,3", speed=5.0)
    assert "line 55 begins another table: left out." in short.notes


def test_forces_without_a_width_are_kept_in_newtons_and_no_fit_takes_them():
    text = table("U_x (nm),F (mN)", TIMED, 2.0 * TIMED)
    found = read_measurement(SMALL, text)
    assert (found.kind, found.units["F"]) == ("friction", "N")
    assert found.segments[0].values["F"] == pytest.approx(2e-3 * TIMED)
    with pytest.raises(DataError, match="F is in N, and a fit needs N/m; divide it by the width of the contact"):
        fit(SMALL, found, ["E"])
    over_a_millimetre = read_measurement(SMALL, text, force=1.0)  # 1 mN over 1 mm is 1 N/m
    assert over_a_millimetre.values["F_bar"] * over_a_millimetre.unit == pytest.approx(2.0 * TIMED)


# An area over a force


def test_an_area_over_a_force_is_read_relative_or_in_nm_and_compared():
    result = simulate(SMALL)
    end = result.first_slip
    frames = [frame for frame in result.frames if frame.stage == "shear" and frame.U_x < end.U_s]
    F, A = (np.array([getattr(frame, name) for frame in frames]) for name in ("F", "A"))
    for heading, x, y in (("F (N/m),A (nm)", F, A), ("F/F_s,A/A_0", F / end.F_s, A / A[0])):
        data = read_measurement(SMALL, table(heading, x, y))
        assert data.kind == "area over force"
        assert data.residuals(result).rms["A"] < 1e-6 * y.max()
    with pytest.raises(DataError, match="this is area over force; a fit takes friction"):
        fit(SMALL, data, ["E"])
    with pytest.raises(DataError, match=r"A in 'mm\^2'; .*; divide it by its value without shear, and write A/A_0"):
        read_measurement(SMALL, table("F (mN),A (mm^2)", F, A))


# Units that stand nowhere, and points of one place


def test_a_missing_unit_is_asked_for():
    text = table("U_x,F", TIMED, TIMED)
    with pytest.raises(DataError, match=r'^U_x has no unit; .*units=\{"U_x": ..., "F": ...\}\)$') as refused:
        read_measurement(SMALL, text)
    found = read_measurement(SMALL, text, **filled(refused, units={"U_x": "um", "F": "mN/m"}))
    assert found.U_x == pytest.approx(1e3 * TIMED) and found.values["F_bar"] * found.unit == pytest.approx(1e-3 * TIMED)
    with pytest.raises(DataError, match=r"units\['F'\] = 'N/m', but the file names mN/m; leave it out"):
        read_measurement(SMALL, table("U_x (nm),F (mN/m)", TIMED, TIMED), units={"F": "N/m"})


def test_two_points_at_a_slip_may_have_one_displacement(loop):
    U_x = np.array([frame.U_x for frame in loop.frames if frame.stage == "shear"])
    F = np.array([frame.F for frame in loop.frames if frame.stage == "shear"])
    slip = int(np.argmin(np.diff(F)))
    U_x[slip] = U_x[slip + 1] = 0.5 * (U_x[slip] + U_x[slip + 1])
    data = read_measurement(SMALL, table("U_x (nm),F (N/m)", U_x, F))
    assert data.U_x.size == U_x.size
    assert fit(SMALL.changed(E=30.3), data, ["E"]).values["E"] == pytest.approx(30.0, rel=5e-3)


def test_forces_in_newtons_of_the_other_sign_are_refused_beside_a_run():
    result = simulate(Scene(u_x_max=4.0))
    rows = [(frame.U_x, -1e-9 * frame.F) for frame in result.frames if frame.stage == "shear"]
    text = "\n".join(["U_x (nm),F (N)", *(f"{x:.6g},{y:.6g}" for x, y in rows)]) + "\n"
    with pytest.raises(ValueError, match="turn their sign"):
        read_measurement(Scene(), text).residuals(result)


def test_a_line_above_the_columns_keeps_its_decimal_comma():
    rows = "".join(f"{k},5;{k * k},25\n" for k in range(20))
    text = f"rate = 0,5 nm/s\nprobe: silicon, new\nU_x (nm);F (N/m)\n{rows}"
    assert read_measurement(SMALL, text).said == {"rate": "0,5 nm/s", "probe": "silicon"}
