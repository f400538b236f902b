#!/usr/bin/env bash
# The same .sdf and .al3d file of 60 x 40 points, 0.5 and 0.25 um apart, is 29.5 x 9.75 um in surfalize (from the first
# point to the last) and 30 x 10 um in SurfaceTopography (each point has a pixel). A length or a wavelength over the
# length that one prints is not that of the other.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet surfalize==0.19.2 SurfaceTopography==1.27.1
cd "$folder"
venv/bin/python -W ignore - <<'PY'
import numpy as np
import SurfaceTopography
from surfalize import Surface

heights = np.random.default_rng(1).normal(size=(40, 60))
for suffix in ("sdf", "al3d"):
    Surface(heights, 0.5, 0.25).save(f"map.{suffix}")
    own = Surface.load(f"map.{suffix}")
    other = SurfaceTopography.open_topography(f"map.{suffix}").topography()
    um = {"m": 1e6, "\u00b5m": 1.0}[other.unit]
    sizes = [float(size) * um for size in other.physical_sizes]
    print(f"{suffix}: surfalize {own.width_um:g} x {own.height_um:g} um, SurfaceTopography {sizes[0]:g} x {sizes[1]:g} um")
    assert (round(own.width_um, 6), round(own.height_um, 6)) == (29.5, 9.75)
    assert np.allclose(sizes, (30.0, 10.0))
print("as found: n - 1 spacings in one, n in the other")
PY
