"""Tasks of the pages for workers: pure functions of picklable arguments that return small arrays or numbers."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from app.service import worker
from app.service.caller import Lost
from app.service.worker import Part
from solver import LIMITS, Frame, NotConverged, Scene, advance
from solver.analysis.friction_laws import Onset, onset
from solver.analysis.measurement import Measurement
from solver.continuation.state import Outcome
from solver.following.from_run import skeleton_of
from solver.following.moved import NotFollowed

READING, MEMORY = 10.0, 2**30  # s and bytes for a file of a visitor
SLICE = 0.12  # s of work before a call returns a Part, so that other calls get a turn
POINTS, NOISE, APART = 400, 0.01, 1.2  # of example data: points, noise over the largest F, factor on phi


def tried(function: Callable[..., Any], *arguments: Any) -> Any:
    """Return function(*arguments); where the arguments have no result, the Exception that says why."""
    try:
        return function(*arguments)
    except (NotConverged, NotFollowed, ValueError) as error:
        return failure_of(error)


def failure_of(error: Exception) -> Exception:
    """Return why there is no result, without a full stop: a Lost if that may be the fault of a busy machine."""
    why = f"{error}".rstrip(".")
    return Lost("hang", why) if getattr(error, "outcome", None) is Outcome.OUT_OF_TIME else ValueError(why)


def flat_frames(scene: Scene, state: Any = None) -> list[Frame] | Part:
    """Return the frames of a run, each with one node only, as all nodes of a flat are alike; or a Part.

    Raises NotConverged.
    """
    done, checkpoint = state or ([], None)
    frames, checkpoint = advance(scene, checkpoint, SLICE, limit=worker.SLOW)
    done += [replace(frame, u=frame.u[:, :1], T=frame.T[:, :1]) for frame in frames]
    if checkpoint.failure:
        raise NotConverged(checkpoint.failure, checkpoint.outcome)
    return done if checkpoint.done else Part((done, checkpoint))


def onset_of(scene: Scene, state: Any = None) -> Onset | Part:
    """Return the Onset of a scene, or a Part. Raises NotConverged."""
    found = onset(scene, state or (None, ()), SLICE, worker.SLOW)
    return found if isinstance(found, Onset) else Part(found)


def made_up_scene(scene: Scene, seed: int) -> Scene:
    """Return the Scene of example data: slightly different friction and depth."""
    change = np.random.default_rng([seed, 1]).uniform(-1.0, 1.0, 2)
    values = {"delta_bar": scene.delta_bar + 0.1 * change[1], "phi_ratio": scene.phi_ratio * APART ** change[0]}
    within = {name: float(np.clip(value, LIMITS[name].low, LIMITS[name].high)) for name, value in values.items()}
    return scene.changed(path="shear", **within)


def made_up_curve(scene: Scene, seed: int) -> Measurement:
    """Return a noisy Measurement of a scene. Raises NotConverged or NotFollowed."""
    U_x, unit = np.linspace(0.0, scene.u_x_max, POINTS + 1)[1:], scene.width * scene.E
    F_bar, L_bar, _ = skeleton_of(scene).curve(U_x)
    noise = NOISE * np.abs(F_bar).max() * np.random.default_rng(seed).normal(size=(2, POINTS))
    return Measurement.of(U_x, {"F_bar": F_bar + noise[0], "L_bar": L_bar + noise[1]}, unit=unit)
