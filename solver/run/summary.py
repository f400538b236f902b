"""What Frames show: a run in a few numbers, and the surface away from the contact."""

from collections.abc import Sequence
from math import e
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..continuation.state import ROUND_OFF, Outcome
from ..mechanics.layer import Convolution, Modes
from ..scene import Scene
from .frame import Frame, SlipEvent, Stage, largest_safe_damping, slides_in
from .load_steps import load_steps_of


def whole_surface(frame: Frame) -> NDArray[np.float64]:
    """Computes the displacement of the whole surface from the traction on the patch.

    Parameters: frame.
    Returns u (2, nodes), nm.

    Example: `whole_surface(simulate(Scene()).frames[-1])`
    """
    layer = Convolution(Modes.of(frame.scene), frame.scene.nodes)
    layer.field[:, frame.first : frame.first + frame.T.shape[1]] = frame.T
    layer.apply()
    return layer.product + np.array([[frame.U_x], [-frame.delta]])


def fields_of(frames: Sequence[Frame]) -> dict[str, NDArray[np.float64]]:
    """x (m,), u (nm) and T (GPa) (frames, 2, m) of the nodes of a run; x in nm from the middle of the cell."""
    nodes = frames[0].first + np.arange(frames[0].u.shape[1]) if frames else np.arange(0)
    u, T = (np.array([getattr(frame, name) for frame in frames]).reshape(len(frames), 2, nodes.size) for name in "uT")
    x = frames[0].scene.x[nodes] - frames[0].scene.width / 2 if frames else np.empty(0)
    return {"x": x, "u": u, "T": T}


def curves_of(frames: Sequence[Frame]) -> dict[str, list[Any]]:
    """{column: a value per Frame}: what a table, a CSV, an NPZ file and xarray hold of a run; units in the headings."""
    least = least_force(frames)
    values = {
        "stage": lambda frame: frame.stage,
        "U_x (nm)": lambda frame: frame.U_x,
        "delta (nm)": lambda frame: frame.delta,
        "U_x_top (nm)": lambda frame: frame.U_x_top,
        "delta_top (nm)": lambda frame: frame.delta_top,
        "F (N/m)": lambda frame: cleared(frame.F, least),
        "L (N/m)": lambda frame: cleared(frame.L, least),
        "A (nm)": lambda frame: frame.A,
        "residual (nm)": lambda frame: frame.residual,
        "evaluations": lambda frame: frame.evaluations,
        "slip": lambda frame: frame.slip,
    }
    return {name: [value(frame) for frame in frames] for name, value in values.items()}


def widest(frames: Sequence[Frame]) -> float:
    """The largest distance of the outermost nodes of a Frame that repel, or adhere noticeably, over w.

    They adhere with more than 1e-3 of the peak, phi_n/(e delta_n).
    """
    widths = [0.0]
    for frame in frames:
        scene, T_z = frame.scene, frame.T[1]
        acting = np.flatnonzero((T_z > 0.0) | (T_z < -1e-3 * scene.phi_n / (e * scene.delta_n)))
        widths += [(acting[-1] - acting[0] + 1) / scene.nodes] if acting.size else []
    return float(max(widths))


def least_force(frames: Sequence[Frame]) -> float:
    """Force (N/m) below which F and L of a run are zero: the largest one times the tolerance over delta_t."""
    largest = max((max(abs(frame.F), abs(frame.L)) for frame in frames), default=0.0)
    return max((frame.scene.tolerance / frame.scene.delta_t for frame in frames[:1]), default=0.0) * largest


def cleared(force: float, least: float) -> float:
    """The force, or 0.0 if it is no larger than `least`: what the tolerance leaves of a symmetric state."""
    return 0.0 if abs(force) <= least else force


def values_of(frame: Frame, event: SlipEvent, least: float = 0.0) -> dict[str, Any]:
    """A SlipEvent of a Frame by plain names: stage, U_x or delta (nm), F, L (N/m), A (nm), kind, located, sensitive."""
    forces = {"F": cleared(event.F_bar * frame.unit, least), "L": cleared(event.L_bar * frame.unit, least)}
    where = {"stage": event.stage, frame.stage.moves: event.load} | forces | {"A": event.A_bar * frame.scene.width}
    return where | {"kind": kind_of(frame, event), "located": event.located, "sensitive": event.sensitive}


def kind_of(frame: Frame, event: SlipEvent) -> str:
    """The kind of a SlipEvent of a Frame: "pull-off" where a retraction parts the surfaces, else that of the end.

    They are apart where every gap is beyond the peak of adhesion, at delta_n.
    """
    last = event is frame.slips[-1] and frame.stage in retractions(frame.scene)
    return "pull-off" if last and frame.gap.min() > frame.scene.delta_n else event.kind


def retractions(scene: Scene) -> set[Stage]:
    """The stages of a scene's path along which delta falls, straight up or obliquely."""
    return {step.stage for step in load_steps_of(scene) if step.loading.direction[1] > 0.0}


def first_slip_in(frames: Sequence[Frame]) -> tuple[Frame, SlipEvent] | None:
    """The first slip of a stage that moves U_x, and its Frame; None without one."""
    return next(((frame, event) for frame in frames for event in slides_in(frame)), None)


def summarize(frames: Sequence[Frame], outcome: Outcome = Outcome.FINISHED) -> dict[str, Any]:
    """Describes a run in a few numbers, as `run --json` writes them.

    Parameters: frames: all of the run, in order; outcome: how it ended, as of its Result.
    Returns a dict: A_0 (nm) and the number of slips after the approach; U_s (nm), F_s, L_s (N/m) and A_s (nm) at the
    first slip of a stage that moves U_x, None where it does not exist.

    Example: `summarize(simulate(Scene()).frames)["U_s"]`

    A jump where a held load takes over ("control") counts among the slips, but is not the first one. Only a path
    with stages along which delta falls has L_min (N/m), the largest pull: the least load of these; and L_off (N/m), the
    parting load: that just before the surfaces part, None where they do not.
    """
    least = least_force(frames)
    events = [values_of(f, event, least) for f in frames for event in f.slips]
    found = first_slip_in(frames)
    first: dict[str, Any] = values_of(*found, least) if found else {}
    after = [f for f in frames if f.stage != "approach"]
    summary = {
        "converged": _converged(frames, outcome),
        "evaluations": sum(f.evaluations for f in frames),
        "events": events,
        "safe_damping": (safe := largest_safe_damping(frames)),
        "may_flutter": sum(f.may_flutter for f in frames) if frames and safe > frames[0].scene.damping else 0,
        "sensitive": sum(f.sensitive for f in frames),
        "A_0": after[0].A if after else None,
        "slips": sum(len(f.slips) for f in after),
        "U_s": first.get("U_x"),
        "F_s": first.get("F"),
        "L_s": first.get("L"),
        "A_s": first.get("A"),
    }
    lifted = retractions(frames[0].scene) if frames else ()
    if retraction := [f.L for f in after if f.stage in lifted]:
        parted = (event["L"] for event in events if event["kind"] == "pull-off")
        summary |= {"L_min": min(retraction), "L_off": next(parted, None)}
    return summary


def _converged(frames, outcome):
    """Whether the Frames reach the end of the path, or a pull-off, each within its tolerance."""
    if not frames or not outcome.reached or any(f.residual > f.scene.tolerance for f in frames):
        return False
    if outcome is Outcome.PULLED_OFF:
        return True
    scene = frames[-1].scene
    last = load_steps_of(scene)[-1]
    if frames[-1].stage != last.stage:
        return False
    return last.loading.load_of(frames[-1]) >= last.at(last.increments) - ROUND_OFF * last.increment


def left_out(frames: Sequence[Frame]) -> dict[str, int]:
    """What a run did not compute: nodes of the cell that its last frame leaves out, and increments that it repeated."""
    if not frames:
        return {"nodes": 0, "increments": 0}
    last = frames[-1]
    return {"nodes": last.scene.nodes - last.u.shape[1], "increments": sum(frame.repeated for frame in frames)}
