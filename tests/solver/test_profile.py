"""Measured profiles: reading, processing, reports, and refusals that name line and reason."""

import pickle
import re
from dataclasses import asdict
from io import StringIO

import numpy as np
import pytest

from solver import DataError, Profile, Scene, SceneError, load_path, read_profile, simulate
from solver.analysis.peeling import edges
from solver.measured.content import MOST_BYTES
from solver.measured.periodic import FEWEST_POINTS, MOST_POINTS, STEEPEST
from solver.scene import LIMITS
from solver.surfaces import LENGTHS
from solver.text import number_from_text

X = np.linspace(0.0, 640.0, 257)
HILLS = 4.0 * np.cos(2.0 * np.pi * 2.0 * X / 640.0)  # two whole waves: highest at x = 0, 320, 640


HEADING = "x (nm),z (nm)\n"


def table(x, z, separator=", ", heading=HEADING):
    return heading + "\n".join(f"{a!r}{separator}{b!r}" for a, b in zip(x.tolist(), z.tolist(), strict=True))


def shown(profile, nodes=256):
    """The gap that a scene makes of it."""
    return Scene(surface="measured", measured=profile, width=profile.length, nodes=nodes).profile


@pytest.mark.parametrize("separator", [",", ", ", ";", "\t", " ", "   ", " ; "])
@pytest.mark.parametrize("heading", ["", "x,z\n", "x [nm] z [nm]\n", "# by hand\n\nx;z\n"])
def test_columns_may_be_separated_and_headed_in_any_usual_way(separator, heading):
    unit = None if "nm" in heading else "nm"
    assert read_profile(table(X, HILLS, separator, heading), unit=unit) == read_profile(table(X, HILLS))


@pytest.mark.parametrize("separator", [";", "\t"])
def test_semicolons_and_tabs_allow_decimal_commas(separator):
    assert read_profile(table(X, HILLS, separator).replace(".", ",")) == read_profile(table(X, HILLS))


def test_lines_above_the_heading_are_skipped():
    preamble = "Instrument: AFM 3\nDate; 1.2.2024\n\nChannel, height\n"
    assert read_profile(preamble + table(X / 1000.0, HILLS, heading="x [µm], z [nm]\n")).length == 640.0


@pytest.mark.parametrize("row", ["{},", "{},nan", "{}", ",", "NaN,1.0", "{},-inf"])
def test_rows_without_both_numbers_are_left_out_and_reported(row):
    lines = table(X, HILLS).split("\n")
    profile = read_profile("\n".join([*lines[:2], row.format(2.6), *lines[2:]]))
    assert profile == read_profile(table(X, HILLS)) and profile.notes[0].startswith("257 points")
    assert profile.notes[1] == "1 row without all numbers left out (line 3)."


@pytest.mark.parametrize("heading", ["x [µm], z [nm]\n", "x/um; z/nm\n", "x (μm) z (nm)\n"])
def test_units_in_the_heading_are_used_and_reported(heading):
    read = read_profile(table(X / 1000.0, HILLS, heading=heading))
    assert read.length == pytest.approx(640.0) and read.z == pytest.approx(read_profile(table(X, HILLS)).z, abs=1e-9)
    assert "x is read as " in read.notes[0] and "z as nm" in read.notes[0]


def test_a_unit_of_one_column_is_none_of_the_other():
    text = table(X / 1000.0, HILLS / 1000.0, heading="x, z (µm)\n")
    with pytest.raises(
        DataError, match=r"^x has no unit.*call read_profile\(source, units=\{\"x\": ..., \"z\": \"µm\"\}\)"
    ):
        read_profile(text)
    assert read_profile(text, units={"x": "µm", "z": "µm"}).length == pytest.approx(640.0)


@pytest.mark.parametrize(
    ("unit", "nm"), [("\N{ANGSTROM SIGN}", 0.1), ("A\N{COMBINING RING ABOVE}", 0.1), ("Å", 0.1), ("mm", 1e6)]
)
def test_heights_in_angstrom_and_millimetres_are_converted(unit, nm):
    read = read_profile(table(X, HILLS / nm, heading=f"x (nm),z ({unit})\n"))
    assert read.z == pytest.approx(read_profile(table(X, HILLS)).z, abs=1e-9)
    assert number_from_text("width", f"20 {unit}") == pytest.approx(20.0 * nm)


@pytest.mark.parametrize("heading", ["x (V),z (nm)", "x/nm,z [uin]", "x (pm),z (nm)", "x/ft z/ft"])
def test_a_profile_in_an_unknown_unit_is_refused_with_the_known_ones(heading):
    with pytest.raises(
        DataError, match=r"^[xz] in '.*'; allowed units: nm, um, mm, cm, m, Å, in, or what 1 is.*units=\{"
    ):
        read_profile(table(X, HILLS, heading=f"{heading}\n"))


def test_a_file_in_micrometres_without_a_heading_is_refused_with_the_likely_reason():
    profile = read_profile(table(X / 100.0, HILLS / 100.0))
    with pytest.raises(SceneError, match="give x and z of the profile in nm"):
        Scene(surface="measured", measured=profile, width=profile.length)


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_profiles_from_text_bytes_and_files_are_equal(tmp_path, end):
    file = tmp_path / "p.csv"
    text = table(X, HILLS).replace("\n", end)
    file.write_bytes(b"\xef\xbb\xbf" + text.encode())
    assert read_profile(file) == read_profile(text.encode()) == read_profile(text)


def test_a_text_without_a_line_break_is_a_path(tmp_path, monkeypatch):
    (tmp_path / "p.csv").write_text(table(X, HILLS))
    monkeypatch.chdir(tmp_path)
    assert read_profile("p.csv") == read_profile(table(X, HILLS)) == read_profile(StringIO(table(X, HILLS)))
    with pytest.raises(DataError, match=r"^'missing\.csv' is not a file; name a CSV file, or give its lines"):
        read_profile("missing.csv")


def test_a_file_in_utf_16_is_read_by_the_names_of_its_columns():
    rows = "".join(f"{k},{x / 1000.0:.9g},{z / 1000.0:.9g}\n" for k, (x, z) in enumerate(zip(X, HILLS, strict=True)))
    profile = read_profile(f"index,x in µm,y in µm\n{rows}".encode("utf-16"))
    assert profile.length == pytest.approx(640.0) and np.ptp(profile.z) == pytest.approx(8.0)
    assert "Not used: index." in profile.notes


def test_a_file_in_latin_1_is_read():
    text = table(X / 1000.0, HILLS, heading="Höhe gemessen\nx (µm),z (nm)\n")
    assert read_profile(text.encode("latin-1")) == read_profile(text.encode())


@pytest.mark.parametrize("heading", ["", "x,z,quality\n", "quality,z,x\n"])
def test_further_columns_are_ignored_and_reported(heading):
    rows = [(b, a) if heading.startswith("quality") else (a, b) for a, b in zip(X, HILLS, strict=True)]
    third = [f"1,{a},{b}" if heading.startswith("quality") else f"{a},{b},1" for a, b in rows]
    columns = None if heading else {"x": 1, "z": "2"}
    read = read_profile(heading + "\n".join(third), unit="nm", columns=columns)
    assert read.z.tolist() == read_profile(table(X, HILLS)).z.tolist()
    assert read.notes[1] == f"Not used: {'quality' if heading else 'column 3'}."


def test_a_periodic_profile_at_equal_distances_is_kept_as_it_is():
    profile = read_profile(table(X, HILLS))
    assert profile.length == 640.0
    # summits of z touch first: the gap is the highest z less z; the deepest valley, half a wave on, is brought to x = 0
    expected = 4.0 - np.roll(HILLS[:-1], -64)
    # the line of least squares through so many points of a cosine is level to 1e-15, z to round-off
    assert shown(profile) == pytest.approx(expected, abs=1e-12)
    assert not any("resampled" in note for note in profile.notes)


def test_tilt_and_offset_are_removed_and_reported():
    # a line added to whole waves is not quite the line of least squares of the sum: 2 % of the height remain
    tilted = read_profile(table(X, HILLS + 0.01 * X - 7.0))
    assert shown(tilted) == pytest.approx(shown(read_profile(table(X, HILLS))), abs=0.05)
    assert any("tilt of 0.01 was removed" in note for note in tilted.notes)


def test_ends_that_do_not_meet_are_joined_near_the_ends_only_and_reported():
    z = 3.0 * np.sin(np.pi * 1.5 * X / 640.0)
    profile = read_profile(table(X, z))
    assert any(re.search(r"The ends, \d\.\d+ nm apart, were joined over 32 nm", note) for note in profile.notes)
    shift = float(re.search(r"Shifted by ([\d.]+) nm", profile.notes[-1])[1])
    heights = np.roll(profile.z, round(shift / 2.5))
    inside = (X[:-1] > 32.0) & (X[:-1] < 608.0)
    # within, heights are those of the file less one straight line
    rest = (heights - z[:-1])[inside]
    assert np.ptp(np.diff(rest)) < 1e-12
    # and across the ends, 3 nm apart in the file, they go on as smoothly as there
    assert abs(heights[0] - heights[-1]) < np.abs(np.diff(z)).max()


def test_unequal_distances_are_resampled_and_reported():
    x = np.sort(np.append(np.random.default_rng(0).uniform(0.0, 640.0, 2000), [0.0, 640.0]))
    profile = read_profile(table(x, 4.0 * np.cos(2.0 * np.pi * 2.0 * x / 640.0)))
    told = "2002 points were resampled to 8004 at equal distances: means over the new spacing, where they lay closer."
    assert told in profile.notes
    # gaps of up to 3 nm between points: the sagitta of a wave of curvature 4 (2 pi/320)^2 over them, 2e-3 nm; the line
    # of least squares through points at random tilts by less than 1e-3, but leaves up to 0.1 nm at the ends
    assert shown(profile) == pytest.approx(shown(read_profile(table(X, HILLS))), abs=0.2)


def test_more_points_than_nodes_can_show_are_thinned_out():
    x = np.arange(40_001) * 0.016
    profile = read_profile(table(x, np.cos(2.0 * np.pi * x / 640.0)))
    assert profile.z.size == MOST_POINTS
    assert any("40001 points were resampled" in note for note in profile.notes)


def test_wider_distances_are_resampled_linearly_and_reported():
    x = np.linspace(0.0, 640.0, 257) + 0.5 * np.sin(np.arange(257))
    profile = read_profile(table(x, 0.1 * (x - x[0]) * (x[-1] - x) / 640.0))
    assert "257 points were resampled to 1024 at equal distances, linearly." in profile.notes


def test_thinning_out_does_not_turn_short_waves_into_long_ones():
    """Waves of 2.4 points, in every new spacing one and nine over the length: sampled, they would be nine waves."""
    x = np.linspace(0.0, 640.0, 40_001)
    ripple = 1e-3 * np.cos(2.0 * np.pi * (MOST_POINTS + 9) * x / 640.0)
    profile = read_profile(table(x, np.cos(2.0 * np.pi * 2.0 * x / 640.0) + ripple))
    assert any("40001 points were resampled to 16384 at equal distances: means" in note for note in profile.notes)
    amplitude = 2.0 * np.abs(np.fft.rfft(profile.z)) / profile.z.size
    # the mean over 1 + 9/16384 waves is 9/16393 of the amplitude; sampled it was all of it
    assert amplitude[9] < 2e-3 * 1e-3
    assert amplitude[2] == pytest.approx(1.0, abs=1e-6)


def test_a_width_selects_the_middle_of_a_profile():
    profile = read_profile(table(X, HILLS), width=320.0)
    assert profile.length == 320.0
    assert any("Of 640 nm the 320 nm in the middle are used" in note for note in profile.notes)
    assert np.ptp(shown(profile)) == pytest.approx(8.0, rel=1e-3)


@pytest.mark.parametrize(
    ("text", "line", "reason"),
    [
        ("\n\n# nothing\n", 4, "no points"),
        ("x,z\n", 2, "no points"),
        ("a fairy tale\nin two lines\n", 3, "no points; needed: two columns: x, z in nm"),
        ("x,z\n1,2\n2,three\n", 3, "'three' is not a number; correct or delete the line"),
        (f"{HEADING}1,2\n2,\n", 2, "only 1 point,"),
        (f"{HEADING}1,2\n2,nan\ninf,3\n4," + "9" * 400 + "\n", 2, "only 1 point,"),
        ("1,2\n2,\1\n", 2, "an unreadable cell is not a number"),
        (f"{HEADING}1,2\n2,1e300\n", 3, "z = 1e+300 nm: allowed"),
        (f"{HEADING}1,2\n2,3\n2,4\n", 4, "x = 2 after 2; keep one line of each x"),
        ("x/nm z/nm\n1 2\n2 3\n1.5 4\n", 4, "x = 1.5 after 2; sort the lines by x"),
        ("1," * 101 + "\n", 1, "102 columns; allowed: up to 100"),
        ("1,2\n3,4,5\n", 2, "3 columns in place of 2; use decimal points, or semicolons between columns"),
        ("1,2\n\0\0\0\n", 2, "not a text file"),
        ("1.5;2\n2,5;3\n", 2, "decimal points and commas; write one sign, without separators of thousands"),
        (table(X[:9], HILLS[:9]), 10, f"only 9 points, at least {FEWEST_POINTS} are needed"),
        (table(1e-4 * X, 1e-4 * HILLS), 258, "0.064 nm long, allowed: 1 .. 1e+06 nm"),
        (table(1e7 * X, HILLS), 43, "x = 1.025e+09 nm: allowed: -1e+09 .. 1e+09 nm; check its unit"),
        (table(X, HILLS + 0.5 * X), 258, "tilted by 0.5, allowed: up to 0.3; level it"),
        (
            table(X, np.where(X < 300.0, 0.0, 5.0)),
            122,
            "slope 1.99 from the point before, allowed: up to 0.3; a cut-off",
        ),
    ],
)
def test_bad_text_is_refused_with_line_and_reason(text, line, reason):
    with pytest.raises(DataError) as caught:
        read_profile(text)
    message = str(caught.value)
    assert isinstance(caught.value, ValueError) and caught.value.line == line
    assert message.startswith(f"line {line}: ")
    assert reason in message and "\n" not in message


def test_ends_too_far_apart_to_be_joined_are_refused():
    # a parabola's flank: level as a whole, but one end stands 45 nm above the other
    z = np.where(X < 600.0, 0.0, 0.28 * (X - 600.0))
    z[:60] -= 0.28 * (X[60] - X[:60])
    with pytest.raises(
        DataError, match=r"its ends, .* nm apart, joined over 32 nm .* slope .* allowed: up to 0\.3; .* cut-off"
    ):
        read_profile(table(X, z))
    assert STEEPEST == 0.3


def test_ends_whose_join_adds_to_a_slope_beyond_the_limit_are_refused_with_the_line():
    """A saw of slope 0.28 whose ends lie 0.65 nm apart: the slopes of saw and join are allowed, but not their sum."""
    x = np.arange(200.0)
    saw = 0.28 * np.abs(x % 20.0 - 10.0)
    z = saw + 1.5 * np.clip((x - 60.0) / 60.0, 0.0, 1.0)
    z[60:121] = np.linspace(z[60], z[120], 61)
    reason = r"line 194: its ends, 0\.65.* nm apart, joined over 9\.95 nm at each end: slope 0\.306 from the point"
    with pytest.raises(DataError, match=reason) as caught:
        read_profile(table(x, z))
    assert caught.value.line == 194


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        (bytes(range(256)), "no known file of an instrument"),
        ("1,2\n2,3\n".encode("utf-16-le"), "no known file of an instrument"),
        (b"x,z\n1,2\n3,\xb5\n", "line 3: 'µ' is not a number"),
        (b"\0" * 100, "this is an empty file"),
        (b"7" * (MOST_BYTES + 1), "more than 20 MB"),
    ],
)
def test_bad_files_are_refused(tmp_path, content, reason):
    file = tmp_path / "p.csv"
    file.write_bytes(content)
    for source in (file, content):
        with pytest.raises(DataError, match=reason):
            read_profile(source)


def test_only_files_are_read(tmp_path):
    for path in (tmp_path, tmp_path / "missing.csv"):
        with pytest.raises(DataError, match="is not a file"):
            read_profile(path)


@pytest.mark.parametrize("width", [641.0, float("nan"), float("inf"), 0.0, -5.0, -641.0, -float("inf")])
def test_a_width_outside_the_profile_is_refused(width):
    reason = f"the profile is 640 nm long, the width asked for is {width:g} nm; allowed: above 0 to that length"
    with pytest.raises(DataError, match=re.escape(reason)):
        read_profile(table(X, HILLS), width)


@pytest.mark.parametrize(
    ("length", "heights", "reason"),
    [
        (float("nan"), np.zeros(20), r"length = nan: allowed: 1 .. 1e\+06 nm; give a number in that range"),
        (-100.0, np.zeros(20), "length = -100.0: allowed"),
        (2e6, np.zeros(20), "length = 2000000.0: allowed"),
        (None, np.zeros(20), "length = None: allowed"),
        ("100", np.zeros(20), "length = '100': allowed"),
        (100.0, [], "heights: 0 points; allowed: 16 or more"),
        (100.0, b"", "heights: 0 points; allowed: 16 or more"),
        (100.0, np.zeros(FEWEST_POINTS - 1), "heights: 15 points; allowed: 16 or more"),
        (100.0, b"abc", "heights = 3 bytes: allowed: 8 for each float64"),
        (100.0, [0.0] * 5 + [np.nan] * 20, r"heights\[5\] = nan: allowed: finite numbers"),
        (100.0, np.full(20, -np.inf).tobytes(), r"heights\[0\] = -inf: allowed: finite numbers"),
        (100.0, [0.0, 2.0] * 10, "the largest slope is 0.4; allowed: up to 0.3; smooth or rescale"),
        (100.0, 0.2 * np.arange(20.0), "the largest slope is 0.76; allowed: up to 0.3"),  # across the ends
        (100.0, [1.7e308, -1.7e308] * 10, "the largest slope is inf; allowed"),
        (100.0, np.zeros((4, 4)), "heights: allowed: one row of real numbers"),
        (100.0, 3.0, "heights: allowed: one row"),
        (100.0, ["high"] * 20, "heights: allowed: one row"),
        (100.0, [1j] * 20, "heights: allowed: one row"),
        (100.0, [[1.0], [1.0, 2.0]] * 10, "heights: allowed: one row"),
        (100.0, None, "heights: allowed: one row"),
    ],
)
def test_an_unusable_profile_is_refused_with_what_is_allowed(length, heights, reason):
    with pytest.raises(DataError, match=reason):
        Profile(length, heights)


def test_a_profile_may_be_as_steep_and_as_long_as_its_limits():
    assert LIMITS["width"][:2] == LENGTHS
    heights = 0.3 * np.abs(np.arange(20) - 10.0)
    assert Profile(200, [0, 1, 2, 1] * 10).length == 200.0
    for length in LENGTHS:
        scaled = Profile(length, heights * (length / 20.0))
        assert Profile(length, scaled.heights) == scaled == pickle.loads(pickle.dumps(scaled))


@pytest.mark.parametrize(
    "line", ["a(" * 10**5, "a(" + 10**5 * " " + "))", "a" * 10**5 + "!", "a(b," * 10**5, "a/" * 10**5]
)
def test_long_headings_are_read_in_linear_time(line):
    """In quadratic time each would take minutes."""
    with pytest.raises(DataError):
        read_profile(line + "\n" + "1,2\n")


def test_random_input_raises_profile_errors_only():
    random = np.random.default_rng(0)
    for count in random.integers(1, 120, 400):
        for junk in (
            bytes(random.integers(0, 256, count, dtype=np.uint8)),
            "".join(random.choice(list("0123456789.,;e-+ \n\tnaix#_"), count)),
        ):
            with pytest.raises(DataError):
                read_profile(junk)


def test_a_measured_scene_is_hashable_picklable_and_runs():
    profile = read_profile(table(X, HILLS))
    scene = Scene(surface="measured", measured=profile, width=640.0, nodes=256, du_z=0.5, du_x=0.5, u_x_max=5.0)
    assert pickle.loads(pickle.dumps(scene)) == scene
    assert len({scene, scene.changed(delta_bar=0.1), pickle.loads(pickle.dumps(scene))}) == 2
    assert "heights" not in repr(scene)
    assert Profile(**asdict(profile)) == Profile(640.0, profile.z.tolist()) == profile
    frames = list(load_path(scene))
    assert max(f.residual for f in frames) <= scene.tolerance
    assert len(edges(frames[-1])) == 2


def test_a_measured_surface_needs_its_profile_at_its_width():
    profile = read_profile(table(X, HILLS))
    with pytest.raises(SceneError, match=r"surface = 'measured': it needs a profile; give one: profile=FILE"):
        Scene(surface="measured")
    with pytest.raises(SceneError, match=r"width = 2500\.0: allowed: the profile's 640\.0 nm; set that width"):
        Scene(surface="measured", measured=profile)
    with pytest.raises(SceneError, match="measured = 3: allowed: a Profile or None"):
        Scene(measured=3)


# One period


SINE = np.arange(129) * 2.5, 3.0 * np.sin(2.0 * np.pi * np.arange(129) / 128.0)


@pytest.mark.parametrize("points", [129, 128])
@pytest.mark.parametrize("periodic", [None, True])
def test_one_period_of_a_sine_gives_the_run_of_the_wave(points, periodic):
    """With and without its first point repeated. Levelled and joined its static friction would be twice as high."""
    profile = read_profile(table(SINE[0][:points], SINE[1][:points]), periodic=periodic)
    assert profile.length == 320.0 and np.ptp(profile.z) == pytest.approx(6.0, rel=1e-12)
    usual = {"width": 320.0, "nodes": 128, "delta_bar": 0.2, "u_x_max": 9.0}
    own = simulate(Scene(surface="measured", measured=profile, **usual)).first_slip
    wave = simulate(Scene(surface="wave", amplitude=3.0, waves=1, **usual)).first_slip
    assert (own.F_s, own.U_s) == pytest.approx((wave.F_s, wave.U_s), rel=1e-9)
    assert own.F_s == pytest.approx(166.7, abs=0.1) and own.U_s == pytest.approx(7.85, abs=0.01)


def test_a_profile_that_is_called_aperiodic_is_levelled():
    assert any("tilt" in note for note in read_profile(table(*SINE), periodic=False).notes)


def test_a_period_whose_ends_differ_needs_even_points():
    x = np.delete(SINE[0], [4, 128])
    with pytest.raises(DataError, match=r"^its ends differ by 0\.\d+ nm.*periodic=False"):
        read_profile(table(x, np.delete(SINE[1], [4, 128])), periodic=True)


@pytest.mark.parametrize("seed", range(3))
def test_a_profile_written_and_read_ten_times_is_the_same(tmp_path, seed):
    random = np.random.default_rng(seed)
    first = again = Profile(317.3, np.cumsum(random.normal(size=320)) % 0.25)
    for _ in range(10):
        again.to_csv(tmp_path / "profile.csv")
        again = read_profile(tmp_path / "profile.csv")
    assert again == first


def test_a_long_or_flat_profile_is_read_as_it_was_written_and_a_part_of_it_is_no_period(tmp_path):
    file, x = tmp_path / "profile.csv", np.arange(2500)
    for length, height in ((25_000.0, 3.0), (100.0, 1e-3)):  # beyond what is taken of a measurement
        profile = Profile(length, height * np.sin(2.0 * np.pi * x / 2500))
        profile.to_csv(file)
        assert read_profile(file) == profile
    Profile(1000.0, 0.2 * np.cos(2.0 * np.pi * np.arange(1000) / 1000)).to_csv(file)
    part = read_profile(file, part=(0, 300))
    assert part.length == 300.0 and any("joined" in note for note in part.notes)


def test_a_rough_profile_that_ends_near_its_start_by_chance_is_no_period():
    z = np.random.default_rng(1).uniform(-0.3, 0.3, 257)
    z[-1] = z[0] + 0.01
    assert any("tilt" in note for note in read_profile(table(X, z)).notes)


# Units


LAYOUTS = {  # lines above the numbers: (unit of x, unit of z) in nm
    "x (um),z (nm)": (1e3, 1.0),
    "x [um],z [um]": (1e3, 1e3),
    "# x (um), z (nm)": (1e3, 1.0),
    "# x [um] z [um]": (1e3, 1e3),
    "x um, z um": (1e3, 1e3),
    "x um,z nm": (1e3, 1.0),
    "x_um,z_um": (1e3, 1e3),
    "x_um,z_nm": (1e3, 1.0),
    "x {um},z {um}": (1e3, 1e3),
    "x in um,z in nm": (1e3, 1.0),
    "x,z\num,nm": (1e3, 1.0),
    "x,z\n(um),(nm)": (1e3, 1.0),
    "X;Y;valid\n[mm];[mm];[1/0]": (1e6, 1e6),
    "x (um),z (nm)\n-------------": (1e3, 1.0),
    "x (um),z (nm)\n257": (1e3, 1.0),
    "x (um),z (nm)\n\n": (1e3, 1.0),
    "µm µm\n257": (1e3, 1e3),
    "# Lateral units: um\n# Value units: nm": (1e3, 1.0),
    "# Value units: nm\n# Lateral units: um": (1e3, 1.0),
    "# Units: um": (1e3, 1e3),
    "Units: micron\nx,z": (1e3, 1e3),
    "unit = um": (1e3, 1e3),
    "Lateral um,Raw Micrometer,": (1e3, 1e3),
    "Distance (Micrometers), Height (Angstroms)": (1e3, 0.1),
    "x (microns),z (nanometers)": (1e3, 1.0),
    "X[mm]\tZ[\N{MICRO SIGN}m]": (1e6, 1e3),
    "X[mm]\tZ[\N{GREEK SMALL LETTER MU}m]": (1e6, 1e3),
    "x / m; z / m": (1e9, 1e9),
    "x (m),z (m)": (1e9, 1e9),
    "x [A],z [A]": (0.1, 0.1),
    "x [\N{LATIN CAPITAL LETTER A WITH RING ABOVE}],z [nm]": (0.1, 1.0),
    "z (nm),x (um)": (1e3, 1.0),
    "X (UM),Z (NM)": (1e3, 1.0),
    "Profile 1\nLength [cm],Height [nm]": (1e7, 1.0),
    "Title: A test of m samples\nx (um),z (nm)": (1e3, 1.0),
    '"x (um)","z (nm)"': (1e3, 1.0),
    "nm\tnm": (1.0, 1.0),
    "Position_micrometer,Height_nanometer": (1e3, 1.0),
    "# columns: x um, z nm": (1e3, 1.0),
}


@pytest.mark.parametrize(("above", "nm"), LAYOUTS.items(), ids=map(repr, LAYOUTS))
def test_a_unit_above_the_numbers_is_used_wherever_it_stands(above, nm):
    x, z = X / nm[0], HILLS / nm[1]
    separator = "\t" if "\t" in above else ";" if ";" in above else ","
    columns = (z, x) if above.startswith("z") else (x, z)
    rows = table(*columns, separator, "")
    read = read_profile(f"{above}\n{rows.replace(chr(10), ';1' + chr(10)) + ';1' if 'valid' in above else rows}")
    assert read.length == pytest.approx(640.0, rel=1e-9)
    assert np.ptp(read.z) == pytest.approx(8.0, rel=1e-9)


@pytest.mark.parametrize(
    "above",
    ["Scan size: 640 um", "# Width: 10 µm", "Radius 2.5 um\nx,z", "# x (V), z (nm)", "x, um, z, nm", "# z (nm)\nx,z"],
)
def test_a_unit_that_may_be_of_something_else_is_named_in_a_refusal(above):
    with pytest.raises(DataError, match=r"um|µm|'V'|nm") as refused:
        read_profile(f"{above}\n{table(X, HILLS, ',', '')}")
    assert refused.value.call.keys() == {"units"} and len(refused.value.table.columns) == 2
    units = {name: "1 nm" if unit is ... else unit for name, unit in refused.value.call["units"].items()}
    assert read_profile(f"{above}\n{table(X, HILLS, ',', '')}", units=units).length == 640.0


@pytest.mark.parametrize("above", ["", "x,z\n", "Instrument 3\nx,z\n"])
def test_without_a_unit_a_refusal_asks_for_it(above):
    with pytest.raises(DataError, match=r'^x has no unit; columns: .*call read_profile\(source, units=\{"x": ..., "z"'):
        read_profile(table(X, HILLS, heading=above))
    given = read_profile(table(X / 1e3, HILLS / 1e3, heading=above), unit="um")
    other = read_profile(table(X / 1e3, HILLS, heading=above), units={"x": "um", "z": "nm"})
    assert given.z == pytest.approx(other.z, abs=1e-12) and given.length == other.length
    assert given.length == pytest.approx(640.0) and np.ptp(given.z) == pytest.approx(8.0)
    with pytest.raises(DataError, match=r"^unit = 'parsec'; allowed units: nm"):
        read_profile(table(X, HILLS, heading=above), unit="parsec")


def test_a_unit_that_differs_from_that_of_the_file_is_refused():
    with pytest.raises(DataError, match=r"^unit = 'nm', but the file names um; leave it out"):
        read_profile(table(X, HILLS, heading="x (um),z (um)\n"), unit="nm")


def test_of_a_long_trace_the_middle_or_the_part_asked_for_is_used():
    x = np.linspace(0.0, 1.5e6, 60_001)
    text = table(x, 4.0 * np.cos(2.0 * np.pi * x / 1_000.0))
    middle, part = read_profile(text), read_profile(text, part=(1_000.0, 3_500.0))
    assert (middle.length, part.length) == pytest.approx((2_000.0, 2_500.0))
    assert any("nodes at least 91.6 nm apart" in note for note in middle.notes)
    for wrong in ((-1.0, 100.0), (100.0, 50.0), (0.0, 2e6)):
        with pytest.raises(DataError, match=r"^part = .*allowed: from 0 to 640 nm"):
            read_profile(table(X, HILLS), part=wrong)


# One message for one cause


def test_a_descending_scan_is_read_in_reverse_order():
    profile = read_profile(table(X[::-1], HILLS[::-1], heading="x (nm),z (nm)\n"))
    assert profile == read_profile(table(X, HILLS, heading="x (nm),z (nm)\n"))
    assert "x descends: the points are read in reverse order." in profile.notes


def test_exponents_of_fortran_are_read():
    rows = "\n".join(f"{x:.6E} {z:.6E}".replace("E", "D") for x, z in zip(X, HILLS, strict=True))
    assert read_profile(rows, unit="nm").z == pytest.approx(read_profile(table(X, HILLS)).z, abs=1e-5)


@pytest.mark.parametrize("missing", ["Bad", "***", "---", "", "nan"])
def test_short_gaps_are_bridged_and_long_ones_refused_with_their_place(missing):
    lines = table(X, HILLS, heading="x (nm),z (nm)\n").split("\n")

    def without(count):
        gone = [f"{line.split(',')[0]}, {missing}" for line in lines[50 : 50 + count]]
        return "\n".join([*lines[:50], *gone, *lines[50 + count :]])

    bridged = read_profile(without(5))
    assert any(note.startswith("5 rows without all numbers left out (line 51") for note in bridged.notes)
    heights = np.interp(X[:-1], np.arange(bridged.z.size) * 640.0 / bridged.z.size, np.roll(bridged.z, 0))
    assert np.ptp(heights) == pytest.approx(8.0, abs=0.1)
    with pytest.raises(DataError, match=r"^line 51: 6 rows in a row without all numbers; allowed: up to 5"):
        read_profile(without(6))


def test_an_overhang_and_a_matrix_are_named():
    x = X.copy()
    x[[30, 31, 60, 61]] = x[[31, 30, 61, 60]]
    with pytest.raises(DataError, match=r"sort the lines by x, if each x has one height: an overhang or a matrix"):
        read_profile(table(x, HILLS))
    with pytest.raises(DataError, match=r"which column is x .* if this is a map of heights, save one line"):
        read_profile("\n".join([" ".join(map(str, HILLS[:16]))] * 20))


@pytest.mark.parametrize("factor", [1e-3, 1e3])
def test_heights_in_a_wrong_unit_are_refused(factor):
    with pytest.raises(DataError, match=r"the heights have an rms of .* nm, allowed: 0\.01 .. 64 nm.*check the units"):
        read_profile(table(X, HILLS * factor))


# What is asked for


ASKED = {  # text that a refusal shows: {what is filled in for the dots of its call}
    "an index before the heights": ("Index,Height (um),Depth (um)", {"columns": {"x": 3}}),
    "another coordinate": ("x (um),y (um),y (um)", {"columns": {"z": 2}}),
    "no names": ("", {"columns": {"x": 3, "z": 2}, "units": {"x": "um", "z": "um"}}),
    "names of an unknown language": (
        "Nr,Höhe (um),Weg (um)",
        {"columns": {"x": "Weg", "z": "Höhe"}},
    ),
}


@pytest.mark.parametrize("what", ASKED)
def test_a_refusal_ends_in_the_call_that_reads_the_file_once_its_dots_are_filled(tmp_path, what):
    heading, dots = ASKED[what]
    rows = [f"{k},{z / 1e3!r},{x / 1e3!r}" for k, (x, z) in enumerate(zip(X.tolist(), HILLS.tolist(), strict=True))]
    if heading.startswith("x"):
        rows = [",".join([row.split(",")[2], row.split(",")[1], "0"]) for row in rows]
    file = tmp_path / "p.csv"
    file.write_text("\n".join([heading, *rows]), encoding="utf-8")
    with pytest.raises(DataError) as refused:
        read_profile(file)
    call = refused.value.call
    assert f'; call read_profile("{file}", columns={{"x": ' in str(refused.value)
    for argument, values in dots.items():
        assert all(call[argument][name] is ... for name in values)
        call[argument] |= values
    assert ... not in [value for values in call.values() for value in values.values()]
    assert read_profile(file, **call).z == pytest.approx(read_profile(table(X, HILLS)).z, abs=1e-9)


def test_points_too_far_apart_for_the_usual_part_are_read_by_the_part_that_is_named():
    x = 2300.0 * np.arange(500)
    with pytest.raises(
        DataError, match=r"points are 2300 nm apart: 20000 nm.*lattice period; call .*part=\("
    ) as refused:
        read_profile(table(x, 50.0 * np.sin(x / 14e3)))
    assert read_profile(table(x, 50.0 * np.sin(x / 14e3)), **refused.value.call).z.size >= 2 * FEWEST_POINTS


def test_numbers_of_a_unit_are_units_and_columns_that_do_not_exist_are_named():
    text = table(X / 3.0, HILLS, heading="")
    assert read_profile(text, units={"x": "3 nm", "z": "nm"}).length == pytest.approx(640.0)
    for columns, why in (
        ({"x": 3}, "is none of them"),
        ({"x": "a"}, "is none of them"),
        ({"F": 1}, r"columns has 'F'"),
    ):
        with pytest.raises(DataError, match=why):
            read_profile(text, unit="nm", columns=columns)


@pytest.mark.parametrize("options", [{}, {"periodic": False}, {"width": 500.0}, {"part": (50.0, 600.0)}])
@pytest.mark.parametrize("period", [True, False])
@pytest.mark.parametrize("seed", range(6))
def test_a_cut_off_that_is_named_is_one_that_works(seed, period, options):
    """Also where a filter leaves the ends, or the closing of a period, steep, and where points are uneven."""
    random = np.random.default_rng(seed)
    z = np.cumsum(random.normal(size=X.size)) * 2.0
    z = z - np.linspace(0.0, z[-1] - z[0], z.size) if period else z
    text = table(X + random.uniform(-0.5, 0.5, X.size) * (seed % 2), z)
    with pytest.raises(DataError, match="cut-off") as refused:
        read_profile(text, **options)
    if "cut_off" in refused.value.call:
        assert np.ptp(read_profile(text, **refused.value.call).z) > 0.0
    else:
        for cut_off in np.geomspace(10.0, 245.0, 12):
            with pytest.raises(DataError):
                read_profile(text, cut_off=float(cut_off), **options)
