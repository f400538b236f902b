#!/usr/bin/env bash
# Numba: a function that calls another one gives other last digits in the process that compiles both than in each later
# process, which loads both from the cache. With fastmath={"contract"} a multiplication may be fused with either of two
# sums. The caller's machine code has a copy of what it calls, compiled once more, with other fusions; which copy serves
# depends on the one that was loaded first: the callee's own where both are compiled, the caller's where it is loaded
# first. Every CPU with FMA is concerned. forceinline=True leaves no copy to choose, and the digits are the same.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet numba==0.68.1 numpy==2.4.6
cat > "$folder/kernels.py" <<'PY'
import hashlib
import sys

import numba
import numpy as np

inline = sys.argv[1] == "inline"


@numba.njit(cache=True, fastmath={"contract"}, forceinline=inline)
def rotate(z, c):
    for k in range(z.shape[1]):
        x, y = z[0, k], z[1, k]
        z[0, k] = complex(c[0, k] * x.real - c[2, k] * y.imag, c[0, k] * x.imag + c[2, k] * y.real)
        z[1, k] = complex(c[1, k] * y.real + c[2, k] * x.imag, c[1, k] * y.imag - c[2, k] * x.real)


@numba.njit(cache=True)
def both(z, c):
    rotate(z, c)


random = np.random.default_rng(1)
z = random.standard_normal((2, 99)) + 1j * random.standard_normal((2, 99))
c = random.standard_normal((3, 99))
both(z, c)
print(hashlib.sha256(z.tobytes()).hexdigest()[:12])
PY
run() { NUMBA_CACHE_DIR="$folder/$1" "$folder/venv/bin/python" "$folder/kernels.py" "$1"; }
echo "numba 0.68.1"
for way in plain inline; do
    first=$(run "$way") second=$(run "$way") third=$(run "$way")
    echo "$way: compiled $first, loaded $second, loaded $third"
    [[ $second == "$third" ]]
    if [[ $way == plain ]]; then [[ $first != "$second" ]]; else [[ $first == "$second" ]]; fi
done
echo "as found: digits differ between the process that compiles and those that load, unless the callee is inlined"
