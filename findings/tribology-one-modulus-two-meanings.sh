#!/usr/bin/env bash
# In tribology the effective modulus of `eeff` is twice the contact modulus of Hertz's theory. The half-axes and the
# pressure expect that; the approach `dhertz`, by its name and the same argument, expects the contact modulus itself. So
# one modulus gives the right contact and 0.63 (2^-2/3) of the approach: it is not a^2/R. A flat is a radius of 0 for
# `reff`, inf for `dhertz`, where 0 divides by zero. The half-axes "in x" and "in y" do not follow the radii: turned by
# 90 degrees, the contact is as long in the same direction. Its pins ask for NumPy of 2019, so it is installed without.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet numpy==2.4.6 scipy==1.17.1 numexpr==2.14.1 matplotlib==3.11.2 pillow==13.0.0 \
    opencv-python-headless==5.0.0.93 setuptools==80.9.0
"$folder/venv/bin/pip" install --quiet --no-deps tribology==0.5.16
cd "$folder"
venv/bin/python -W ignore - <<'PY'
from math import inf, isclose, pi

from tribology import ahertz, dhertz, eeff, phertz, reff

E, nu, R, F = 70e9, 0.3, 1e-3, 1.0  # Pa, -, m, N: a sphere on a rigid flat
contact, found = E / (1.0 - nu**2), eeff(E, nu, 1e30, nu)
print(f"eeff over the contact modulus: {found / contact:.6f}")
assert isclose(found, 2.0 * contact)

radii = reff(R, R, inf, inf)
assert radii == reff(R, R, 0, 0)
a, _, _ = ahertz(*radii, found, F)
hertz = (3.0 * F * R / (4.0 * contact)) ** (1.0 / 3.0)
peak = phertz(*radii, found, F, ret="max")
print(f"radius of the contact {a:.6e} m (Hertz {hertz:.6e}), largest pressure {peak:.6e} Pa")
assert isclose(a, hertz) and isclose(peak, 3.0 * F / (2.0 * pi * hertz**2))

near = dhertz(found, R, R, inf, inf, F)
print(f"dhertz {near:.6e} m, a^2/R {a * a / R:.6e}, ratio {near / (a * a / R):.6f}")
assert isclose(near / (a * a / R), 2.0 ** (-2.0 / 3.0))
assert isclose(dhertz(found / 2.0, R, R, inf, inf, F), a * a / R)
try:
    raise SystemExit(f"dhertz of a flat of radius 0: {dhertz(found, R, R, 0, 0, F)}")
except ZeroDivisionError as error:
    print(f"dhertz of a flat of radius 0: {error!r}")

along, across = ((ahertz(*reff(*both, inf, inf), found, F)[:2]) for both in ((R, 4.0 * R), (4.0 * R, R)))
print("half-axes in x and y, m:", *(f"{one:.3e}" for one in along), "and turned", *(f"{one:.3e}" for one in across))
assert along == across and along[0] < along[1]
PY
