"""Parameters from a measurement."""

from collections.abc import Iterable
from concurrent.futures import Executor

from ..analysis.partial import DRIVE, continuous
from ..run.loadpath import time_limit
from ..scene import Scene
from .content import Source
from .curves import read_measurement
from .loop_fit import fit_of_loop
from .measurement import Measurement, Recording
from .stroke_fit import Fit, fit_of_stroke
from .trial import AXES

LIMIT = 60.0  # s of processor time, of a fit: on a quiet machine about as long as somebody waits


def fit(
    scene: Scene,
    measured: Measurement | Recording | Source,
    free: Iterable[str],
    limit: float = LIMIT,
    executor: Executor | None = None,
) -> Fit:
    """Fits parameters of a scene to a measured curve, given all others.

    Parameters: scene: where the search starts, and the values of all other parameters; measured: as of
    `read_measurement`, friction in N/m or a loop, or what that reads; free: names of continuous parameters, or of AXES
    but for a loop; limit: processor time, s; executor: any of `concurrent.futures`, which computes the runs of a loop's
    derivatives at once (one stroke needs none).
    Returns a Fit: values, standard errors, correlations, warnings about what the data do not determine, and the given
    parameters that could explain the same curve. A fit without a warning is repeated from the other side of each
    parameter, which finds a second minimum within the noise.
    Raises TypeError for a scene that is none; ValueError for names that cannot be free, or none, for an unusable file,
    and for a curve whose sign, origin or unit no parameters explain; NotFollowed, NotConverged or
    SceneError where the start has no run, OutOfTime where it has none in time.

    Example: `fit(Scene(), "measured.csv", ["phi_n"]).values`
    """
    names = free if isinstance(free, str) else tuple(free)
    data, limit = _fitted(scene, measured, names), time_limit(scene, limit)
    if isinstance(data, Recording):
        return fit_of_loop(scene, data, tuple(names), limit, executor)
    return fit_of_stroke(scene, data, tuple(names), limit)


def _fitted(scene, measured, free):
    """The Measurement or Recording that is meant; raises TypeError, ValueError, as `fit`."""
    if not isinstance(scene, Scene):
        raise TypeError(f"scene = {scene!r:.60}: allowed: a Scene; the order is fit(scene, measured, free)")
    data = measured if isinstance(measured, Measurement | Recording) else read_measurement(scene, measured)
    allowed = (*continuous(scene), *([] if isinstance(data, Recording) else AXES))
    if isinstance(free, str) or not free:
        raise ValueError(f"free = {free!r}: allowed: a list of names, one or more; write [{free or allowed[0]!r}]")
    for name in free:
        if name not in allowed or free.count(name) > 1:
            first = f"; give {name} a number first, as inf is a rigid drive" * (name in DRIVE)
            raise ValueError(f"free = {name!r}: allowed, once each: {', '.join(allowed)}{first}")
    return data
