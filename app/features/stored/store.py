"""Stored runs of the experiments at the top of the page. The page shows them until the computed run is there.

    python -m app.features.stored.store

computes them and writes them to runs/, each a block of packing.py.
"""

import sys
from pathlib import Path

from numpy import inf

from app.service import worker
from app.service.packing import Frames
from solver.presets import Preset, presets

FOLDER = Path(__file__).parent / "runs"
LARGEST = 110_000  # bytes of a file


def row() -> dict[str, Preset]:
    """Return {name: Preset} of the experiments at the top of the page."""
    return {name: preset for name, preset in presets().items() if preset.short}


def path_of(name: str) -> Path:
    """Return the path of a preset's stored run."""
    return FOLDER / f"{name}.bin"


def main() -> None:
    """Compute and write all stored runs."""
    FOLDER.mkdir(exist_ok=True)
    for name, preset in row().items():
        made = worker.compute(preset.scene, None, inf, limit=inf)
        assert isinstance(made, Frames)  # nothing bounds its time
        if made.failure or len(made.blocks) != 1:
            sys.exit(f"{name} cannot be stored: {made.failure or 'its nodes change on the way; store one block only'}")
        (run,) = made.blocks
        if len(run) > LARGEST:
            sys.exit(f"{name} takes {len(run)} bytes, allowed are {LARGEST}: shorten it")
        path_of(name).write_bytes(run)
        print(f"{path_of(name)}: {len(run)} bytes")


if __name__ == "__main__":
    main()
