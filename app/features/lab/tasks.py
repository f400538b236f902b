"""Runs of flats, and calls that report why they have no result, for workers."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from app.service import worker
from app.service.tasks import SLICE, failure_of
from app.service.worker import Part
from solver import Frame, NotConverged, Scene, advance
from solver.following.moved import NotFollowed


def tried(function: Callable[..., Any], *arguments: Any) -> Any:
    """Return function(*arguments); where the arguments have no result, the Exception that says why."""
    try:
        return function(*arguments)
    except (NotConverged, NotFollowed, ValueError) as error:
        return failure_of(error)


def flat_frames(scene: Scene, state: Any = None) -> list[Frame] | Part:
    """Return the frames of a run, each with one node only, as all nodes of a flat are alike; or a Part.

    Raises NotConverged.
    """
    done, checkpoint = state or ([], None)
    frames, checkpoint = advance(scene, checkpoint, SLICE, limit=worker.SLOW)
    done += [replace(frame, u=frame.u[:, :1], T=frame.T[:, :1]) for frame in frames]
    if not checkpoint.outcome.reached:
        raise NotConverged(f"{checkpoint.failure}", checkpoint.outcome)
    return done if checkpoint.done else Part((done, checkpoint))
