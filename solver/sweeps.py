"""The first slips of many scenes."""

from __future__ import annotations

from collections.abc import Iterable
from concurrent.futures import Executor
from functools import partial
from itertools import product
from typing import TYPE_CHECKING, Any

from .continuation.state import NotConverged
from .results import FIRST, first_of
from .run.loadpath import time_limit, until
from .run.summary import first_slip_in
from .scene import PARAMETERS, SET_BY_POINTS, Scene, SceneError, checked_scene
from .schema import unknown_name

if TYPE_CHECKING:  # `import solver` needs numerics only
    import pandas as pd


def sweep(
    scene: Scene | None = None,
    executor: Executor | None = None,
    limit: float | None = None,
    progress: bool = False,
    **values: Iterable[Any],
) -> pd.DataFrame:
    """Computes the first slip for every combination of parameter values.

    Parameters: scene: what the values change (default: Scene()); executor: any of `concurrent.futures`, which computes
    the combinations (default: one after the other, here); limit: processor time of a combination, s (default: as of
    `simulate`); progress: show a bar on standard error; values: NAME=[...] of parameters.
    Returns a row per combination, the last name varying fastest: the parameters, U_s (nm), F_s, L_s (N/m), A_s (nm),
    and `outcome`: "slips", "no slip" up to u_x_max, or why there is no result. Missing numbers are nan.
    Raises SceneError (a ValueError) for a name that is no parameter, a value outside its range, and one that path
    'points' does not use; ValueError for values that are no list.

    With processes, as of `ProcessPoolExecutor`, call it under `if __name__ == "__main__":`.

    Example: `sweep(delta_bar=[0.0, 0.2], phi_ratio=[0.5, 1.0])`
    """
    import pandas as pd

    combinations, scenes = _swept(checked_scene(Scene() if scene is None else scene), values)
    row = partial(row_of, limit=limit)
    found = map(row, scenes) if executor is None else executor.map(row, scenes)
    if progress:
        from tqdm import tqdm  # only who asks for a bar needs it

        found = tqdm(found, total=len(scenes), unit=" combinations", leave=False, disable=None)
    rows = [given | row for given, row in zip(combinations, found, strict=True)]
    return pd.DataFrame(rows, columns=[*values, *FIRST, "outcome"])


def _swept(scene, values):
    """(the combinations of {name: values}, the Scene of each); raises as `sweep`."""
    for name, listed in values.items():
        if name not in PARAMETERS:
            raise unknown_name(name, PARAMETERS)
        if isinstance(listed, str) or not isinstance(listed, Iterable):
            raise ValueError(f"{name} = {listed!r}: allowed: a list of values; write {name}=[{listed!r}]")
    combinations = [dict(zip(values, combination, strict=True)) for combination in product(*values.values())]
    scenes = [scene.changed(**combination) for combination in combinations]
    for name in SET_BY_POINTS:
        if name in values and any(each.legs for each in scenes):
            why = "not used with path 'points', whose points set it"
            raise SceneError(name, values[name], why, "sweep points instead")
    return combinations, scenes


def row_of(scene: Scene, limit: float | None = None) -> dict[str, Any]:
    """The first slip of a scene as a row of `sweep`; the run ends there. limit: processor time, s."""
    try:
        for frame, _ in until(scene, limit=time_limit(scene, limit)):
            if found := first_slip_in([frame]):
                return dict(zip(FIRST, first_of(*found), strict=True)) | {"outcome": "slips"}
    except NotConverged as end:
        return {"outcome": str(end.outcome if end.outcome.reached else end)}
    return {"outcome": "no slip"}
