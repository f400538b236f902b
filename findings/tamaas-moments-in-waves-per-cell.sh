#!/usr/bin/env bash
# In tamaas two statistics of one class count wave numbers otherwise: the rms slope in radians over the cell, spectral
# moments in waves per cell. So sqrt(m2) of a profile is its slope over 2 pi, and m4 lacks (2 pi)^4; in 2D the slope is
# 2 pi sqrt(2 m2). Ratios such as Nayak's m0 m4/m2^2 are the same either way, so that they do not show it. m0 is the
# variance over all points, the square of the rms height that over one point less.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet tamaas==2.9.0 numpy==2.4.6
cd "$folder"
venv/bin/python - <<'PY'
import numpy as np
from tamaas import Statistics1D, Statistics2D

points, waves = 256, 3
line = np.cos(2.0 * np.pi * waves * np.arange(points) / points)
exact = 2.0 * np.pi * waves / np.sqrt(2.0)  # rms slope in a cell of length 1
slope, (m0, m2, m4) = Statistics1D.computeSpectralRMSSlope(line), Statistics1D.computeMoments(line)
print(f"line: rms slope {slope:.6f} (exact {exact:.6f}), sqrt(m2) {np.sqrt(m2):.6f}, m4 {m4:.6f}")
assert np.isclose(slope, exact) and np.isclose(np.sqrt(m2), exact / (2.0 * np.pi)) and np.isclose(m4, waves**4 / 2.0)

height = Statistics1D.computeRMSHeights(line)
print(f"line: m0 {m0:.6f}, rms height squared {height**2:.6f}")
assert np.isclose(m0, 0.5) and np.isclose(height**2, 0.5 * points / (points - 1))

area = line[:, None] + line[None, :]
slope, (_, m2, _) = Statistics2D.computeSpectralRMSSlope(area), Statistics2D.computeMoments(area)
print(f"area: rms slope {slope:.6f}, sqrt(2 m2) {np.sqrt(2.0 * m2):.6f}, ratio {slope / np.sqrt(2.0 * m2):.6f}")
assert np.isclose(slope, np.sqrt(2.0) * exact) and np.isclose(slope / np.sqrt(2.0 * m2), 2.0 * np.pi)
PY
