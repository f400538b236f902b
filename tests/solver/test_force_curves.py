"""Force curves of microscopes, through afmformats: a file in its own HDF5, and an archive of JPK without a spring."""

import io
import sys
import zipfile

import h5py
import numpy as np
import pytest

from app.features.files.tasks import Chosen, look
from solver import DataError, Scene, read_measurement, read_profile

DEPTH = np.concatenate([np.linspace(-200.0, 20.0, 111), np.linspace(20.0, -200.0, 111)])  # nm
FORCE = np.where(DEPTH > 0.0, 0.1 * DEPTH, 0.0)  # nN
SEGMENT = np.repeat([0, 1], 111)
COLUMNS = {"force": 1e-9 * FORCE, "height (measured)": 1e-6 - 1e-9 * DEPTH, "segment": SEGMENT}
PIEZO, TIP = (
    {"force": COLUMNS["force"], name: COLUMNS["height (measured)"]} for name in ("height (piezo)", "tip position")
)


def hdf5(curves=1, mode="force-distance", spring=0.5, columns=COLUMNS):
    """The bytes of a file with that many curves, each larger than the one before."""
    stream = io.BytesIO()
    with h5py.File(stream, "w") as file:
        file.attrs["software"], file.attrs["software version"] = "afmformats", "0.18"
        for k in range(curves):
            group = file.create_group(f"{k}")
            group.attrs.update({"imaging mode": mode, "enum": k, "spring constant": spring, "point count": DEPTH.size})
            for name, column in columns.items():
                group[name] = (k + 1 if name == "force" else 1) * column
    return stream.getvalue()


def test_a_force_curve_is_a_load_over_approach_in_segments():
    found = read_measurement(Scene(), hdf5(), deflection=0.5)
    assert (found.kind, [segment.name for segment in found.segments]) == ("load", ["approach", "retract"])
    approach = found.segments[0]
    assert approach.values["L"] == pytest.approx(1e-9 * FORCE[:111], abs=1e-15) and found.units["L"] == "N"
    assert np.ptp(approach.x) == pytest.approx(220.0 - 2.0 / 0.5, rel=1e-6)


def test_of_several_force_curves_one_is_asked_for():
    with pytest.raises(DataError, match=r"^2 force curves: 1 'curve 1', .*; call .*, channel=...\)$"):
        read_measurement(Scene(), hdf5(2))
    assert read_measurement(Scene(), hdf5(2), channel=2).segments[0].values["L"].max() == pytest.approx(4e-9)
    with pytest.raises(DataError, match=r"^channel = 3: allowed: 1 'curve 1', 2 'curve 2'; give one"):
        read_measurement(Scene(), hdf5(2), channel=3)


def test_segments_that_a_mode_only_counts_are_found_by_the_turns_of_the_height():
    found = read_measurement(Scene(), hdf5(mode="creep-compliance"))
    assert [segment.name for segment in found.segments] == ["approach", "retract"]


def test_the_page_reads_a_force_curve_and_fills_in_its_lever():
    seen, curve = look(Scene(), hdf5(), Chosen())
    assert curve.kind == "load" and seen["deflection"] == 0.5 and not seen["why"]
    assert set(look(Scene(), hdf5(2), Chosen())[0]["channels"]) == {"1", "2"}


def test_what_is_no_force_curve_and_no_surface_is_refused_with_a_remedy(monkeypatch):
    archive = io.BytesIO()
    with zipfile.ZipFile(archive, "w") as file:
        for name in ("header.properties", "segments/", "segments/0/"):
            file.writestr(name, "")
        file.writestr("segments/0/segment-header.properties", "force-segment-header.num-points=100")
    with pytest.raises(DataError, match=r"\(.*\); export (its columns|columns of it) as text"):
        read_measurement(Scene(), archive.getvalue())
    with pytest.raises(DataError, match=r"^this is a force curve, no surface; read it as a curve, by read_measurement"):
        read_profile(hdf5())
    with pytest.raises(DataError, match=r"^this is no table in text, and no force curve of a known format"):
        read_measurement(Scene(), b"\0\1\2" * 100)
    monkeypatch.setitem(sys.modules, "afmformats", None)
    with pytest.raises(DataError, match=r'pip install "mixed-mode-contact\[instruments\]"$'):
        read_measurement(Scene(), hdf5())


UNREAD = {  # name: (content, what the refusal says)
    "another mode": (hdf5(mode="topography", columns={"z": DEPTH}), "this file of force curves cannot be read"),
    "an unknown column": (hdf5(columns={"z": DEPTH}), "this file of force curves cannot be read"),
    "cut off": (hdf5()[:-500], "this file of force curves cannot be read"),
    "an Igor wave of some bytes": (b"\5\0SpringConstantDefl", "this file of force curves cannot be read"),
    "no points": (hdf5(columns={name: column[:0] for name, column in COLUMNS.items()}), "curve 1 of 1 has no points"),
}


@pytest.mark.parametrize("name", UNREAD)
def test_a_file_that_the_library_rejects_is_refused_in_one_sentence_by_function_and_page(name):
    content, said = UNREAD[name]
    with pytest.raises(DataError, match=said):
        read_measurement(Scene(), content)
    seen, curve = look(Scene(), content, Chosen())
    assert curve is None and said in seen["why"] and "1 V" not in seen["why"]


def test_a_curve_without_segments_is_read():
    found = read_measurement(Scene(), hdf5(columns={k: COLUMNS[k] for k in ("force", "height (measured)")}))
    assert [segment.name for segment in found.segments] == ["approach", "retract"]


@pytest.mark.parametrize("columns", [PIEZO, TIP])
def test_another_height_is_read_as_a_load_where_none_is_measured(columns):
    found = read_measurement(Scene(), hdf5(columns=columns))
    assert found.kind == "load" and np.ptp(found.segments[0].x) == pytest.approx(220.0)
    seen, curve = look(Scene(), hdf5(columns=columns), Chosen())
    assert curve.kind == "load" and seen["deflection"] == (0.5 if columns is PIEZO else None)
    both = read_measurement(Scene(), hdf5(columns=COLUMNS | {name: 2.0 * column for name, column in columns.items()}))
    assert np.ptp(both.segments[0].x) == pytest.approx(220.0)


@pytest.mark.parametrize("heights", ["height (measured)\theight (piezo)", "height (piezo)\ttip position"])
def test_of_two_heights_in_a_text_the_measured_one_is_read_or_one_is_asked_for(heights):
    rows = zip(0.1 * np.clip(DEPTH, 0.0, None), 1e3 - DEPTH, 2e3 - 2.0 * DEPTH, np.arange(222), strict=True)
    text = "\n".join([f"# force\t{heights}\ttime", *("\t".join(f"{a:.9g}" for a in row) for row in rows)])
    units = {"L": "nN", "delta": "nm"}
    if "measured" in heights:
        assert np.ptp(read_measurement(Scene(), text, units=units).segments[0].x) == pytest.approx(220.0)
    with pytest.raises(DataError, match=r'columns=\{"delta": \.\.\., "L": "force"\}|delta has no unit') as refused:
        read_measurement(Scene(), text)
    call = refused.value.call | {"columns": {"delta": 3, "L": "force"}, "units": units}
    assert np.ptp(read_measurement(Scene(), text, **call).segments[0].x) == pytest.approx(440.0)


def test_a_tip_position_has_no_lever_in_it():
    assert not any("lever" in note for note in read_measurement(Scene(), hdf5(columns=TIP)).notes)
    with pytest.raises(DataError, match=r"a separation has no lever in it; leave it out$"):
        read_measurement(Scene(), hdf5(columns=TIP), deflection=0.5)


def test_a_force_curve_without_a_height_is_asked_for_as_a_load():
    with pytest.raises(DataError, match=r'kind="load", columns=\{"delta": \.\.\., "L": "force"\}'):
        read_measurement(Scene(), hdf5(columns={"force": COLUMNS["force"], "time": np.arange(222.0)}))
