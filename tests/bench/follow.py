"""What following a slider costs and whether it is right: 120 scenes of its box, three small moves and a long one each.

    python tests/bench/follow.py [--json FILE] [--scenes N] [--held]

Scenes are random over E 10 .. 1000, delta_bar -0.6 .. 1 and phi_ratio 0.02 .. 2; --held: under held loads, delta_bar
-0.4 .. 0.8. The small moves are one event of a drag, the long one is many at once. Every move is followed from the
frames of its scene, and also run from the start. Two runs are of one kind if both slip by as many sites each time, or
neither slips. Of the moves between such runs: the share followed, force evaluations, processor time over that of the
exact run, force evaluations for each state of a skeleton, its kilobytes as the app sends them, the largest error of a
slip's load U_s (nm) and of F, L and A over their largest, at all increments. Each move that was not followed prints
why, and what the exact runs do.
"""

import sys
import time

import numpy as np
from scenes import held_box, numbered, ran, scene_of, sheared, slider_box, spread, write

from app.service.skeletons import packed
from solver import NotFollowed, Scene, follow, load_path, skeleton_of
from solver.run.frame import slips_in

SMALL = {"delta_bar": lambda x: x + 0.03, "E": lambda x: 1.08 * x, "phi_ratio": lambda x: 0.93 * x}
LONG = {"delta_bar": lambda x: x + 0.2, "E": lambda x: 1.6 * x, "phi_ratio": lambda x: 0.6 * x}
WANTED = {"U_s": 1e-4, "F": 1e-3, "L": 1e-3, "A": 1e-3}  # errors; U_s in nm
COSTS = "evaluations", "a state", "kB", "ratio"
LEAST = np.array([1e-12, 1e-12, 1e-4])  # F_bar, L_bar and A_bar that count as none
TOUCHING = 1.5  # delta_n, largest gap in the middle of a contact
FAR = 100.0  # factor of WANTED beyond which a run is another one
SAME = 1e-3  # of a site, by which periods of slips may differ


def moves(number, scene):
    """(name, small or long, the Scene moved to)."""
    for name, moved in SMALL.items():
        yield name, "small", scene.changed(**{name: moved(getattr(scene, name))})
    name = list(LONG)[number % len(LONG)]
    yield name, "long", scene.changed(**{name: LONG[name](getattr(scene, name))})


def slips(frames):
    """Loads of the slips in shear, nm."""
    return [event.load for event in sheared(frames)]


def kind(scene, frames):
    """What two runs have in common if one can be followed to the other: contact, slips, and by how many sites."""
    first = next(frame for frame in frames if frame.stage == "shear")
    loads = np.array(slips(frames))
    periods = np.diff(loads[-4:])
    sites = sorted({round(period / scene.spacing / SAME) for period in periods})
    return bool(first.gap.min() < TOUCHING * scene.delta_n), loads.size > 0, sites, loads.size


def alike(kinds):
    """Whether two runs are of one kind, as far as they tell: one that slips but once says nothing of sites."""
    before, after = kinds
    return before[:2] == after[:2] and (before[2] == after[2] or min(before[3], after[3]) < 2)


def compared(skeleton, frames):
    """Errors of a followed run: U_s in nm, F, L and A over their largest."""
    theirs, mine = slips(frames), [event.load for event in slips_in(skeleton)]
    U_s = np.abs(np.subtract(mine, theirs)).max(initial=0.0) if len(mine) == len(theirs) else np.inf
    # so near to a slip, one of the two has slipped and the other has not
    ends = np.array([*theirs, -np.inf])
    sheared = [f for f in frames if f.stage == "shear" and np.abs(f.U_x - ends).min() > WANTED["U_s"]]
    exact = np.array([[frame.F_bar, frame.L_bar, frame.A_bar] for frame in sheared]).T
    found = np.array(skeleton.curve(np.array([frame.U_x for frame in sheared])))
    errors = np.abs(found - exact).max(axis=1) / np.maximum(np.abs(exact).max(axis=1), LEAST)
    return dict(zip(WANTED, map(float, (U_s, *errors)), strict=True))


def row_of(scene, before, skeleton, name, size, moved):
    """One move in numbers."""
    row = {"E": scene.E, "delta_bar": scene.delta_bar, "phi_ratio": scene.phi_ratio, "moved": name, "size": size}
    exact, exact_seconds, failure = ran(moved)
    start = time.process_time()
    try:
        followed = follow(skeleton, moved)
        row["evaluations"] = followed.evaluations
        row["a state"] = followed.evaluations / sum(len(branch.states) for branch in followed.branches)
    except NotFollowed as refusal:
        followed, row["why"] = None, str(refusal)
    row["seconds"] = time.process_time() - start
    row["ratio"] = row["seconds"] / exact_seconds
    if followed:
        row["kB"] = len(packed(followed)) / 1e3
    if failure:
        return row | {"alike": False, "exact": "not done"}
    kinds = kind(scene, before), kind(moved, exact)
    row |= {"alike": alike(kinds), "slips": [slips(before)[:3], slips(exact)[:3]]}
    return row | {"errors": compared(followed, exact)} if followed else row


def rows_of(scenes):
    for number, scene in enumerate(map(scene_of, scenes)):
        before, _, failure = ran(scene)
        try:
            skeleton = None if failure else skeleton_of(scene)
        except NotFollowed as refusal:
            print(f"scene {number}: {refusal}", file=sys.stderr, flush=True)
            continue
        for name, size, moved in moves(number, scene) if skeleton else ():
            yield row_of(scene, before, skeleton, name, size, moved)


def summary(rows):
    """The figures of the whole box."""
    alike = [row for row in rows if row["alike"]]
    done = [row for row in alike if "errors" in row]
    right = {name: float(np.mean([row["errors"][name] <= most for row in done])) for name, most in WANTED.items()}
    return {
        "moves": len(rows),
        "alike": len(alike),
        "followed": {size: _share(alike, size) for size in ("small", "long")} | {"all": _share(alike, None)},
        **{name: spread([row[name] for row in done]) for name in COSTS},
        "errors": {name: spread([row["errors"][name] for row in done]) for name in WANTED},
        "right": right | {"F, L, A": float(np.mean([all(row["errors"][n] <= 1e-3 for n in "FLA") for row in done]))},
        "other_run_followed": sum(_wrong(row) for row in rows if "errors" in row),
    }


def _wrong(row):
    """Whether a followed run is another one than the exact run: slips or forces are far beyond the errors wanted."""
    return any(row["errors"][name] > FAR * WANTED[name] for name in ("U_s", "F", "L"))


def _share(rows, size):
    rows = [row for row in rows if size in (None, row["size"])]
    return sum("errors" in row for row in rows) / max(1, len(rows))


def report(found):
    print("{moves} moves, {alike} between runs of one kind".format(**found))
    print("followed of these: " + ", ".join(f"{size} {share:.1%}" for size, share in found["followed"].items()))
    print(f"{'':12}{'median':>10}{'p95':>10}{'worst':>10}{'right':>8}")
    for name in COSTS:
        print(f"{name:12}" + "".join(f"{value:10.3g}" for value in found[name]))
    for name, values in found["errors"].items():
        print(f"{name:12}" + "".join(f"{value:10.1e}" for value in values) + f"{found['right'][name]:8.1%}")
    print(f"F, L and A all right: {found['right']['F, L, A']:.1%}")
    print(f"followed, and another run than the exact one: {found['other_run_followed']}")


def main():
    options = numbered(__doc__, 120)
    options.add_argument("--held", action="store_true", help="under held loads")
    arguments = options.parse_args()
    list(load_path(Scene(u_x_max=12.0)))  # compiled, before anything is timed
    rows = []
    for row in rows_of((held_box if arguments.held else slider_box)(arguments.scenes)):
        rows.append(row)
        if "why" in row and row["alike"]:
            where = "E {E:.4g} delta_bar {delta_bar:.3f} ratio {phi_ratio:.3g}, {size} {moved}: {why}".format(**row)
            print(
                f"not followed: {where}; slips at {row['slips'][0]}, then at {row['slips'][1]}",
                file=sys.stderr,
                flush=True,
            )
    found = summary(rows)
    report(found)
    write(arguments.json, {"summary": found, "rows": rows})
    return 0


if __name__ == "__main__":
    sys.exit(main())
