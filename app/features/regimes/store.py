"""The stored map of the default experiment, which the page shows before a worker has computed anything.

    python -m app.features.regimes.store

computes it with a process for each core and writes it to default.json.gz.
"""

import gzip
import json
from dataclasses import asdict, astuple
from functools import cache
from pathlib import Path
from typing import Any

from app.features.regimes.grid import FIRST, grid_of
from solver import Scene
from solver.analysis.maps import Map, Point, explore_map
from solver.scene import PARAMETERS

FILE = Path(__file__).parent / "default.json.gz"


def stored(grid: Map) -> list[Point]:
    """Return the Points of a Map, none where it is not the stored one."""
    return [Point(*row) for row in _stored()["points"]] if _named(grid) == _stored()["map"] else []


def _named(grid):
    """Return a Map as it stands in the file."""
    values = {name: getattr(grid.scene, name) for name in PARAMETERS}
    return json.loads(json.dumps([values, asdict(grid.x), asdict(grid.y)]))


@cache
def _stored() -> dict[str, Any]:
    return json.loads(gzip.decompress(FILE.read_bytes()))


def main() -> None:
    """Compute and write the map."""
    grid, points = grid_of(Scene(), FIRST, "shear"), list[Point]()
    for point in explore_map(grid):
        points.append(point)
        print(f"\r{len(points)} of {grid.size} points", end="", flush=True)
    rows = [[float(f"{x:.6g}") if isinstance(x, float) else x for x in astuple(point)] for point in points]
    FILE.write_bytes(gzip.compress(json.dumps({"map": _named(grid), "points": rows}).encode(), 9, mtime=0))
    print(f"\n{FILE.name}: {FILE.stat().st_size} bytes")


if __name__ == "__main__":
    main()
