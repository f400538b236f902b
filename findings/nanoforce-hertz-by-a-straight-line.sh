#!/usr/bin/env bash
# nanoforce fits Hertz's F = 4/3 E/(1 - nu^2) sqrt(R) d^1.5 by a straight line through zero, and takes the line's force
# at the largest depth for the measured one. An exact Hertz curve with evenly spaced depths gives 6/7 of its modulus,
# one whose points lie closer together near the contact less (14/17 here): it depends on how one samples. Its cone
# (Sneddon), fitted by the root of the force, is exact. The wheel requires a package that is a name without content, so
# its real dependencies are installed here; with NumPy 2.4 it ends with a ValueError.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet numpy==2.3.5 scipy==1.17.1 pandas==3.1.1 plotly==7.1.0 seaborn==0.13.2 \
    scikit-learn==1.9.1 easygui==0.98.3 NSFopen==2.2.4
"$folder/venv/bin/pip" install --quiet --no-deps nanoforce==0.3.32
cd "$folder"
venv/bin/python - <<'PY'
import numpy as np
from nanoforce import nanoforce

E, nu, R = 1e6, 0.5, 1e-6  # Pa, -, m


def found(depth, force, name, **options):
    """The modulus over the true one, from depths (m) and forces (N)."""
    curve = nanoforce.AFM()
    curve.run_name = name
    curve.z_approach, curve.approach = -1e9 * depth[::-1, None], 1e9 * force[::-1, None]
    (curve.calc_modulus if "indenter_radius" in options else curve.calc_modulus_sneddon)(poisson_ratio=nu, **options)
    return curve.modulus[0] * 1e6 / E


even = np.linspace(0.0, 500e-9, 4001)
early = 500e-9 * np.linspace(0.0, 1.0, 4001) ** 3
sphere = [
    found(depth, 4.0 / 3.0 * E / (1.0 - nu**2) * np.sqrt(R) * depth**1.5, "sphere", indenter_radius=R)
    for depth in (even, early)
]
cone = found(even, 2.0 / np.pi * np.tan(np.radians(35.0)) * E / (1.0 - nu**2) * even**2, "cone", opening_angle=35)
print(f"sphere, even depths {sphere[0]:.4f} (6/7 = {6 / 7:.4f}), closer near the contact {sphere[1]:.4f}")
print(f"cone {cone:.6f}")
assert abs(sphere[0] - 6.0 / 7.0) < 1e-3 and abs(sphere[1] - 14.0 / 17.0) < 1e-3 and abs(cone - 1.0) < 1e-6
PY
