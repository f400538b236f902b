#!/usr/bin/env bash
# Where a map has no height, ISO 25178-71 (.sdf) writes the lowest number of its type. SurfaceTopography takes it for a
# height: of a map of a few um with 15 missing points the lowest height is -1.8e308 um, nothing is masked, and its rms
# height is infinite. The same map in .x3p has 15 masked points. surfalize, which wrote both, reads both right.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet surfalize==0.19.2 SurfaceTopography==1.27.1 numpy==2.4.6
cd "$folder"
venv/bin/python -W ignore - <<'PY'
import numpy as np
from surfalize import Surface
from SurfaceTopography import open_topography

y, x = np.mgrid[:40, :60]
z = 5.0 + np.sin(2.0 * np.pi * x / 60.0)  # um
z[18:23, 10:13] = np.nan
seen = {}
for kind in ("sdf", "x3p"):
    Surface(z, 0.5, 0.25).save(f"map.{kind}")
    assert np.isnan(Surface.load(f"map.{kind}").data).sum() == 15
    there = open_topography(f"map.{kind}").topography()
    heights = there.heights()
    lowest = float(np.min(heights)) * {"m": 1e6, "µm": 1.0}[there.unit]
    seen[kind] = np.ma.count_masked(heights), lowest, float(there.rms_height_from_area())
    print(kind, "masked {}, lowest {:.3g} um, rms height {:.3g}".format(*seen[kind]), there.unit)
assert seen["sdf"][0] == 0 and seen["sdf"][1] < -1e300 and np.isinf(seen["sdf"][2])
assert seen["x3p"][0] == 15 and abs(seen["x3p"][1] - 4.0) < 0.01
PY
