#!/usr/bin/env bash
# SciPy's elementwise find_root calls the function with those elements only that are not found yet. A function that
# uses an array of its own beside x works as long as all elements converge in the same step, as on a test case, and
# ends in a broadcasting error on data where some converge before others. Such arrays belong in args=, which are
# thinned along with x.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet scipy==1.17.1 numpy==2.4.6 2>/dev/null
cd "$folder"
venv/bin/python - <<'PY'
import numpy as np
import scipy
from scipy.optimize.elementwise import find_root


def zeros(pull, given):
    ends = np.zeros(pull.shape), np.ones(pull.shape)
    if given:
        return find_root(lambda n, p: n - 0.5 + p * n * np.exp(-n), ends, args=(pull,))
    return find_root(lambda n: n - 0.5 + pull * n * np.exp(-n), ends)


alike, data = np.full(5, 0.3), np.linspace(0.0, 50.0, 5)  # springs of equal and of different strength
assert zeros(alike, False).success.all() and zeros(data, True).success.all()
print("scipy", scipy.__version__, "- equal elements: found with and without args")
try:
    zeros(data, False)
    raise SystemExit("found: changed")
except ValueError as error:
    print("different elements without args:", error)
    assert "broadcast" in str(error)
PY
echo "as found: elements that are found leave the calls, so a captured array no longer fits"
