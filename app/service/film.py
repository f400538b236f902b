"""The motion through a slip, from the packed frames on either side of it, packed as those of a run are."""

from dataclasses import replace

import numpy as np

from app.service import packing, worker
from solver import NotConverged
from solver.run.film import through
from solver.run.frame import STAGES, Frame


def slow_motion(scene, before, after):
    """Packed blocks of the motion between two frames, each (packed block, row); or why there is none."""
    goal = frame_of(scene, *after)
    name, sign = STAGES[goal.stage]
    load = sign * getattr(goal, name)
    try:
        film, _ = through(scene, frame_of(scene, *before), goal.stage, load, limit=worker.SLOW)
    except (NotConverged, ValueError) as error:
        return str(error)
    if not film:
        return "no branch ends here"
    return packing.packed(scene, [(replace(frame, index=goal.index), 0.0) for frame in film], True)


def frame_of(scene, block, row):
    """The Frame of a row of a packed block, in the digits that it has there."""
    head, columns, fields = packing.unpack(block)
    u_x, gap, *T = (fields[name][row] * head["scales"][name] for name in ("u_x", "gap", "T_x", "T_z"))
    profile = scene.profile[np.arange(head["first"], head["first"] + head["nodes"]) % scene.nodes]
    known = {name: float(columns[name][row]) for name in ("U_x", "delta", "F_bar", "L_bar", "A_bar", "residual")}
    place = {"stage": packing.ORDER[int(columns["stage"][row])], "index": int(columns["index"][row])}
    u = np.array([u_x, gap - profile])
    return Frame(scene, **place, **known, first=head["first"], u=u, T=np.array(T), evaluations=0)
