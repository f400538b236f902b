#!/usr/bin/env bash
# afmformats: force curves that are exported one after another to an HDF5 file come back in the order of their numbers
# as text: 0, 1, 10, 11, 2, ... The third curve of twelve is the eleventh, without a word; ten curves keep their order.
# A list beside the file (the speeds, dwell times or loads of a series) then goes with other curves, and a trend of the
# pull-off force is lost. Each curve still has its number in .enum, and get_enum(k) of a group finds it. The right order
# is that of the numbers, in which the curves were written and in which the reader's own description counts the groups.
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

print("afmformats", afmformats.__version__)
points = 20
found = {}
for count in (10, 12):
    with h5py.File("series.h5", "w") as file:
        for k in range(count):  # the pull-off force of curve k is k + 1 nN
            force = np.zeros(points)
            force[15] = -1e-9 * (k + 1)
            columns = {"force": force, "height (measured)": 1e-8 * abs(np.arange(points) - 9.5),
                       "segment": (np.arange(points) >= 10).astype(np.uint8)}
            about = {"path": "series.h5", "enum": k, "imaging mode": "force-distance", "point count": points}
            afmformats.AFMForceDistance(columns, about).export_data(file, fmt="hdf5")
    curves = afmformats.load_data("series.h5")
    group = afmformats.AFMGroup("series.h5")
    found[count] = [round(-1e9 * float(curve["force"].min())) for curve in curves]
    print(f"{count} curves, pull-off forces in nN:", *found[count])
    assert [round(-1e9 * float(curve["force"].min())) for curve in group] == found[count]
    assert [curve.enum + 1 for curve in curves] == found[count]
    assert [round(-1e9 * float(group.get_enum(k)["force"].min())) for k in range(count)] == list(range(1, count + 1))
assert found[10] == list(range(1, 11)), found[10]
assert found[12] == [1, 2, 11, 12, 3, 4, 5, 6, 7, 8, 9, 10], found[12]
print("as found: from the eleventh curve on, the order of a series is that of text")
PY
