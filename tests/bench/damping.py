"""What each constant of the safe damping decides: the changes of the estimate with other values.

    python tests/bench/damping.py [--json FILE]

States: 12 each of three runs: the default, E = 12 with friction 1.4, and a rough surface. A row per constant of
`solver.mechanics.flutter`: the largest change of the safe damping among them, in percent, each way.
"""

import numpy as np
from scenes import options, write

from solver import Scene, load_path
from solver.mechanics import flutter

RUNS = {}, {"E": 12.0, "phi_ratio": 1.4}, {"surface": "rough"}
STATES = 12  # of each run, spread evenly over the frames in contact
VARIED = {"WIDTH": (0.3, 1.2), "WIDER": (1.2, 2.0), "FINER": (1.02, 1.41)}


def fields():
    """(scene, u, first node) of the states."""
    for values in RUNS:
        scene = Scene(**values)
        frames = [frame for frame in load_path(scene) if frame.T.any()]
        for k in np.linspace(0, len(frames) - 1, STATES).astype(int):
            yield scene, frames[k].u, frames[k].first


def main():
    chosen, states, rows = options(__doc__).parse_args(), list(fields()), []
    usual = np.array([flutter.safe_damping(*state) for state in states])
    seen = usual > 0.0
    for name, others in VARIED.items():
        value = getattr(flutter, name)
        for other in others:
            setattr(flutter, name, other)
            change = np.array([flutter.safe_damping(*state) for state in states])[seen] / usual[seen] - 1.0
            rows.append({"name": name, "value": value, "tried": other, "least": change.min(), "most": change.max()})
            print("{name} {value:g}, with {tried:g}: {least:+.1%} .. {most:+.1%}".format(**rows[-1]), flush=True)
        setattr(flutter, name, value)
    print(f"{len(states)} states, {seen.sum()} of them with a safe damping above zero")
    write(chosen.json, rows)


if __name__ == "__main__":
    main()
