#!/usr/bin/env bash
# afmformats: its errors are no Exceptions. AFMFileFormatError and MetaDataMissingError derive from BaseException, as
# KeyboardInterrupt does. A loop over a folder of curves that goes on after `except Exception` therefore ends at the
# first file that the library does not support, or whose spring constant is not known; a worker process that reports
# exceptions ends without a report. Both cases are usual: a map between force curves, an uncalibrated cantilever. Catch
# the two classes by name.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet afmformats==0.18.7 h5py==3.16.0 numpy==2.4.6
cd "$folder"
venv/bin/python - <<'PY'
import afmformats
import h5py
import numpy as np
from afmformats import errors

print("afmformats", afmformats.__version__)
points, force = 20, np.linspace(0.0, 1e-9, 20)
columns = {"force": force, "height (measured)": 1e-8 * abs(np.arange(points) - 9.5),
           "segment": (np.arange(points) >= 10).astype(np.uint8)}
about = {"path": "curve.h5", "enum": 0, "imaging mode": "force-distance", "point count": points}
for name in ("a_curve.h5", "c_curve.h5"):
    with h5py.File(name, "w") as file:
        afmformats.AFMForceDistance(columns, about).export_data(file, fmt="hdf5")
with h5py.File("b_map.h5", "w") as file:  # of another program: any HDF5 file may lie in the folder
    file["z"] = np.zeros((4, 4))

read, ended = [], ""
try:
    for name in ("a_curve.h5", "b_map.h5", "c_curve.h5"):
        try:
            read.append((name, len(afmformats.load_data(name))))
        except Exception:
            continue
except BaseException as error:
    ended = f"{name}: {type(error).__name__}"
print("read:", read, "ended by", ended)
assert read == [("a_curve.h5", 1)] and ended.startswith("b_map.h5: "), (read, ended)

(curve,) = afmformats.load_data("a_curve.h5")
missed = ""
try:
    try:
        curve.metadata["spring constant"]
    except Exception:
        missed = "an Exception"
except BaseException as error:
    missed = type(error).__name__
print("spring constant that is not known:", missed)
assert missed == "MetaDataMissingError", missed
assert not issubclass(errors.AFMFileFormatError, Exception)
print("as found: what is no Exception ends the loop")
PY
