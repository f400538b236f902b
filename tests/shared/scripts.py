"""Runs in a blank tab, as the scripts of the page hold them."""

import base64
from functools import cache
from math import inf

from visitor import slices

from app.service import packing
from solver import Scene, load_path

SHORT = Scene(nodes=256, width=625.0, radius=60.0, u_x_max=12.0, E=200.0)


@cache
def computed(scene, fine):
    """(frames, blocks): all frames of a scene, and the same packed in slices, that finely."""
    frames = list(load_path(scene))  # kernels are then there: compiling them counts as an increment's time
    blocks = []
    for piece in slices(scene, inf):  # a run that is cut differs by round-off
        assert not piece.failure
        blocks += [base64.b64encode(block).decode() for block in piece.blocks]
    return frames, blocks


def run_of(tab, scene):
    """`run` in the tab: all frames of a scene, packed in slices and unpacked there; returns the solver's frames."""
    frames, blocks = computed(scene, packing.FINE)
    tab.evaluate("async (blocks) => { window.run = await runOf(blocks) }", blocks)
    return frames
