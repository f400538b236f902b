"""Whether the skeleton of a run describes it: 200 scenes of the slider box.

    python tests/bench/skeletons.py [--scenes 200] [--from K] [--json FILE]

`skeleton_of` reads a run up to its first repetition; the whole run judges it. F_s is wrong from an error of 0.1 % on,
the curve from 1 % of the largest |F| or |L| on, farther than NEAR from a slip. The first scene slides smoothly; its
curve was far off.
"""

import sys

import numpy as np
from scenes import numbered, ran, scene_of, sheared, slider_box, spread, write

from solver import NotConverged, NotFollowed, skeleton_of

SMOOTH = {"E": 662.8, "phi_ratio": 0.0404, "delta_bar": 0.424}
WRONG = {"F_s": 1e-3, "curve": 1e-2}
NEAR = 0.01  # nm from a slip: where the force is steep, a load off by 1e-6 nm would count


def row_of(values):
    """A scene in numbers: its class, and the errors of F_s and of the curve."""
    scene = scene_of(values)
    frames, _, failure = ran(scene)
    if failure:
        return {"class": "run ends early", "why": failure}
    try:
        skeleton = skeleton_of(scene)
    except (NotFollowed, NotConverged) as refusal:
        return {"class": "refused", "why": str(refusal)}
    theirs, mine = sheared(frames), skeleton.slips
    if len(theirs) != len(mine):
        return {"class": "wrong", "why": f"{len(mine)} slips, the run has {len(theirs)}"}
    largest = max((abs(event.F_bar) for event in theirs), default=1.0)
    F_s = max((abs(a.F_bar - b.F_bar) / largest for a, b in zip(mine, theirs, strict=True)), default=0.0)
    ends = np.array([*(event.load for event in theirs), -np.inf])
    away = [frame for frame in frames if frame.stage == "shear" and np.abs(frame.U_x - ends).min() > NEAR]
    exact = np.array([[frame.F_bar, frame.L_bar] for frame in away]).T
    off = np.abs(np.array(skeleton.curve(np.array([frame.U_x for frame in away])))[:2] - exact)
    errors = {"F_s": F_s, "curve": float(off.max() / np.abs(exact).max())}
    wrong = [name for name, most in WRONG.items() if errors[name] > most]
    return {"class": "wrong: " + ", ".join(wrong) if wrong else "right", "errors": errors}


def main():
    chosen, rows = numbered(__doc__, 200).parse_args(), []
    for number, values in enumerate([SMOOTH, *slider_box(chosen.scenes - 1, 37)]):
        if number < chosen.first:
            continue
        rows.append({"number": number, "scene": values} | row_of(values))
        if rows[-1]["class"] != "right":
            print(rows[-1], file=sys.stderr, flush=True)
    for name in dict.fromkeys(row["class"] for row in rows):
        print(f"{sum(row['class'] == name for row in rows):5}  {name}")
    for name in WRONG:
        errors = spread([row["errors"][name] for row in rows if "errors" in row])
        print(f"error of {name}, median / p95 / worst: " + " / ".join(f"{value:.1e}" for value in errors))
    write(chosen.json, rows)


if __name__ == "__main__":
    main()
