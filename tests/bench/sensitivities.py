"""Whether derivatives of the first slip are right, and what they cost: scenes of the slider box, and held loads.

    python tests/bench/sensitivities.py [--scenes 40] [--held] [--json FILE]

Every scene is judged by exact runs, which share no fold and no skeleton with `sensitivities`: U_s, F_s and A_s by the
run's own event, their derivatives by the events of runs with a little more and less of delta_bar, E and phi_ratio.
A scene is right, wrong silently (a value or a derivative differs), or refused (no answer for a run that slips).
Scenes are those of `follow.py`: the punch, a wave, a rough surface and a held load in turn. --held: punches under a
held load of delta_bar -0.4 .. 0.8, 100 by default.

Without --held, all continuous parameters are also compared with central differences of followed runs, to WANTED, and
the cost is measured: processor time over that of the run, of slips alone and with the branches between them.
"""

import sys
import time

import numpy as np
from scenes import held_box, numbered, ran, scene_of, sheared, slider_box, spread, write

from solver import NotConverged, NotFollowed, Scene, SceneError, follow, skeleton_of
from solver.analysis.partial import continuous
from solver.analysis.sensitivities import sensitivities

KINDS = (
    {},
    {"surface": "wave", "waves": 1, "amplitude": 10.0},
    {"surface": "rough", "cut_off": 0.2, "rms_slope": 0.003, "roll_off": 0.45},
    {"hold": "load"},
)
# Of a parameter. Which step is best depends on how close the next fold lies.
STEPS = (1e-3, 1e-4, 1e-5)
WANTED = 1e-5
EXACT = 1e-3  # step of a parameter between exact runs
VALUE, DERIVATIVE = 1e-4, 0.01  # largest errors against exact runs: U_s in nm, F_s and A_s over their own; derivatives


def event_of(scene):
    """(4,) U_s (nm), F_s, L_s, A_s of the first slip of an exact run, or None."""
    events = sheared(ran(scene, until=lambda frame: sheared([frame]))[0])
    force = scene.width * scene.E
    bars = [events[0].load, events[0].F_bar * force, events[0].L_bar * force] if events else None
    return np.array([*bars, events[0].A_bar * scene.width]) if bars else None


def sizes(values):
    """(4,) what counts as one of U_s, F_s, L_s, A_s: forces by the larger one."""
    size = np.abs(values)
    size[1:3] = size[1:3].max()
    return np.maximum(size, 1e-12)


def by_runs(scene, slip):
    """(error of the values, {parameter: error of the derivatives}) of a SlipSensitivity against exact runs."""
    exact, errors = event_of(scene), {}
    if exact is None:
        return np.inf, errors
    size = np.maximum(sizes(exact), (1.0, 0.0, 0.0, 1e-3))
    for name in ("delta_bar", "E", "phi_ratio"):
        h = EXACT * max(abs(getattr(scene, name)), 0.1)
        ends = [event_of(scene.changed(**{name: getattr(scene, name) + side})) for side in (h, -h)]
        if all(end is not None and abs(end[0] - exact[0]) < 0.1 for end in ends):  # else they slip elsewhere
            rate = (ends[0] - ends[1]) / (2.0 * h)
            bend = np.abs(ends[0] - 2.0 * exact + ends[1]) / h  # how much the two sides differ: then no derivative
            floor = np.maximum(sizes(slip.by[name]), 0.01 * size / max(abs(getattr(scene, name)), 0.1))
            noise = bend + np.abs(exact - slip.values) / h
            errors[name] = float((np.maximum(np.abs(rate - slip.by[name]) - noise, 0.0) / floor)[[0, 1, 3]].max())
    return float((np.abs(exact - slip.values) / size)[[0, 1, 3]].max()), errors


def difference(skeleton, name, step):
    """(4,) derivatives of the first slip by central differences of followed runs."""
    value = getattr(skeleton.scene, name)
    h, ends = step * max(abs(value), 0.1), []
    for side in (h, -h):
        beside = follow(skeleton, skeleton.scene.changed(**{name: value + side}))
        ends.append(sensitivities(beside, (), branches=False).slips[0].values)
    return (ends[0] - ends[1]) / (2.0 * h)


def by_following(skeleton, slip):
    """{parameter: the least over STEPS of the largest error}; those that are not followed are left out."""
    found = {}
    for name in continuous(skeleton.scene):
        size = sizes(slip.by[name])
        for step in STEPS:
            try:
                error = float((np.abs(difference(skeleton, name, step) - slip.by[name]) / size).max())
            except (NotFollowed, IndexError):
                continue
            found[name] = min(error, found.get(name, np.inf))
    return found


def row_of(scene, following):
    """A scene in numbers; following: compare with followed runs, too."""
    frames, seconds, failure = ran(scene)
    events = sheared(frames)
    if failure or not events:
        return {"class": "no slip" if not failure else "run ends early", "why": failure}
    try:
        skeleton = skeleton_of(scene)
        skeleton = follow(skeleton, scene)
        costs = []
        for branches in (False, True):
            start = time.process_time()
            found = sensitivities(skeleton, branches=branches)
            costs.append((time.process_time() - start) / seconds)
    except (NotFollowed, NotConverged) as refusal:
        return {"class": "refused", "why": str(refusal)}
    row = {"costs": costs, "seconds": seconds}
    if not found.slips:
        return row | {"class": "wrong silently", "why": f"no slip, the run slips at {events[0].load:.6g} nm"}
    value, errors = by_runs(scene, found.slips[0])
    right = value <= VALUE and max(errors.values(), default=0.0) <= DERIVATIVE
    row |= {"class": "right" if right else "wrong silently", "value": value, "by runs": errors}
    return row | ({"errors": by_following(skeleton, found.slips[0])} if following else {})


def scenes(chosen):
    """Parameters of the scenes asked for on the command line."""
    if chosen.held:
        yield from held_box(chosen.scenes or 100)
        return
    for number, values in enumerate(slider_box(chosen.scenes or 40)):
        yield values | KINDS[number % len(KINDS)]


def report(rows):
    """Print the figures of all rows."""
    for name in dict.fromkeys(row["class"] for row in rows):
        print(f"{sum(row['class'] == name for row in rows):5}  {name}")
    every = [error for row in rows for error in row.get("errors", {}).values()]
    if every:
        print(f"{len(every)} derivatives, {np.mean(np.array(every) <= WANTED):.1%} right to {WANTED:g} by following")
        print("error, median / p95 / worst: " + " / ".join(f"{value:.1e}" for value in spread(every)))
    every = [error for row in rows for error in row.get("by runs", {}).values()]
    print(f"{len(every)} by exact runs, median / p95 / worst: " + " / ".join(f"{value:.1e}" for value in spread(every)))
    for k, what in enumerate(("slips alone", "slips and branches")):
        costs = spread([row["costs"][k] for row in rows if "costs" in row])
        print(f"cost of {what} over the run, median / p95 / worst: " + " / ".join(f"{value:.1%}" for value in costs))


def main():
    options = numbered(__doc__, None)
    options.add_argument("--held", action="store_true", help="held loads, by exact runs alone")
    chosen, rows = options.parse_args(), []
    small = Scene(u_x_max=12.0)
    sensitivities(skeleton_of(small))  # compiled, before anything is timed
    for number, values in enumerate(scenes(chosen)):
        if number < chosen.first:
            continue
        try:
            rows.append({"number": number, "scene": values} | row_of(scene_of(values), not chosen.held))
        except SceneError:
            continue
        if rows[-1]["class"] not in ("right", "no slip"):
            print({name: value for name, value in rows[-1].items() if name != "costs"}, file=sys.stderr, flush=True)
    report(rows)
    write(chosen.json, rows)
    return 0


if __name__ == "__main__":
    sys.exit(main())
