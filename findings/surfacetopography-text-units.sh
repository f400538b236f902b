#!/usr/bin/env bash
# SurfaceTopography: of a text file with two columns the reader takes the numbers and leaves the heading, also where it
# names units: x in um and z in nm come back with unit None, in one common scale, without a warning. A line of 128 points
# 2.5 apart is 320 long, not 317.5: it is measured as one period.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet SurfaceTopography==1.27.1
cd "$folder"
venv/bin/python - <<'PY'
import warnings
import numpy as np
import SurfaceTopography

x = 2.5 * np.arange(128)
z = 3.0 * np.sin(2.0 * np.pi * x / 320.0)
rows = "".join(f"{a:.9g},{b:.9g}\n" for a, b in zip(x, z))
print("SurfaceTopography", SurfaceTopography.__version__)
for heading in ("x (um),z (nm)", "x [um],z [um]", "# x (um), z (um)"):
    with open("line.csv", "w") as file:
        file.write(heading + "\n" + rows)
    with warnings.catch_warnings(record=True) as warned:
        warnings.simplefilter("always")
        line = SurfaceTopography.read_topography("line.csv")
    about_units = [w for w in warned if "unit" in str(w.message).lower()]
    print(f"{heading!r}: unit {line.unit}, length {line.physical_sizes[0]:g}, periodic {line.is_periodic}")
    assert line.unit is None and not about_units
    assert abs(line.physical_sizes[0] - 320.0) < 1e-6 and not line.is_periodic
print("as found: units of a heading are dropped, and n points are n spacings long")
PY
