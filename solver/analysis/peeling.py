"""Edges of contact in a Frame, and how far they peeled between two: from behind, from the front or from both."""

import numpy as np
from numpy.typing import NDArray

from ..run.frame import least_repulsion


def edges(frame) -> NDArray[np.float64]:
    """(patches, 2) nm, undeformed: the trailing and the leading edge of every patch of a Frame; nan in full contact.

    A patch across the ends of the cell, and those after it, lie beyond w: the order starts behind the widest gap.
    """
    scene, least = frame.scene, least_repulsion(frame.scene)
    n, T_z = frame.T.shape[1], frame.T[1] - least
    closed = n == scene.nodes
    if closed and (T_z > 0.0).all():
        return np.full((1, 2), np.nan)
    if closed:  # once round, from a node without contact
        start = next(k for k in (0, -1, *range(n)) if T_z[k] <= 0.0)
        at = np.arange(start, start + n + 1)
        T_z = T_z[at % n]
    else:  # beyond a patch there is no traction
        at, T_z = np.arange(-1, n + 1), np.concatenate(([-least], T_z, [-least]))
    changes = np.flatnonzero(np.diff(T_z > 0.0))
    edges = (at[changes] + T_z[changes] / (T_z[changes] - T_z[changes + 1])).reshape(-1, 2)
    if closed and len(edges) > 1 and edges[-1, 1] > n:
        gaps = np.append(edges[1:, 0], edges[0, 0] + n) - edges[:, 1]
        k = int(np.argmax(gaps)) + 1
        edges = np.concatenate((edges[k:], edges[:k] + n))
        edges -= n * (edges[0, 0] // n)
    return (frame.first + edges) * scene.spacing


def peel_asymmetry(before, after) -> float:
    """(back - front)/(|back| + |front|), how far the trailing and the leading edges of all patches moved inward.

    before, after: Frames. 1: only trailing edges peel, or leading ones grow at the same time; 0: symmetric; -1: only
    leading edges peel. nan if nothing moved. Also nan if patches appeared, vanished, split or merged: each patch must
    overlap exactly one of the other frame, modulo w.
    """
    scene = after.scene
    then, now = (edges(frame) for frame in (before, after))
    half_then, half_now = (0.5 * (edges[:, 1] - edges[:, 0]) for edges in (then, now))
    # from every patch before to every patch after, the shorter way round the cell
    moved = now.mean(axis=1) - then.mean(axis=1)[:, None]
    moved = (moved + 0.5 * scene.width) % scene.width - 0.5 * scene.width
    pairs = np.abs(moved) < half_now + half_then[:, None]
    if not ((pairs.sum(axis=0) == 1).all() and (pairs.sum(axis=1) == 1).all()):
        return np.nan
    # a patch whose middle moves by d and that shrinks by 2 s moves inward by d + s behind and s - d in front
    shrunk, moved = half_then.sum() - half_now.sum(), moved[pairs].sum()
    most = max(abs(moved), abs(shrunk))
    return float(moved / most) if most > 0.0 else np.nan
