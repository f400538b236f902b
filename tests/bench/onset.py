"""The onset of stick-slip: whether the first slip and the number of slips depend on the increment du_x.

    python tests/bench/onset.py [--scenes 13] [--json FILE]

Default punch, E 971.78, delta_bar 0.26516, phi_ratio evenly from 0.0755 to 0.0779: stick-slip just begins, so that a
fold lies within a short part of a branch.
"""

import sys

import numpy as np
from scenes import numbered, ran, scene_of, sheared, write

STEPS = (0.1, 0.02, 0.005)  # delta_t
SAME = 1e-5  # nm


def main():
    chosen, rows = numbered(__doc__, 13).parse_args(), []
    for ratio in np.linspace(0.0755, 0.0779, chosen.scenes):
        row = {"phi_ratio": round(float(ratio), 6), "U_s": [], "slips": []}
        for du_x in STEPS:
            values = {"E": 971.78, "delta_bar": 0.26516, "phi_ratio": row["phi_ratio"], "u_x_max": 13.0, "du_x": du_x}
            frames, _, failure = ran(scene_of(values))
            events = sheared(frames)
            row["U_s"].append(events[0].load if events else failure)
            row["slips"].append(len(events))
        loads = [load for load in row["U_s"] if isinstance(load, float)]
        row["same"] = len(loads) in (0, len(STEPS)) and bool(
            np.ptp(loads or [0.0]) < SAME and len(set(row["slips"])) == 1
        )
        rows.append(row)
        print(row, file=sys.stderr, flush=True)
    print(f"{len(rows)} scenes at du_x {STEPS}: {sum(not row['same'] for row in rows)} depend on it")
    write(chosen.json, rows)


if __name__ == "__main__":
    main()
