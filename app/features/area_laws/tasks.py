"""The onset of sliding, for workers."""

from typing import Any

from app.service import worker
from app.service.tasks import SLICE
from app.service.worker import Part
from solver import Scene
from solver.analysis.friction_laws import Onset, onset


def onset_of(scene: Scene, state: Any = None) -> Onset | Part:
    """Return the Onset of a scene, or a Part. Raises NotConverged."""
    found = onset(scene, state or (None, ()), SLICE, worker.SLOW)
    return found if isinstance(found, Onset) else Part(found)
