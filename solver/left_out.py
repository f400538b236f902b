"""What a scene does not need, and is therefore not computed: the rules in one place, each can be switched off.

A rule leaves the frames as they are, to the tolerance. `account` says which rules applied to a run and what they saved.
"""

import numpy as np

RULES = {
    "uniform": "flat on flat: only the uniform mode exists, so one node stands for all",
    "window": "nodes outside the interaction window: neither evaluated, nor transformed, nor kept in secant pairs",
    "approach": "approach increments before any spring acts: the layer is undeformed",
    "friction": "phi_t = 0: no tangential traction, nor its transform",
    "mirror": "before shear starts: the right half of the contact mirrors the left one",
    "translation": "sliding repeats itself a lattice period on: known states are moved on and verified, not solved for",
}
ALL = frozenset(RULES)


def mirrored(field, off=0.0):
    """Whether a field of a patch is its own mirror image, to `off` times its largest value (or 1).

    A profile must be to the last bit: through a stiff interface a difference of round-off shows in the residual.
    """
    return bool(np.abs(field - field[::-1]).max() <= off * max(1.0, float(np.abs(field).max())))


def account(scene, frames, leave_out=ALL):
    """{rule: {what, saved, of, unit}} of the rules that applied to a run of the fast method, from its frames."""
    applied = {}

    def add(rule, saved, of, unit):
        if rule in leave_out and saved > 0:
            applied[rule] = {"what": RULES[rule], "saved": int(saved), "of": int(of), "unit": unit}

    if not frames:
        return applied
    uniform = scene.surface == "flat" and "uniform" in leave_out and scene.damping >= 1.0
    kept = 1 if uniform else frames[-1].u.shape[1]
    add("uniform" if uniform else "window", scene.nodes - kept, scene.nodes, "nodes of every force evaluation")
    skipped = sum(f.evaluations == 0 for f in frames if f.stage == "approach")
    add("approach", skipped, scene.approach_increments + 1, "increments")
    if not uniform:
        approach = sum(f.evaluations for f in frames if f.stage == "approach")
        total = sum(f.evaluations for f in frames)
        if scene.phi_ratio == 0.0:
            add("friction", total, 4 * total, "transforms of one row")
        if mirrored(scene.profile[frames[0].first : frames[0].first + kept]):
            add("mirror", approach * (kept // 2), approach * kept, "tractions of a node during approach")
    repeated = [f for f in frames if f.repeated]
    if repeated:
        solved = [f for f in frames if f.stage == "shear" and not f.repeated]
        slips = sum(f.slip for f in repeated)
        usual = [f.evaluations for f in solved if not f.slip] or [0]
        slipping = [f.evaluations for f in solved if f.slip] or [0]
        estimate = slips * np.mean(slipping) + (len(repeated) - slips) * np.mean(usual)
        spent = sum(f.evaluations for f in repeated)
        add("translation", estimate - spent, estimate, "force evaluations of repeated increments (estimate)")
    return applied
