#!/usr/bin/env bash
# AFMReader (the reader of TopoStats) cuts the heights of a .gwy map into rows as long as the map is high. A step across
# a map of 60 x 40 square pixels of 50 nm comes back as stripes: 60 rows of 40 points, with pixels of 75 nm, without a
# word. Only a square map is right. A second surprise is in the same call: the unit of the heights is not looked at.
# Whatever the channel holds is multiplied by 1e9 since x and y are in metres, so that a friction signal of 0.25 V is
# 250000000, as if it were nm. Right are 40 rows of 60 points, 50 nm apart, as in gwyfile and SurfaceTopography, and
# volts that stay volts.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet AFMReader==0.0.7 gwyfile==0.3.0 SurfaceTopography==1.27.1 numpy==2.4.6
cd "$folder"
venv/bin/python -W ignore - 2>messages <<'PY' || { cat messages; exit 1; }
from importlib.metadata import version

import gwyfile
import numpy as np
from AFMReader.gwy import load_gwy
from gwyfile.objects import GwyContainer, GwyDataField
from SurfaceTopography import open_topography


def write(name, values, unit):
    rows, columns = values.shape
    written = GwyContainer()
    written["/0/data"] = GwyDataField(values, xreal=50e-9 * columns, yreal=50e-9 * rows, si_unit_xy="m", si_unit_z=unit)
    written["/0/data/title"] = "Channel"
    written.tofile(name)


print("AFMReader", version("AFMReader"))
step = 8e-9 * (np.arange(60) >= 30) * np.ones((40, 1))  # 40 rows of 60 points, low on the left and high on the right
write("step.gwy", step, "m")
own = gwyfile.util.get_datafields(gwyfile.load("step.gwy"))["Channel"].data
with open_topography("step.gwy") as file:
    peer = file.topography()
found, pixel = load_gwy("step.gwy", "Channel")
jumps = int(np.count_nonzero(np.diff(np.asarray(found), axis=0).any(axis=1)))
print(f"gwyfile: {own.shape}; SurfaceTopography: {peer.nb_grid_pts}, pixel {1e9 * peer.pixel_size[0]:.0f} nm")
print(f"AFMReader: {found.shape}, pixel {pixel:.0f} nm, {jumps} of 59 rows differ from the one before")
assert np.array_equal(own, step) and np.array_equal(np.asarray(peer.heights()), step.T)
assert peer.nb_grid_pts == (60, 40) and abs(1e9 * peer.pixel_size[0] - 50.0) < 1e-6
assert found.shape == (60, 40) and abs(pixel - 75.0) < 1e-6
assert np.allclose(found.ravel(), 1e9 * step.ravel()) and jumps == 59, jumps

square = 8e-9 * (np.arange(40) >= 20) * np.ones((40, 1))
write("square.gwy", square, "m")
found, pixel = load_gwy("square.gwy", "Channel")
print(f"AFMReader, square: {found.shape}, pixel {pixel:.0f} nm")
assert np.allclose(found, 1e9 * square) and abs(pixel - 50.0) < 1e-6

write("friction.gwy", np.full((40, 40), 0.25), "V")
found, pixel = load_gwy("friction.gwy", "Channel")
print(f"AFMReader, 0.25 V: {found.min():.0f}")
assert np.allclose(found, 2.5e8)
print("as found: rows of a map that is not square are mixed, and volts pass for metres")
PY
