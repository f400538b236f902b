"""Points of a map, for workers."""

import pickle
from dataclasses import replace
from typing import Any

from solver.analysis.maps import computed_point


def map_point(task: Any) -> tuple[Any, bytes | None]:
    """Return (Point, its pickled Skeleton or None) of a maps.Task that starts from such bytes."""
    point, skeleton = computed_point(replace(task, start=task.start and pickle.loads(task.start)))
    return point, pickle.dumps(skeleton) if skeleton else None
