"""Pictures of predicted runs while a visitor drags a slider.

A worker continues the run on screen to the new parameters (this is called *following*), and packs the result. A picture
has the curves and a map of the whole run, and two frames: the first in shear, and the one on screen.
"""

import re
import zlib
from dataclasses import dataclass
from math import ceil, e
from typing import Any

import numpy as np

from app.service.packing import FREE, arrays, middle
from solver import NotFollowed, Scene, follow
from solver.following.skeleton import Skeleton
from solver.run.frame import contact_area, forces

CURVES = ("U_x", "F_bar", "L_bar", "A_bar", "slip", "slip_at", "slip_F", "slip_L", "slip_A")  # of a picture, per load
# loads of a curve, without the one on screen, and those right before and after every slip: three pixels apart. With
# twice as many a picture takes twice the time
MOST = 250
CELLS = 30_000  # of a map, one byte each
SHADES = 127  # levels of each sign in a map
LEVEL = 1  # of zlib: half of the bytes, in 0.4 ms
NOTHING = -128  # cells without traction


@dataclass(frozen=True)
class Followed:
    """The `picture`, and the Skeleton from which the next prediction starts."""

    picture: dict
    skeleton: Skeleton


def followed(skeleton: Skeleton, scene: Scene, at: float) -> Followed | str:
    """Predict a scene from the Skeleton of a similar scene; return its Followed, or a str: why it failed.

    at: U_x of the frame on screen, nm.
    """
    try:
        with np.errstate(invalid="ignore"):  # `picture` finds it
            there = follow(skeleton, scene)
            return Followed(picture(there, at), there)
    except NotFollowed as why:
        return re.sub(r"\d[\d.e+-]*", "n", str(why))  # metrics count reasons without their numbers


def picture(skeleton: Skeleton, at: float) -> dict[str, Any]:
    """Return a picture: {frames, columns, shown, map: its extent, block: header of two frames, body}.

    body, deflated: float32 CURVES (columns, frames), what `packing.arrays` has of the two frames, int8 map (rows,
    columns). Raises NotFollowed if a value is not finite.
    """
    scene = skeleton.scene
    steps, every = _increments(scene, [slip.load for slip in skeleton.slips], at)
    loads: Any = scene.shear_at(steps)
    v = skeleton.unknowns(loads)
    T = skeleton.tractions(v)
    shown = int(np.abs(loads - at).argmin())
    frames = skeleton.frames(loads[[0, shown]])
    if scene.surface == "flat":
        frames, cells, extent = [middle(scene, frame) for frame in frames], np.zeros((0, 0), np.int8), {}
    else:
        even = np.flatnonzero(steps % every == 0)
        cells, extent = _map(skeleton, v[even], T[even], every)
    block, columns, fields = arrays(scene, [(frame, 0.0) for frame in frames], True)
    curves = _curves(skeleton, loads, T)
    if not (np.isfinite(curves).all() and np.isfinite(v).all()):
        raise NotFollowed("a predicted state is not finite")
    return {
        "frames": loads.size,
        "columns": CURVES,
        "shown": shown,
        "map": {"rows": cells.shape[0], "columns": cells.shape[1], **extent},
        "block": block,
        "body": zlib.compress(b"".join(part.tobytes() for part in (curves, columns, fields, cells)), LEVEL),
    }


def _increments(scene, slips, at):
    """Return the increments in a picture (k,), and the distance of those that are evenly spaced.

    slips: loads, nm; at: U_x of the frame on screen, nm.
    """
    step, last = scene.du_x * scene.delta_t, scene.shear_increments
    every = ceil((last + 1) / MOST)
    beside = [np.floor(np.divide(slips, step)), np.ceil(np.divide(slips, step)), [round(at / step), last]]
    return np.unique(np.concatenate([np.arange(0, last + 1, every), *beside]).astype(int)).clip(0, last), every


def _curves(skeleton, loads, T):
    """Return CURVES (columns, k), float32, from the tractions T (k, 2, m) at loads (k,)."""
    curves = np.zeros((len(CURVES), loads.size), "<f4")
    curves[0], curves[1:3] = loads, forces(skeleton.scene, T)
    curves[3] = [contact_area(skeleton.scene, T_at) for T_at in T]
    curves[5:] = curves[:4]
    for slip in reversed(skeleton.slips):  # in reverse: the first of several slips wins
        k = np.searchsorted(loads, slip.load)
        if k < loads.size:
            curves[4, k] += 1
            curves[5:, k] = slip.load, slip.F_bar, slip.L_bar, slip.A_bar
    return curves


def _map(skeleton, v, T, every):
    """Return the map of T_z, int8 (rows, columns), and its extent; without nodes that nothing acts on.

    v (k, size), T (k, 2, m): at every `every`-th increment. Columns are left out while there are more than CELLS.
    """
    scene, first, T = skeleton.scene, skeleton.first, T[:, 1]
    nodes = T.shape[1]
    gap = scene.profile[np.arange(first, first + nodes) % scene.nodes] + v[:, nodes : 2 * nodes]
    acts = (gap <= scene.delta_n) | (T / scene.phi_n <= -FREE / (e * scene.delta_n))
    within = np.flatnonzero(acts.any(axis=0))
    part = slice(within[0], within[-1] + 1) if within.size else slice(0, 1)
    thin = max(1, ceil(len(T) * (part.stop - part.start) / CELLS))
    T, acts = T[::thin, part], acts[::thin, part]
    high, low = max(T.max(), 1e-12), max(-T.min(), 1e-12)
    cells = np.where(acts, np.rint(SHADES * np.where(T > 0.0, T / high, T / low)), NOTHING).astype(np.int8)
    extent = {"first": int(first + part.start), "step": thin * every * scene.du_x * scene.delta_t}
    return cells.T, extent | {"high": float(high), "low": float(low)}
