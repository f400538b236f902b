#!/usr/bin/env bash
# Numba: decorating a function with cache=True raises RuntimeError where no folder for the cache can be made. So
# `import` of a package fails, before any kernel is called, in a read-only installation without a home (a container with
# a random user, a shared JupyterHub). The same function compiles and runs with cache=False.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet numba==0.68.1 numpy==2.4.6
mkdir "$folder/package"
cat > "$folder/package/kernels.py" <<'PY'
import sys
import numba

@numba.njit(cache=sys.argv[1] == "cached")
def square(x):
    return x * x

print("numba", numba.__version__, sys.argv[1], square(3.0))
PY
# A file stands where each folder would be made: this stops an administrator, too.
touch "$folder/package/__pycache__" "$folder/file"
run() {
    env HOME="$folder/file" XDG_CACHE_HOME="$folder/file" NUMBA_CACHE_DIR= \
        "$folder/venv/bin/python" "$folder/package/kernels.py" "$1"
}
run plain | tee "$folder/plain"
grep -q '9.0$' "$folder/plain"
if run cached > "$folder/cached" 2>&1; then
    echo "changed: the function was compiled"
    exit 1
fi
tail -n 1 "$folder/cached" | sed "s|$folder|FOLDER|"
grep -q "RuntimeError: cannot cache function 'square': no locator available" "$folder/cached"
echo "as found: cache=True raises when the function is decorated, cache=False runs"
