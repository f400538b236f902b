"""The approach is the same for every indentation, up to where it ends: a worker remembers the last one that it walked.

While the slider of the indentation is held, every run asks for it anew, and it is half of the work of a coarse run.
"""

from dataclasses import replace
from math import ceil
from time import perf_counter

from solver import Checkpoint, advance
from solver.mechanics.contact import patch
from solver.run.load_steps import load_steps_of
from solver.run.loadpath import BULGE

STEP = 0.5  # delta_n, of the increments of an approach that is remembered, at least: those of a held slider, some MB
ROOM = 4  # to one delta_0: a patch is that of the next such part of the indentation, so that runs to come fit in
_last = (None, ())  # a scene but for its indentation, and (frame, load, Checkpoint after it) of its increments


def walked(scene, until, limit):
    """(frames, checkpoint) of the approach of a scene as from `advance`, up to perf_counter() `until`.

    ([], None) if its increments are too many to be remembered; limit: of an increment, as of `advance`.
    """
    global _last
    key, step = scene.changed(delta_bar=0.0), load_steps_of(scene)[0]
    if scene.du_z < STEP or scene.surface == "flat":
        return [], None
    first, size = patch(scene.changed(delta_bar=ceil(ROOM * scene.delta_bar) / ROOM), BULGE)
    known = list(_last[1]) if _last[0] == key else []
    if known and not _covers(known[0][2].patch, first, size):
        known = []
    same = [i < step.increments and load == step.at(i) for i, load in ((frame.index, load) for frame, load, _ in known)]
    known = known[: same.index(False) if False in same else len(same)]
    frames = [frame for frame, *_ in known]
    checkpoint = replace(known[-1][2], load_steps=None) if known else Checkpoint(patch=(first, size))
    while not frames or perf_counter() < until:
        more, checkpoint = advance(scene, checkpoint, 0.0, limit=limit)
        frames += more
        if checkpoint.done or checkpoint.stage != "approach":
            break
        known.append((more[0], step.at(more[0].index), checkpoint))
    _last = key, tuple(known)
    return frames, checkpoint


def _covers(whole, first, size):
    """Whether a patch (first, size) holds those nodes."""
    return whole[0] <= first and first + size <= sum(whole)
