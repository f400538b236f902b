"""Files of instruments, through SurfaceTopography: written here by that package, or by hand."""

import struct
import sys

import numpy as np
import pytest
from SurfaceTopography import Topography, UniformLineScan

from solver import DataError, read_profile
from solver.measured.instruments import is_instruments, read_line
from solver.measured.periodic import ALPHA, least_cut_off, smoothed
from solver.measured.units import measure

X = np.arange(400) * 2.5  # nm
HILLS = 4.0 * np.cos(2.0 * np.pi * X / 250.0)


@pytest.fixture
def written(tmp_path):
    """The bytes of a file that a surface writes."""

    def write(surface):
        surface.to_netcdf(tmp_path / "surface.nc")
        return (tmp_path / "surface.nc").read_bytes()

    return write


@pytest.mark.parametrize(("unit", "nm"), [("nm", 1.0), ("µm", 1e3), ("mm", 1e6)])
def test_a_line_is_read_in_its_unit(written, unit, nm):
    content = written(UniformLineScan(HILLS / nm, 1000.0 / nm, unit=unit))
    assert is_instruments(content)
    profile = read_profile(content)
    assert profile.length == pytest.approx(1000.0, rel=1e-6) and np.ptp(profile.z) == pytest.approx(8.0, rel=1e-6)
    assert "1000 nm long, 8 nm high, 400 points" in profile.notes[0]


def test_of_a_map_the_row_through_the_highest_point_is_read_or_the_one_asked_for(written):
    heights = np.outer(HILLS, np.linspace(0.2, 1.0, 32))  # x first
    content = written(Topography(heights, (1000.0, 80.0), unit="nm"))
    assert np.ptp(read_profile(content).z) == pytest.approx(8.0)
    assert np.ptp(read_profile(content, line="row 0").z) == pytest.approx(1.6)
    assert read_line(content, line="column 3")[1] == pytest.approx(heights[3])
    for wrong in ("row 32", "column 400", "diagonal"):
        with pytest.raises(DataError, match=rf"^line = '{wrong}': allowed: row 0 .. 31 or column 0 .. 399"):
            read_profile(content, line=wrong)


def test_a_file_without_a_unit_asks_for_it_and_two_units_are_refused(written):
    content = written(UniformLineScan(HILLS, 1000.0))
    with pytest.raises(DataError, match=r"names no unit of length; give it, as in unit='um'"):
        read_profile(content)
    assert read_profile(content, unit="nm").length == pytest.approx(1000.0)
    with pytest.raises(DataError, match=r"^unit = 'um', but the file names nm"):
        read_profile(written(UniformLineScan(HILLS, 1000.0, unit="nm")), unit="um")


def test_missing_points_are_bridged_up_to_five(written):
    heights = np.outer(HILLS, np.ones(8))
    for count, said in ((5, None), (6, r"^6 rows in a row without all numbers; allowed: up to 5")):
        masked = np.ma.masked_array(heights, np.zeros(heights.shape, bool))
        masked[40 : 40 + count] = np.ma.masked
        content = written(Topography(masked, (1000.0, 20.0), unit="nm"))
        if said:
            with pytest.raises(DataError, match=said):
                read_profile(content)
        else:
            assert f"{count} missing points left out." in read_profile(content).notes


def test_an_unknown_file_and_a_missing_package_are_refused_with_a_remedy(monkeypatch):
    with pytest.raises(DataError, match=r"^no known file of an instrument \(.*\); export it as CSV"):
        read_profile(b"\0\1\2" * 100)
    monkeypatch.setitem(sys.modules, "SurfaceTopography", None)
    with pytest.raises(DataError, match=r'pip install "mixed-mode-contact\[instruments\]"$'):
        read_profile(b"\0\1\2" * 100)


def igor_wave(columns):
    """The bytes of a binary wave of Igor, version 5, of columns of heights (m), 2.5 nm apart."""
    n, count = columns[0].size, len(columns)
    header = struct.pack("<iIIi2h6sh32s2i4i8d4s16s", 0, 0, 0, n * count, 4, 0, b"", 1, b"wave", 0, 0, n, count, 0, 0,
                         2.5e-9, *[1.0] * 3, *[0.0] * 4, b"m", b"m")  # fmt: skip
    header += bytes(320 - len(header))
    sizes = struct.pack("<4i8i3i", 320 + 8 * n * count, 0, 0, 0, *[0] * 8, 0, 0, 0)
    whole = np.frombuffer(struct.pack("<2h", 5, 0) + sizes + header, "<i2")
    return (
        struct.pack("<Hh", 5, (-int(whole.sum()) + 2**15) % 2**16 - 2**15)
        + sizes
        + header
        + b"".join(column.astype("<f8").tobytes() for column in columns)
    )


def test_of_several_channels_one_is_asked_for():
    """The columns of a binary wave of Igor are channels, not lines of a map."""
    content = igor_wave([0.5e-9 * HILLS, 1e-9 * HILLS])
    with pytest.raises(DataError, match=r"^2 channels: 1 '.*', 2 '.*'; call read_profile\(source, channel=...\)$"):
        read_profile(content)
    for channel, height in ((1, 4.0), ("2", 8.0)):
        assert np.ptp(read_profile(content, channel=channel).z) == pytest.approx(height)
    with pytest.raises(DataError, match=r"^channel = 3: allowed: 1 '.*', 2 '.*'; give one of these"):
        read_profile(content, channel=3)


@pytest.mark.parametrize(
    ("content", "what"),
    [
        (b"PK\3\4\0\0surface/main.xml\0", "an X3P in a folder; zip the files without their folder"),
        (b"DSCOMPRESSED\0\0", "a compressed SUR; save it without compression"),
        (b"PK\3\4\0\0a.csv\0", "an archive without a known file; unpack it"),
    ],
)
def test_what_the_library_cannot_read_is_named_with_what_can_be_done(content, what):
    with pytest.raises(DataError, match=f"^(this is )?{what}"):
        read_profile(content)


# The Gaussian filter


def test_a_wave_as_long_as_the_cut_off_keeps_half_of_its_amplitude():
    for wavelength in (25.0, 50.0, 100.0):
        z = np.sin(2.0 * np.pi * X / wavelength)
        expected = np.exp(-np.pi * (ALPHA * 50.0 / wavelength) ** 2)
        assert np.ptp(smoothed(z, 2.5, 50.0, periodic=True)) / np.ptp(z) == pytest.approx(expected, rel=1e-3)
    assert np.exp(-np.pi * ALPHA**2) == pytest.approx(0.5, rel=1e-12)


def test_a_constant_stays_also_at_the_ends():
    assert smoothed(np.full(50, 3.0), 1.0, 10.0) == pytest.approx(3.0, rel=1e-12)


def test_a_steep_profile_names_a_cut_off_that_then_works():
    random = np.random.default_rng(0)
    rows = "".join(f"{x},{z:.9g}\n" for x, z in zip(X, HILLS + 2.0 * random.normal(size=X.size), strict=True))
    text = f"x (nm),z (nm)\n{rows}"
    with pytest.raises(DataError, match=r"a cut-off of .* nm makes it flat enough") as refused:
        read_profile(text)
    cut_off = refused.value.call["cut_off"]
    assert str(refused.value).endswith(f"; call read_profile(source, cut_off={cut_off:g})")
    profile = read_profile(text, cut_off=cut_off)
    assert any(note.startswith(f"A Gaussian filter with a cut-off of {cut_off:g} nm changed") for note in profile.notes)
    with pytest.raises(DataError, match=r"^cut_off = 1: allowed: 5 .. 498.8 nm"):
        read_profile(text, cut_off=1.0)
    assert least_cut_off(1e3 * np.arange(50) % 7e3, 1.0, 0.3) is None


def test_a_micro_sign_that_a_writer_and_a_reader_encode_differently_is_known():
    """surfalize writes it in UTF-8, SurfaceTopography reads Latin-1: findings/surfalize-sur-in-another-reader.sh."""
    assert measure("\u00c2\u00b5m") == (1e3, "nm")
