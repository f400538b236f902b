"""Jumps without an event: frames that moved by more than delta_n, though the run reports no slip there.

    python tests/bench/jumps.py [--scenes 60] [--from K] [--json FILE]

Punches under a held load in tension, punches under any held load, and flats that form waves on the approach, in turn.
A frame whose surface moved by more than delta_n beyond twice the step of the load should have an event. Where it has
none, an explicit GFMD (tests/shared/plain_gfmd.py) decides between a jump and a fast, continuous change: it halves the
increment HALVINGS times and keeps the half with the larger move. A jump keeps its size, a continuous change does not.
A jump where the control changes (increment 0 of a stage) needs no decision.
"""

import sys

import numpy as np
from scenes import even, geometric, numbered, ran, scene_of, write

from plain_gfmd import NoRest, Plain  # isort: skip  (scenes makes it importable)
from solver import whole_surface

LIMIT = 60.0  # s of processor time of a run
HALVINGS = 6
KICK = 1e-3  # nm, so that GFMD leaves a uniform state that is unstable to waves
KNOWN = [  # jumps that had no event
    {"hold": "load", "delta_bar": -0.5, "u_x_max": 4.0},
    {"hold": "load", "delta_bar": -0.4, "u_x_max": 4.0},
    {"hold": "load", "delta_bar": -0.6, "phi_ratio": 0.3, "u_x_max": 4.0},
    {"hold": "load", "delta_bar": -0.5, "E": 200.0, "u_x_max": 4.0},
    {"surface": "flat", "nu": 0.49, "u_x_max": 1.0},
    {"surface": "flat", "height": 0.3, "u_x_max": 1.0},
    {"surface": "flat", "nodes": 128, "width": 312.5, "E": 5.0, "nu": 0.49, "phi_ratio": 0.0, "u_x_max": 4.0},
]


def scenes(count):
    """Parameters of scenes: those of KNOWN first."""
    yield from KNOWN[:count]
    for k in range(len(KNOWN), count):
        rng = np.random.default_rng((34, k))
        values = {"E": geometric(rng, 10.0, 1000.0), "phi_ratio": geometric(rng, 0.05, 2.0), "u_x_max": 8.0}
        if k % 3 == 2:
            nodes = int(rng.integers(16, 129))
            values |= {"surface": "flat", "nodes": nodes, "width": nodes * 2.44, "E": geometric(rng, 3.0, 300.0)}
            values |= {"nu": float(rng.choice([0.45, 0.48, 0.49])), "height": even(rng, 0.2, 1.0)}
            values |= {"delta_bar": even(rng, -0.5, 0.5), "hold": str(rng.choice(["delta", "delta", "load"]))}
        else:
            low, high = ((-0.6, 0.0), (-0.2, 0.8))[k % 3]
            values |= {"hold": "load", "delta_bar": even(rng, low, high)}
        yield values


def unreported(scene, frames):
    """[(frame, move in nm)] of the jumps without an event."""
    found, before, last = [], None, None
    for frame in frames:
        surface = whole_surface(frame)
        if before is not None and not frame.slips:
            step = max(abs(frame.U_x - last.U_x), abs(frame.delta - last.delta) if frame.stage == "approach" else 0.0)
            move = float(np.abs(surface - before).max())
            if move > scene.delta_n + 2.0 * step and (step == 0.0 or jumps(scene, before, last, frame, move)):
                found.append((frame, move))
        before, last = surface, frame
    return found


def jumps(scene, u, last, frame, move):
    """Whether GFMD from the surface u, (2, nodes) nm, of the last frame jumps on the way to the loads of this one."""
    plain = Plain(scene, tolerance=1e-6)
    u = u + KICK * np.random.default_rng(0).uniform(-1.0, 1.0, u.shape)
    p0 = None if frame.stage == "approach" or scene.hold == "delta" else frame.L_bar * scene.E
    start, end = np.array([last.U_x, -last.delta]), np.array([frame.U_x, -frame.delta])
    try:
        for _ in range(HALVINGS):
            middle = 0.5 * (start + end)
            half = plain.rest(u, *middle, p0)
            whole = plain.rest(half.u, *end, p0)
            if np.abs(half.u - u).max() > np.abs(whole.u - half.u).max():
                end, size = middle, np.abs(half.u - u).max()
            else:
                start, u, size = middle, half.u, np.abs(whole.u - half.u).max()
    except NoRest:
        return True
    return size > 0.5 * move


def main():
    options = numbered(__doc__, 60)
    chosen, rows = options.parse_args(), []
    for k, values in enumerate(scenes(chosen.scenes)):
        if k < chosen.first:
            continue
        scene = scene_of(values)
        frames, _, failure = ran(scene, LIMIT)
        jumped = unreported(scene, frames)
        events = sum(len(frame.slips) for frame in frames)
        rows.append({"scene": values, "frames": len(frames), "events": events, "failure": failure})
        rows[-1]["unreported"] = [(frame.stage, frame.index, frame.U_x, move) for frame, move in jumped]
        if jumped or failure:
            print(k, values, rows[-1]["unreported"], failure or "", file=sys.stderr, flush=True)
    bad = [row for row in rows if row["unreported"]]
    print(f"{len(rows)} scenes, {sum(row['events'] for row in rows)} events; without an event:", end=" ")
    print(f"{sum(len(row['unreported']) for row in bad)} jumps in {len(bad)} scenes")
    print(f"ended early: {sum(bool(row['failure']) for row in rows)}")
    write(chosen.json, rows)


if __name__ == "__main__":
    main()
