"""The first slip of a run, for workers."""

from typing import Any

from app.service import worker
from app.service.tasks import SLICE, failure_of
from app.service.worker import Part
from solver import NotConverged, Scene
from solver.run import slices


def first_slip(scene: Scene, state: Any = None) -> dict[str, float] | Part | Exception | None:
    """Return {"U" (nm), "F", "L" (N/m)} of the first slip of a run, None without one; a Part; or why it failed."""
    found, _, checkpoint = slices.first_slip(scene, state, SLICE, worker.SLOW)
    if found:
        frame, slip = found
        return {"U": slip.load, "F": slip.F_bar * frame.unit, "L": slip.L_bar * frame.unit}
    if not checkpoint.done:
        return Part(checkpoint)
    if checkpoint.outcome.reached:  # the contact may have pulled off under its held load
        return None
    return failure_of(NotConverged(checkpoint.failure, checkpoint.outcome))
