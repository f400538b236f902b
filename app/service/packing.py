"""A block: frames of one patch as they go to a browser, with a header that says what follows.

Workers pack, the server hands the bytes on without looking into them, so that its event loop stays free.
"""

import json
import struct
import zlib
from dataclasses import dataclass, replace
from math import e, hypot
from typing import Any

import numpy as np
from numpy.typing import NDArray

from app.limits import FLAT
from solver import Frame, Scene
from solver.files import plain
from solver.following.skeleton import Skeleton
from solver.run.frame import STAGES, Stage
from solver.run.load_steps import abscissa, lifts, load_steps_of, position
from solver.scene import PARAMETERS

OF_FRAME = ("index", "U_x", "delta", "F_bar", "L_bar", "A_bar", "residual", "evaluations")
# Of a packed block: a number each per frame; slips in it, and of the first
COLUMNS = ("stage", *OF_FRAME, "slip", "slip_at", "slip_F", "slip_L", "slip_A", "work")
ORDER = tuple(STAGES)  # what the column "stage" counts, but of path "points": see `stages_of`
# delta_n; nodes that are farther in all frames of a block are left out at its ends. They carry 1e-4 of the largest
# attraction, no view shows them, and their gap would coarsen the scale of the others
SEEN = 13.0
FIELDS = ("gap", "u_x", "T_z", "T_x")  # of a packed block: a number each per kept frame and node
FINE = 0.003  # error of a field between frames, or nodes, that are kept, over its largest value; and no more than
CLOSE = {"gap": 0.02, "u_x": 0.01}  # of delta_n, a pixel; of delta_t, so that nodes lie on the curve of the law
STEPS = 3  # steps of a field within this error
EVERY = 3  # nodes of which one decides which frames are kept
LEVEL = 6  # of zlib
FREE = 0.05  # of the peak adhesive traction phi_n / (e delta_n): a node beyond the peak, attracted less, is free
LARGEST = ("residual", "widest", "overlap", "safe_damping", "sensitive")  # of Frames: of two parts the larger one


@dataclass(frozen=True)
class Frames:
    """Packed frames of a run, bytes, one block per part of it; their number, and the sums over them."""

    blocks: tuple = ()
    frames: int = 0
    evaluations: int = 0
    residual: float = 0.0  # nm, the largest
    widest: float = 0.0  # part of w over which anything acts, at most
    overlap: float = 0.0  # of the surfaces over delta_n, the largest
    safe_damping: float = 0.0  # the largest
    sensitive: bool = False  # whether a slip is, as of `solver.Frame`
    ahead: int = 0  # frames left
    failure: str = ""  # why the run ended early
    parted: str = ""  # where the contact pulled off under its held load, which ends a run as the end of its path does
    skeleton: Skeleton | None = None  # of a run that is done: a drag continues from it

    def __add__(self, more: "Frames") -> "Frames":
        """These frames and those that follow."""
        counted = (getattr(self, name) + getattr(more, name) for name in ("blocks", "frames", "evaluations"))
        largest = (max(getattr(self, name), getattr(more, name)) for name in LARGEST)
        return Frames(*counted, *largest, more.ahead, more.failure, more.parted, more.skeleton)  # type: ignore[call-arg]


def packed(scene: Scene, rows: Any, done: bool) -> tuple[bytes, ...]:
    """The block of rows (frame, work), a tuple; an empty one without rows."""
    if scene.surface == "flat":
        rows = [(middle(scene, frame), work) for frame, work in rows]
    return (pack(scene, rows, done),) if rows else ()


def pack(scene: Scene, rows: Any, last: bool) -> bytes:
    """Bytes of rows (frame, work): uint32 length, JSON header, deflated columns and fields.

    The header is that of `arrays`, with the frames and nodes kept of fields; the browser interpolates between them.
    Of columns, as integers, the changes over frames are stored; of fields, in steps, those over frames and nodes.
    """
    head, columns, fields = arrays(scene, rows, last)
    at_most = {"gap": CLOSE["gap"] * scene.delta_n, "u_x": CLOSE["u_x"] * scene.delta_t}
    fine = np.array([min(FINE * 32767, at_most.get(name, np.inf) / scale) for name, scale in head["scales"].items()])
    values = fields / fine[:, None, None].astype(np.float32)
    frames = _kept(values[:, :, ::EVERY])
    nodes = _kept(values[:, frames].transpose(0, 2, 1))
    step = np.maximum(1, fine // STEPS).astype(int)[:, None, None]
    most = 32767 // step  # a browser multiplies in int16
    few = np.rint(fields[:, frames][:, :, nodes] / step).clip(-most, most).astype("<i2")
    kept = {"frames": frames, "nodes": nodes, "steps": step.ravel().tolist()}
    return headed(head | {"kept": kept}, compressed(columns, few))


def arrays(scene: Scene, rows: Any, last: bool) -> tuple[dict[str, Any], NDArray[np.float32], NDArray[np.int16]]:
    """Return (header, float32 COLUMNS (c, n), int16 FIELDS (4, n, m)) of rows (frame, work).

    scene: of all these frames. The header has its parameters, and names the columns, and the fields with their scales,
    in the order in which they follow.

    Each field is stored as int16 with its own scale per block: 1/32767 of its largest value, invisible on a screen,
    at half the bytes of float32.
    """
    frames = [frame for frame, _ in rows]
    gap = _gap(scene, frames)
    near = np.flatnonzero(~(gap.min(axis=0) > max(SEEN * scene.delta_n, gap.min())))
    part = slice(near[0], near[-1] + 1)
    first, nodes = frames[0].first + int(near[0]), int(near[-1] - near[0] + 1)
    u = np.array([frame.u[:, part] for frame in frames])
    traction = np.array([frame.T[:, part] for frame in frames])
    fields = (gap[:, part], u[:, 0], traction[:, 1], traction[:, 0])
    scales = [max(float(np.abs(field).max()), 1e-12) / 32767 for field in fields]
    curves = np.array([_numbers(scene, frame, work) for frame, work in rows], dtype="<f4").T
    of_block = {
        "last": last,
        "frames": len(frames),
        "nodes": nodes,
        "first": first,
        "scales": dict(zip(FIELDS, scales, strict=True)),
    }
    packed = np.array([np.rint(f / s).astype("<i2") for f, s in zip(fields, scales, strict=True)])
    return of_block | of_scene(scene), np.ascontiguousarray(curves), packed


def _kept(values):
    """Places along the second axis of values (fields, k, m), ascending, between which all are straight to one."""
    kept, stretches = {0, values.shape[1] - 1}, [(0, values.shape[1] - 1)]
    while stretches:
        begin, end = stretches.pop()
        if end - begin < 2:
            continue
        part = np.arange(1, end - begin, dtype=np.float32)[:, None] / (end - begin)
        line = values[:, begin, None] + part * (values[:, end] - values[:, begin])[:, None]
        off = np.abs(values[:, begin + 1 : end] - line).max(axis=(0, 2))
        if off.max() > 1.0:
            middle = begin + 1 + int(off.argmax())
            kept.add(middle)
            stretches += [(begin, middle), (middle, end)]
    return sorted(kept)


def _gap(scene, frames):
    """The gap of every node of the patch in every frame, nm, (n, m)."""
    first, nodes = frames[0].first, frames[0].u.shape[1]
    profile = scene.profile[np.arange(first, first + nodes) % scene.nodes]
    return profile + np.array([frame.u[1] for frame in frames])


def of_scene(scene):
    """What the header has of the scene: its parameters, stages, and what curves are drawn along; lengths in nm."""
    along, du_x, du_z = abscissa(scene), scene.du_x * scene.delta_t, scene.du_z * scene.delta_n
    return {
        "spacing": scene.spacing,
        "middle": scene.width / 2,
        "columns": COLUMNS + ("path",) * bool(scene.legs),
        "stages": (stages := stages_of(scene)),
        "along": [Stage(stage).moves for stage in stages],
        "abscissa": along,
        "step": {"delta": du_z, "U_x": du_x, "path": hypot(du_x, du_z)}[along],
        "span": _span(scene),
        "approach": [-scene.delta_0, scene.delta, du_z],  # from, to and step of delta
        "adhesion": scene.phi_n / (e * scene.delta_n),
        "free": FREE,
        "delta_n": scene.delta_n,
        "delta_t": scene.delta_t,
        "force": scene.width * scene.E,  # N/m of force per unit of F_bar, L_bar
        "flat": scene.surface == "flat",
        "scene": plain({name: getattr(scene, name) for name in PARAMETERS}),
    }


def compressed(columns: NDArray[np.float32], fields: NDArray[np.int16]) -> bytes:
    """Columns (c, n) and fields (4, k, m) as `pack` stores them. Integers wrap around: nothing is lost."""
    columns = np.diff(columns.view("<i4"), axis=1, prepend=np.int32(0))
    fields = np.diff(np.diff(fields, axis=1, prepend=np.int16(0)), axis=2, prepend=np.int16(0))
    return zlib.compress(columns.tobytes() + fields.tobytes(), LEVEL)


def headed(head: dict[str, Any], body: bytes) -> bytes:
    """Bytes: uint32 length, a JSON head, the body."""
    text = json.dumps(head).encode()
    return struct.pack("<I", len(text)) + text + body


def _span(scene):
    """[lowest, highest] of what is drawn along, nm: see `load_steps.abscissa`."""
    if scene.legs:
        return [0.0, sum(hypot(leg.across, leg.down) for leg in scene.legs[1:])]
    if lifts(scene):
        return [-scene.delta_0, scene.delta]
    end = scene.shear_at(scene.shear_increments)
    return [-end if scene.path == "loop" else 0.0, end]


def stages_of(scene: Scene) -> tuple[str, ...]:
    """The stages that the column "stage" counts."""
    return tuple(step.stage for step in load_steps_of(scene)) if scene.legs else ORDER


def _numbers(scene, frame, work):
    first = frame.slips[0] if frame.slips else None
    event = first or frame
    slip = (first.load if first else frame.U_x, event.F_bar, event.L_bar, event.A_bar)
    numbers = (getattr(frame, name) for name in OF_FRAME)
    if not scene.legs:
        return ORDER.index(frame.stage), *numbers, len(frame.slips), *slip, work
    at = position(frame)
    if frame.stage != "approach":  # which is drawn along delta
        slip = position(frame, first) if first else at, *slip[1:]
    return stages_of(scene).index(frame.stage), *numbers, len(frame.slips), *slip, work, at


def middle(scene: Scene, frame: Frame) -> Frame:
    """The same frame with the fields of the nodes in the middle only."""
    first = max(0, (scene.nodes - FLAT) // 2)
    part = slice(first, first + min(FLAT, scene.nodes))
    return replace(frame, first=first, u=frame.u[:, part], T=frame.T[:, part])
