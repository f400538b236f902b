"""Sensitivities of the first slip, for workers."""

from typing import Any

import numpy as np

from solver import NotConverged, Scene
from solver.analysis.sensitivities import sensitivities
from solver.following.from_run import skeleton_of
from solver.following.moved import NotFollowed


def what_matters(scene: Scene) -> dict[str, Any] | str:
    """Return the sensitivities of the first slip for the page "What matters"; or a sentence: why there are none.

    bars: {parameter: [U_s, F_s, A_s]}, change in per cent per 1 % of the parameter, or per 0.01 of a parameter that is
    zero. A value that is zero itself has None. The width of the cell is left out: it scales radius, height and
    lattice spacing together. nodes: change of F_s by the strength of each node from `first` on, over F_s.
    """
    try:
        made = sensitivities(skeleton_of(scene), branches=False)
    except (NotConverged, NotFollowed) as error:
        return f"{error}".rstrip(".")
    if not made.slips:
        return "nothing slips up to the end of the run"
    slip = made.slips[0]
    values = {name: getattr(scene, name) for name in slip.by}
    bars = {}
    for name, by in slip.by.items():
        if name == "width":
            continue
        changes = zip(by * (values[name] or 1.0), slip.values, strict=True)
        parts = [float(f"{d / v:.4g}") if v else None for d, v in changes]
        bars[name] = [parts[k] for k in (0, 1, 3)]
    held = slip.nodes[1] / (slip.values[1] or 1.0)
    acting = np.flatnonzero(held)
    first, last = (acting[0], acting[-1] + 1) if acting.size else (0, 0)
    nodes = [float(f"{share:.3g}") for share in held[first:last]]
    return {"values": values, "bars": bars, "first": int(first), "nodes": nodes}
