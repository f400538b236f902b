"""What a scene does not need, and is therefore not computed: rules, each of which can be switched off.

With or without a rule frames are the same, to the tolerance. `account` says which rules applied and what they saved.
"""

import numpy as np

RULES = {
    "uniform": "flat on flat, as long as no wave grows: all nodes move alike, so one stands for all",
    "window": "nodes outside the interaction window: neither evaluated, nor transformed, nor kept in secant pairs",
    "friction": "phi_t = 0: no tangential traction, nor its transform",
    "translation": "sliding repeats itself a lattice period on: known states are moved on and verified, not solved for",
}
ALL = frozenset(RULES)


def account(scene, frames, leave_out=ALL):
    """{rule: {what, saved, of, unit}} of the rules that applied to a run of the fast method, from its frames."""
    applied = {}

    def add(rule, saved, of, unit):
        if rule in leave_out and saved > 0:
            applied[rule] = {"what": RULES[rule], "saved": int(saved), "of": int(of), "unit": unit}

    if not frames:
        return applied
    uniform = frames[-1].u.strides[1] == 0  # one node stands for all: see `frame.on_nodes`
    kept = 1 if uniform else frames[-1].u.shape[1]
    add("uniform" if uniform else "window", scene.nodes - kept, scene.nodes, "nodes of every force evaluation")
    if not uniform and scene.phi_ratio == 0.0:
        total = sum(f.evaluations for f in frames)
        add("friction", total, 4 * total, "transforms of one row")
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
