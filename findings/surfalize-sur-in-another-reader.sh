#!/usr/bin/env bash
# A map of heights from 5 to 8 um that surfalize writes as .sur comes back from SurfaceTopography as -1.5 to 1.5 um: the
# offset of the heights is left out, without a word. Its unit is the four bytes of the micro sign in UTF-8, read one by
# one, so that a table of units does not know it. surfalize itself reads 5 to 8.
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

heights = np.add.outer(np.linspace(0.0, 1.0, 40), np.linspace(0.0, 2.0, 60)) + 5.0  # um
Surface(heights, 0.5, 0.25).save("map.sur")
own = Surface.load("map.sur").data
other = SurfaceTopography.open_topography("map.sur").topography()
found = np.asarray(other.heights())
print(f"surfalize {own.min():.3f} .. {own.max():.3f} um")
print(f"SurfaceTopography {found.min():.3f} .. {found.max():.3f} {other.unit!r}")
assert abs(own.min() - 5.0) < 1e-6 and abs(own.max() - 8.0) < 1e-6
assert abs(found.min() + 1.5) < 1e-6 and abs(found.max() - 1.5) < 1e-6
assert other.unit != "\u00b5m" and other.unit.encode("latin-1").decode("utf-8") == "\u00b5m"
print("as found: the zero of heights and the unit are lost between the two")
PY
