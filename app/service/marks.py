"""Where on a slider something changes, as marks beside it: estimates from a few coarse runs, nothing is assumed."""

from dataclasses import dataclass, replace
from itertools import pairwise
from time import thread_time
from typing import Any

from app.service import worker
from app.service.tasks import SLICE, Part
from solver import advance
from solver.analysis.friction_laws import critical_modulus
from solver.run.load_steps import lifts

SLIDERS = ("delta_bar", "phi_ratio", "E")
INDENTING, SLIDING = 0.2, 0.5  # delta_n, delta_t: of the increments; with larger ones soft punches jump too far at once
DEEPEST = 1.0  # delta_bar up to which the slider goes
BEYOND = 0.02  # delta_bar: so far beyond L = 0 goes a punch that could not be pressed deeper
PERIODS = 5  # of the lattice, over which it is seen whether sliding is smooth
ENDS = {
    "E": (3000.0, 10.0),
    "phi_ratio": (0.002, 2.0),
}  # of these sliders: where sliding is smooth if anywhere, and the other
SAID = {"E": "slides smoothly", "phi_ratio": "slips"}  # what happens above the mark
FACTOR = 4.0  # from one value to the next, until a run slips
CLOSE = 1.2  # between one that slips and one that does not
ENOUGH = 10.0  # s of processor time: better fewer marks than a server that is busy with them


@dataclass(frozen=True)
class Search:
    """What has been found on one slider: frames of the run under way, and which values of it slip."""

    used: float = 0.0  # s
    checkpoint: Any = None
    rows: tuple = ()  # (stage, delta, L_bar, F_bar, loads of slips) of every frame
    value: float = 0.0  # of the slider, in the run under way
    smooth: float | None = None
    slipping: float | None = None


def key(scene, name):
    """The scene as far as it matters for the marks of a slider: they are the same all along it; raises SceneError.

    None if there is nothing to be marked: on a path without shear nothing slides.
    """
    if name == "delta_bar":
        return scene.changed(delta_bar=DEEPEST, u_x_max=0.0, path="unload", hold="delta", du_z=INDENTING)
    if lifts(scene):
        return None
    far = PERIODS * scene.spacing
    changes = {"path": "shear", "u_x_max": far, "du_x": SLIDING, "du_z": INDENTING, name: ENDS[name][0]}
    return scene.changed(**changes)


def of_slider(scene, name, kept=None):
    """((value, what happens there), ...) along slider `name` for a scene made by `key`; or Part of it."""
    if name != "delta_bar" and scene.surface == "flat" and scene.delta_bar == 0.0:
        return _of_flat(scene, name)
    search, begun = kept or Search(value=getattr(scene, name)), thread_time()
    frames, checkpoint = advance(scene.changed(**{name: search.value}), search.checkpoint, SLICE, limit=worker.SLOW)
    new = ((f.stage, f.delta, f.L_bar, f.F_bar, [slip.load for slip in f.slips]) for f in frames)
    used = search.used + thread_time() - begun
    search = replace(search, used=used, checkpoint=checkpoint, rows=search.rows + tuple(new))
    return _of_indentation(scene, search) if name == "delta_bar" else _of_sliding(name, search)


def _of_indentation(scene, search):
    """No load, jump into contact, and, on the way back, out of it: as many of these as were reached."""
    approach = [row for row in search.rows if row[0] == "approach"]
    zero = [
        (low + (high - low) * L_low / (L_low - L_high), "L = 0")
        for (_, low, L_low, *_), (_, high, L_high, *_) in pairwise(approach)
        if L_low < 0.0 <= L_high
    ]
    lost = search.checkpoint.failure or search.used > ENOUGH
    if lost and search.rows[-1][0] == "approach" and zero and search.value == DEEPEST:
        depth = zero[-1][0] / scene.delta_0 + BEYOND
        return Part(replace(search, used=0.0, checkpoint=None, rows=(), value=depth))
    if not (lost or search.checkpoint.done or search.rows[-1][0] == "reload"):
        return Part(search)
    jumps = [(row[-1][0], "jumps in") for row in approach if row[-1]]
    out = [(row[-1][-1], "lets go") for row in search.rows if row[0] == "unload" and row[-1]]
    found = zero[-1:] + jumps[:1] + ([] if lost else out[-1:])
    return tuple((value / scene.delta_0, said) for value, said in found if abs(value) <= scene.delta_0)


def _of_sliding(name, search):
    """Where slips end and sliding is continuous: bisected in the logarithm, by whether a run slips, or still holds."""
    shear = [row for row in search.rows if row[0] == "shear"]
    slips = any(row[-1] for row in shear)
    if not slips and (search.checkpoint.failure or search.used > ENOUGH):
        return ()
    if not slips and not search.checkpoint.done:
        return Part(search)
    holds = not slips and shear[-1][3] >= max(row[3] for row in shear)
    search = replace(search, **{"slipping" if slips or holds else "smooth": search.value})
    smooth, slipping, (_, last) = search.smooth, search.slipping, ENDS[name]
    if smooth is None or search.used > ENOUGH:
        return ()
    if slipping is None:
        following = smooth * (FACTOR if last > smooth else 1.0 / FACTOR)
        following = min(following, last) if last > smooth else max(following, last)
        if following == smooth:
            return ()
    elif max(smooth / slipping, slipping / smooth) < CLOSE:
        return (((smooth * slipping) ** 0.5, SAID[name]),)
    else:
        following = (smooth * slipping) ** 0.5
    return Part(replace(search, value=following, checkpoint=None, rows=()))


def _of_flat(scene, name):
    """The same on the flat, where it is known exactly: the ratio of stiffness to strength alone counts."""
    part = scene.E / critical_modulus(scene)
    value = scene.E / part if name == "E" else scene.phi_ratio * part
    return ((value, SAID[name]),) if min(ENDS[name]) <= value <= max(ENDS[name]) else ()
