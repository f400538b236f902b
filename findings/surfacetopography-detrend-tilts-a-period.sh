#!/usr/bin/env bash
# SurfaceTopography: detrend() of a *periodic* line fits a slope by default and subtracts it. A whole period of a sine has
# such a slope by least squares, so a third of its roughness goes, and the result is no longer periodic: its ends differ
# in height. Only detrend_mode="center" leaves a period as it is.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet SurfaceTopography==1.27.1
cd "$folder"
venv/bin/python - <<'PY'
import numpy as np
import SurfaceTopography

x = 2.5 * np.arange(128)
line = SurfaceTopography.UniformLineScan(3.0 * np.sin(2.0 * np.pi * x / 320.0), 320.0, periodic=True, unit="nm")
print("SurfaceTopography", SurfaceTopography.__version__)
usual, centred = line.detrend(), line.detrend(detrend_mode="center")
for name, each in (("as given", line), ("detrend()", usual), ('detrend(detrend_mode="center")', centred)):
    step = each.heights()[-1] - each.heights()[0]
    print(f"{name}: rms {each.rms_height_from_profile():.4f} nm, last less first height {step:.3f} nm,"
          f" periodic {each.is_periodic}")
ratio = usual.rms_height_from_profile() / line.rms_height_from_profile()
assert abs(ratio - 0.6263) < 1e-3 and line.is_periodic and not usual.is_periodic
assert abs(centred.rms_height_from_profile() / line.rms_height_from_profile() - 1.0) < 1e-9
print(f"as found: detrend() leaves {ratio:.3f} of the rms height of a period")
PY
