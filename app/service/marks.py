"""Where on a slider something changes, as marks beside it: estimates from a few coarse runs, nothing is assumed."""

from dataclasses import dataclass, replace
from itertools import pairwise
from time import thread_time
from typing import Any

from app.service import worker
from app.service.tasks import SLICE, Part
from solver import advance

SLIDERS = ("delta_bar", "E")  # those with marks; friction would take ten runs
STEP = 0.5  # delta_n, delta_t: of the increments
DEEPEST = 1.0  # delta_bar up to which the slider goes
SOFTEST, STIFFEST = 10.0, 3000.0  # GPa, of the slider
FACTOR = 2.0  # by which E is lowered from where sliding is continuous, until a run slips
CLOSE = 1.2  # between a stiffness that slips and one that does not
ENOUGH = 6.0  # s of processor time: better no mark than a server that is busy with them


@dataclass(frozen=True)
class Search:
    """What has been found on one slider: frames of the run under way, and which stiffness slips, GPa."""

    used: float = 0.0  # s
    checkpoint: Any = None
    rows: tuple = ()  # (stage, delta, L_bar, loads of slips) of every frame
    E: float = STIFFEST
    smooth: float | None = None
    slipping: float | None = None


def key(scene, name):
    """The scene as far as it matters for the marks of a slider: they are the same all along it; raises SceneError."""
    if name == "delta_bar":
        return scene.changed(delta_bar=DEEPEST, u_x_max=0.0, path="unload", hold="delta", du_z=STEP)
    return scene.changed(E=STIFFEST, path="shear", du_x=STEP, du_z=STEP)


def of_slider(scene, name, kept=None):
    """((value, what happens there), ...) along slider `name` for a scene made by `key`; or Part of it."""
    search, begun = kept or Search(), thread_time()
    at = scene if name == "delta_bar" else scene.changed(E=search.E)
    frames, checkpoint = advance(at, search.checkpoint, SLICE, limit=worker.SLOW)
    used = search.used + thread_time() - begun
    if used > ENOUGH or checkpoint.failure:
        return ()
    rows = tuple((frame.stage, frame.delta, frame.L_bar, [slip.load for slip in frame.slips]) for frame in frames)
    search = replace(search, used=used, checkpoint=checkpoint, rows=search.rows + rows)
    return _of_indentation(scene, search) if name == "delta_bar" else _of_sliding(search)


def _of_indentation(scene, search):
    """No load, jump into contact, and, on the way back, out of it."""
    if not search.checkpoint.done and search.rows[-1][0] != "reload":
        return Part(search)
    approach = [row for row in search.rows if row[0] == "approach"]
    jumps = [(loads[0], "jumps in") for _, _, _, loads in approach if loads]
    out = [(loads[-1], "lets go") for stage, _, _, loads in search.rows if stage == "unload" and loads]
    zero = [
        (low + (high - low) * L_low / (L_low - L_high), "L = 0")
        for (_, low, L_low, _), (_, high, L_high, _) in pairwise(approach)
        if L_low < 0.0 <= L_high
    ]
    found = zero[-1:] + jumps[:1] + out[-1:]
    return tuple((value / scene.delta_0, said) for value, said in found if abs(value) <= scene.delta_0)


def _of_sliding(search):
    """Where slips end and sliding is continuous: bisected in the logarithm, by whether a run slips at all."""
    slips = any(stage == "shear" and loads for stage, _, _, loads in search.rows)
    if not slips and not search.checkpoint.done:
        return Part(search)
    search = replace(search, **{"slipping" if slips else "smooth": search.E})
    smooth, slipping = search.smooth, search.slipping
    if smooth is None:
        return ()
    if slipping is None:
        following = smooth / FACTOR
    elif smooth < CLOSE * slipping:
        return (((smooth * slipping) ** 0.5, "slides smoothly"),)
    else:
        following = (smooth * slipping) ** 0.5
    if following < SOFTEST:
        return ()
    return Part(replace(search, E=following, checkpoint=None, rows=()))
