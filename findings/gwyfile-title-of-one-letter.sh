#!/usr/bin/env bash
# gwyfile writes a text of one letter as a character, not as a string. A channel that is called "Z" in Gwyddion's
# format then has no title but a number: gwyfile itself reads 90, get_datafields(...) lists the channel under 90, and
# SurfaceTopography names it "b'Z'". "Zs" is a title for all of them.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet gwyfile==0.3.0 SurfaceTopography==1.27.1
cd "$folder"
venv/bin/python - <<'PY'
import gwyfile
import numpy as np
from gwyfile.objects import GwyContainer, GwyDataField
from SurfaceTopography import open_topography

heights = 1e-9 * np.arange(12.0).reshape(3, 4)
found = {}
for title in ("Z", "Zs"):
    written = GwyContainer()
    written["/0/data"] = GwyDataField(heights, xreal=4e-6, yreal=3e-6, si_unit_xy="m", si_unit_z="m")
    written["/0/data/title"] = title
    written.tofile("one.gwy")
    read = gwyfile.load("one.gwy")
    with open("one.gwy", "rb") as file:
        kind = file.read().split(b"/0/data/title\0")[1][:1].decode()
    with open_topography("one.gwy") as topography:
        names = [channel.name for channel in topography.channels]
    found[title] = kind, read["/0/data/title"], list(gwyfile.util.get_datafields(read)), names
    print(f"{title!r}: type {kind!r}, gwyfile reads {found[title][1]!r}, lists {found[title][2]}, others {names}")
assert found["Z"] == ("c", 90, [90], ["b'Z'"]), found["Z"]
assert found["Zs"] == ("s", "Zs", ["Zs"], ["Zs"]), found["Zs"]
print("as found: a title of one letter becomes a number")
PY
