"""Rules by which a run omits computations that its scene does not need. Each can be switched off.

With or without a rule the frames agree to the tolerance. `account` counts what each rule omitted.
"""

RULES = {
    "uniform": "flat on flat, as long as no wave grows: all nodes move alike, so one stands for all",
    "window": "nodes outside the interaction window: neither evaluated, nor transformed, nor kept in secant pairs",
    "translation": "sliding repeats itself a lattice period on: known states are moved on and verified, not solved for",
}
ALL = frozenset(RULES)


def account(frames, leave_out=ALL) -> dict[str, dict]:
    """{rule: {what, count, unit}} of the rules that applied to a run of the fast method, from its frames."""
    if not frames:
        return {}
    last, scene = frames[-1].u, frames[-1].scene
    uniform = last.strides[1] == 0  # one node stands for all: see `frame.on_nodes`
    kept = 1 if uniform else last.shape[1]
    counted = {
        "uniform" if uniform else "window": (scene.nodes - kept, "nodes left out at the end"),
        "translation": (sum(f.repeated for f in frames), "increments repeated"),
    }
    return {
        rule: {"what": RULES[rule], "count": count, "unit": unit}
        for rule, (count, unit) in counted.items()
        if rule in leave_out and count
    }
