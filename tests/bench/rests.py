"""Whether every frame is stable, and what the estimate of waves is worth: random scenes, judged by dense spectra.

    python tests/bench/rests.py [--scenes N] [--seed N] [--jobs N] [--nodes LEAST MOST] [--more]

Computes all modes of the motion of the whole surface for some twelve frames of each scene in contact, and for those
before and after a slip. Cells have 130 to 200 nodes: from 129 on the solver does not look for waves, and frames say
where these may flutter, by an estimate of the damping that waves need. Prints every scene with a frame whose fastest
mode grows and that does not say so. Most frames are stable at any damping allowed, so that alone has little power:
beside it stands, for each frame, the damping that its waves need by the spectrum, over the estimate. With --nodes 16
90 all modes of all states are judged. A scene has 10 s of processor time, an increment 2 s.
"""

import argparse
import sys
import time
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from math import inf
from pathlib import Path

import numpy as np

from solver import Scene, SceneError, advance

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "validation"))
from spectrum import exponents, friction, needed_damping, rate

HELD = ("shear", "back", "forth")
LEAST = 0.2  # damping over critical, the least that a scene may have


def scene_at_random(rng, nodes, more=False):
    """Parameters of a Scene, which may reject them; more: with a drive, points or another law as well."""

    def between(low, high):
        return float(f"{np.exp(rng.uniform(np.log(low), np.log(high))):.4g}")

    def one_of(*values):
        return values[rng.integers(len(values))]

    values = {
        "surface": one_of("circular", "flat", "wave", "rough"),
        "E": between(1.0, 1e5),
        "delta_bar": round(rng.uniform(-1.0, 3.0), 3),
        "phi_ratio": between(2e-3, 20.0),
        "phi_n": between(0.2, 20.0),
        "nu": one_of(0.0, 0.3, 0.45, 0.49, 0.499, 0.4999),
        "height": between(0.03, 30.0),
        "nodes": int(rng.integers(nodes[0], nodes[1] + 1)),
        "delta_n": between(0.3, 3.0),
        "du_x": one_of(0.1, 0.5, 1.0),
        "du_z": one_of(0.1, 0.5, 1.0),
        "u_x_max": 8.0,
        "damping": one_of(0.2, 0.25, 0.3, 0.35, 0.4, 0.5),
        "hold": one_of("delta", "delta", "load"),
    }
    values["width"] = values["nodes"] * between(1.0, 6.0)
    if values["surface"] == "wave":
        values |= {"waves": int(rng.integers(1, 4)), "amplitude": between(0.05, 5.0)}
    if values["surface"] == "rough":
        values |= {"rms_slope": between(1e-3, 0.05), "cut_off": 0.2, "seed": int(rng.integers(999))}
    if values["hold"] == "delta":
        values["path"] = one_of("shear", "shear", "shear", "unload", "loop")
    if more:
        values |= {"law": one_of("np1", "xu-needleman"), "drive_t": one_of(inf, between(1.0, 1e3))}
        if values["hold"] == "delta":
            values["drive_n"] = one_of(inf, inf, between(10.0, 1e4))
            values |= one_of({}, {"path": "points", "points": points_at_random(rng, values["delta_bar"])})
    return values


def points_at_random(rng, delta_bar):
    """An approach to delta_bar and three lines from there."""
    lines = [(0.0, -1.0), (0.0, delta_bar)]
    lines += [(round(rng.uniform(-4.0, 6.0), 3), round(rng.uniform(-1.0, delta_bar + 0.5), 3)) for _ in range(3)]
    return "; ".join(f"{U_x:g},{depth:g}" for U_x, depth in lines)


def judged(seed, nodes, more):
    """(how the run ended, [(damping needed, estimate)] of frames, those flagged, the restless, slips, located, values).

    Restless are [(stage, index, growth, whether it is flagged)].
    """
    values = scene_at_random(np.random.default_rng(seed), nodes, more)
    try:
        scene = Scene(**values)
    except SceneError:
        return "refused", [], 0, [], 0, 0, values
    frames, checkpoint, begun = [], None, time.process_time()
    while (checkpoint is None or not checkpoint.done) and time.process_time() - begun < 10.0:
        computed, checkpoint = advance(scene, checkpoint, 0.3, limit=2.0)
        frames += computed
    touching = [k for k, frame in enumerate(frames) if frame.T.any()]
    chosen = set(touching[:: max(1, len(touching) // 12)])
    chosen |= {k + i for k in touching if frames[k].slip for i in (-1, 0)} & set(touching)
    wrong, needed = [], []
    for frame in (frames[k] for k in sorted(chosen)):
        held = scene.hold == "load" and frame.stage in HELD
        mu = exponents(scene, frame, held)
        found = float(rate(mu, friction(scene)).max())
        needed.append((needed_damping(scene, mu), frame.safe_damping))
        if found > 1e-6:
            wrong.append((frame.stage, frame.index, round(found, 4), frame.may_flutter))
    flagged = sum(frames[k].may_flutter for k in chosen)
    events = [event for frame in frames for event in frame.slips]
    ended = (
        "cut" if not checkpoint.done else checkpoint.failure.split(": ", 1)[-1][:45] if checkpoint.failure else "done"
    )
    return ended, needed, flagged, wrong, len(events), sum(event.located for event in events), values


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--scenes", type=int, default=500)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--more", action="store_true", help="with a drive, paths through points, another law")
    parser.add_argument("--nodes", type=int, nargs=2, default=(130, 200))
    arguments = parser.parse_args()
    ends, slips, located = Counter(), 0, 0
    here, needed = Counter(), []
    seeds = [(arguments.seed, k) for k in range(arguments.scenes)]
    with ProcessPoolExecutor(arguments.jobs) as pool:
        for seed, (ended, frames, flagged, bad, all_slips, found, values) in zip(
            seeds, pool.map(partial(judged, nodes=arguments.nodes, more=arguments.more), seeds), strict=True
        ):
            ends[ended] += 1
            slips, located = slips + all_slips, located + found
            told = sum(one[-1] for one in bad)
            here.update(frames=len(frames), flagged=flagged, told=told, untold=len(bad) - told)
            needed += frames
            if len(bad) > told:
                print(f"does not rest: {bad[:4]} of {len(bad)} in {seed}: {values}", file=sys.stderr, flush=True)
    print(f"{here['frames']} frames; {here['untold']} do not rest and do not say that they may not;", end=" ")
    print(f"of {here['flagged']} that say so {here['told']} do not rest")
    truth, estimate = np.array(needed).reshape(-1, 2).T
    weak = (truth > LEAST) & (estimate > 0.0)  # 0: all modes of the frame were judged
    over = truth[weak] / estimate[weak]
    print(f"{weak.sum()} frames with a wave that needs a damping above {LEAST:g}, by the spectrum over the estimate:")
    if weak.any():
        shown = ", ".join(f"{value:.2f}" for value in np.quantile(over, (0.1, 0.5, 0.9, 1.0)))
        print(f"    10 %, median, 90 %, largest: {shown}; above 1: {(over > 1.0).sum()}")
    print(f"{located} of {slips} slips located; runs:")
    for ended, count in ends.most_common():
        print(f"{count:6d}  {ended}")


if __name__ == "__main__":
    main()
