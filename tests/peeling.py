"""Edges of contact in a Frame, and how far they peeled between two: what tests claim about them."""

import numpy as np

from solver.run.frame import contact_edges


def edges(scene, frame):
    """(patches, 2) nm: the trailing and the leading edge of every patch of a Frame."""
    return contact_edges(scene, frame.T, frame.first)


def peel_asymmetry(scene, before, after):
    """(back - front)/(back + front), how far the trailing and the leading edges of all patches moved inward in between.

    before, after: Frames. 1: all at the trailing edges, 0: symmetric; nan where nothing moved, or where patches came,
    went, parted or met: unless each overlaps one of the other frame, modulo w.
    """
    then, now = (edges(scene, frame) for frame in (before, after))
    half_then, half_now = (0.5 * (edges[:, 1] - edges[:, 0]) for edges in (then, now))
    # of every patch then to every one now, by way of the nearest ends of the cell
    moved = now.mean(axis=1) - then.mean(axis=1)[:, None]
    moved = (moved + 0.5 * scene.width) % scene.width - 0.5 * scene.width
    pairs = np.abs(moved) < half_now + half_then[:, None]
    if not ((pairs.sum(axis=0) == 1).all() and (pairs.sum(axis=1) == 1).all()):
        return np.nan
    # a patch whose middle moves by d and that shrinks by 2 s moves inward by d + s behind and s - d in front
    shrunk = half_then.sum() - half_now.sum()
    return float(moved[pairs].sum() / shrunk) if shrunk != 0.0 else np.nan
