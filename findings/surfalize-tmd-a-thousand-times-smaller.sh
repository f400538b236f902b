#!/usr/bin/env bash
# TrueMap's .tmd has no field for a unit: lengths and heights are in mm, as GelSight's own reader says. surfalize takes
# them for um, in both directions and without a word. So a map of 30 x 10 um that it writes is one of 30 x 10 mm in
# SurfaceTopography, and a scan of 30 x 10 mm, written here byte by byte as a device does, is one of 30 x 10 um in
# surfalize. Since heights go along, all slopes agree and the picture looks right; but in surfalize rms height is a
# thousand times less and curvature a thousand times more, so that a work of adhesion, which a model compares with
# stiffness times a length, counts a thousand times more. mm would be right in both.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet surfalize==0.19.2 SurfaceTopography==1.27.1 numpy==2.4.6
cd "$folder"
venv/bin/python -W ignore - <<'PY'
import struct
from importlib.metadata import version

import numpy as np
from SurfaceTopography import open_topography
from surfalize import Surface

print("surfalize", version("surfalize"), "SurfaceTopography", version("SurfaceTopography"))
um = {"mm": 1e3, "\u00b5m": 1.0, "m": 1e6}
heights = np.random.default_rng(1).normal(size=(40, 60))
heights *= 0.5 / heights.std()


def both(name):
    own = Surface.load(name)
    with open_topography(name) as file:
        peer = file.topography()
    ours = own.step_x * own.size.x, own.step_y * own.size.y, own.data.std()
    theirs = [um[peer.unit] * float(v) for v in (*peer.physical_sizes, np.asarray(peer.heights()).std())]
    slopes = own.data.std() / own.step_x, np.asarray(peer.heights()).std() / peer.pixel_size[0]
    for reader, (x, y, z) in (("surfalize", ours), ("SurfaceTopography", theirs)):
        print(f"  {reader}: {x:g} x {y:g} um, rms height {z:.3g} um")
    assert np.allclose(theirs, np.multiply(ours, 1000.0), rtol=1e-5), (ours, theirs)
    assert np.isclose(*slopes, rtol=1e-5), slopes
    return ours, theirs


print("30 x 10 um, rms 0.5 um, written by surfalize:")
Surface(heights, 0.5, 0.25).save("um.tmd")
ours, theirs = both("um.tmd")
assert np.allclose(ours, (30.0, 10.0, 0.5), rtol=1e-5)

print("30 x 10 mm, rms 0.5 mm, in the mm of the format:")
with open("mm.tmd", "wb") as file:
    file.write(b"Binary TrueMap Data File v2.0\r\n\0" + b"Created by TrueMap v6\r\n\0")
    file.write(struct.pack("<IIffff", 60, 40, 30.0, 10.0, 0.0, 0.0) + heights.astype("<f4").tobytes())
ours, theirs = both("mm.tmd")
assert np.allclose(theirs, (30e3, 10e3, 500.0), rtol=1e-5)
print("as found: the same file is a thousand times smaller in one reader, with the same slopes")
PY
