"""Stored runs of the experiments at the top of the page. The page shows them until the computed run is there.

    python -m app.service.stored

computes them and writes them to static/runs/. A stored run is a block of packing.py with all curves, but with only
some frames and nodes: the browser interpolates linearly between them (packed.js).
"""

import sys
from pathlib import Path

import numpy as np

from app.service import packing, worker
from app.service.packing import Frames
from solver.presets import Preset, presets

FOLDER = Path(__file__).parents[1] / "static" / "runs"
LARGEST = 60_000  # bytes of a file
NODES = 3  # every third node: each run is then smaller than LARGEST
APART = 0.02  # largest error of the interpolation between frames, over the field's largest value
STEP = 32  # resolution of a stored field in int16 units: 0.1 % of its largest value
MOST = 32767 // STEP  # largest stored value


def row() -> dict[str, Preset]:
    """Return {name: Preset} of the experiments at the top of the page."""
    return {name: preset for name, preset in presets().items() if preset.short}


def path_of(name: str) -> Path:
    """Return the path of a preset's stored run."""
    return FOLDER / f"{name}.bin"


def thinned(block: bytes) -> bytes:
    """Return a stored run, bytes, from the packed block of a whole run."""
    head, columns, fields = packing.unpack(block)
    nodes = np.unique(np.append(np.arange(0, head["nodes"], NODES), head["nodes"] - 1))
    values = np.array(list(fields.values()))[:, :, nodes]
    frames = _kept(values / 32767.0)
    kept = {"frames": frames.tolist(), "nodes": nodes.tolist(), "step": STEP}
    few = np.rint(values[:, frames] / STEP).clip(-MOST, MOST).astype("<i2")
    body = packing.compressed(np.array(list(columns.values()), "<f4"), few, level=9)
    return packing.headed(head | {"kept": kept}, body)


def _kept(values):
    """Select frames, ascending: linear interpolation errs by APART at most. values: (fields, frames, nodes)."""
    last = values.shape[1] - 1
    kept, stretches = {0, last}, [(0, last)]
    while stretches:
        begin, end = stretches.pop()
        if end - begin > 1:
            part = (np.arange(begin + 1, end) - begin)[:, None] / (end - begin)
            line = values[:, begin, None] * (1.0 - part) + values[:, end, None] * part
            off = np.abs(values[:, begin + 1 : end] - line).max(axis=(0, 2))
            if off.max() > APART:
                middle = begin + 1 + int(off.argmax())
                kept.add(middle)
                stretches += [(begin, middle), (middle, end)]
    return np.array(sorted(kept))


def main() -> None:
    """Compute and write all stored runs."""
    FOLDER.mkdir(exist_ok=True)
    for name, preset in row().items():
        made = worker.compute(preset.scene, None, np.inf, limit=np.inf)
        assert isinstance(made, Frames)  # nothing bounds its time
        if made.failure or len(made.blocks) != 1:
            sys.exit(f"{name} cannot be stored: {made.failure or 'its nodes change on the way; store one block only'}")
        run = thinned(*made.blocks)
        if len(run) > LARGEST:
            sys.exit(f"{name} takes {len(run)} bytes, allowed are {LARGEST}: raise NODES or APART")
        path_of(name).write_bytes(run)
        print(f"{path_of(name)}: {len(run)} bytes")


if __name__ == "__main__":
    main()
