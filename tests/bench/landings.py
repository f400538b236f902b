"""Where slips land: the solver against an explicit GFMD that shares nothing with it but Scene (`plain_gfmd.py`).

    python tests/bench/landings.py [--scenes 300] [--from K] [--seed N] [--cache FILE] [--only-gfmd] [--json FILE]
    python tests/bench/landings.py --soft [--scenes 20] ...

First slip in shear of small rough, wavy, flat and measured cells. GFMD starts on the frame before the event of the
solver that fills the cache. It first follows the branch to 1e-3 nm below the event, and then slips four times:
from 1e-3 and 1e-2 nm of U_x beyond the event, with half and a sixth of the longest stable step. A scene is

    right        F and L after the slip are GFMD's, to 1e-3 of the force before it
    wrong        GFMD lands in one place four times, the solver elsewhere
    sensitive    GFMD itself lands in several places; the solver's frame has to say so (`Frame.sensitive`)
    other end    GFMD slips well before the event, or does not slip after it; or the solver under test has another event

--soft judges the whole run of soft punches: F at 40 nm with tolerance 1e-5 and du_x 0.5 against tolerance 1e-8 and
du_x 0.1, and against GFMD with du_x 0.1. GFMD starts each slip within 1e-3 or 1e-2 nm of the end of the branch.

--cache keeps GFMD's verdicts (a second a cell, minutes a punch): later versions of the solver need a minute.
"""

import sys
import time

import numpy as np
from scenes import Cache, cells, numbered, ran, scene_of, sheared, soft_punches, write

from plain_gfmd import NoRest, Plain, run  # isort: skip  (scenes makes it importable)
from solver import whole_surface

PATH = {"u_x_max": 60.0, "du_z": 0.25}  # of the cells
BELOW = 1e-3  # nm before the event up to which GFMD follows the branch
SLIPS = {"fine": (1e-3, 1.0 / 6.0), "coarse": (1e-3, 0.5), "far": (1e-2, 0.5), "far, fine": (1e-2, 1.0 / 6.0)}
STEPS = 12  # of the load on the way there
BEYOND = 0.02  # nm past the event, from where on frames are compared: farther than GFMD's start
GRID = 3  # increments at which GFMD's landing is known, as the solver may skip some where nothing rests
KICK = 1e-3  # nm, so that GFMD leaves a state that is symmetric or only just unstable
LEFT = 0.05  # nm; a smaller move is none
FAR = 0.5  # nm, beyond twice the increment of the load: a larger move is a slip
SAME = 1e-4  # nm, between the events of two versions
WRONG = 1e-3  # of the force before the slip; of soft punches, of the largest
LIMIT = 60.0  # s of processor time of a solver's run
BUDGET = 100_000  # force evaluations of GFMD from rest to rest, ten times what a usual slip takes


def first_slip(values):
    """(frames up to two after the first slip in shear, failure)."""
    after = []

    def done(frame):
        if after or (frame.stage == "shear" and frame.slip):
            after.append(frame)
        return len(after) > GRID

    frames, _, failure = ran(scene_of(values, **PATH), LIMIT, done)
    return frames, failure


def event_of(frames):
    """(number of the frame with the first slip in shear, its SlipEvent), or None."""
    slipped = (k for k, frame in enumerate(frames) if frame.stage == "shear" and frame.slip)
    k = next(slipped, None)
    return None if k is None else (k, frames[k].slips[0])


def by_gfmd(values):
    """GFMD's verdict on the first slip of the solver that is installed, in numbers."""
    frames, failure = first_slip(values)
    found = event_of(frames)
    if found is None:
        return {"why": failure or "no slip"}
    (k, event), scene, start = found, scene_of(values, **PATH), time.process_time()
    before = next((frame for frame in frames[k - 1 :: -1] if frame.stage == "shear"), frames[k - 1])
    row = {"U_s": event.load, "F_s": event.F_bar, "L_s": event.L_bar, "kind": event.kind}
    try:
        row |= judged(scene, whole_surface(before), before.U_x, event.load)
    except NoRest as restless:
        row["why"] = f"GFMD: {restless}"
    return row | {"seconds": time.process_time() - start}


def judged(scene, u, load, U_s):
    """Where GFMD lands, by start: F_bar and L_bar at the next loads of the grid, and by how many sites it slipped."""
    plain = Plain(scene, tolerance=1e-6, budget=BUDGET)
    arrived = plain.rest(u, load, -scene.delta)
    row = {"offset": float(np.abs(arrived.u - u).max())}
    # ever smaller steps towards the event, as the jolt of a larger one would carry the surface over its end
    for at in U_s - np.geomspace(max(U_s - load, BELOW), BELOW, STEPS)[1:]:
        try:
            before, arrived = arrived, plain.rest(arrived.u, at, -scene.delta)
        except NoRest:
            row["early"] = U_s - at
            break
        if moved(before.u, arrived.u) > FAR + 2.0 * (U_s - load):  # by flutter, which a jolt sets off
            row["early"], arrived = U_s - at, before
            break
    first = int(np.ceil((U_s + BEYOND) / scene.du_x))
    row["loads"] = [scene.shear_at(first + i) for i in range(GRID)]
    rng, row["landings"] = np.random.default_rng(0), {}
    for name, (offset, fraction) in SLIPS.items():
        plain = Plain(scene, fraction, tolerance=1e-6, budget=BUDGET)
        kicked = arrived.u + KICK * rng.uniform(-1.0, 1.0, u.shape)
        row["landings"][name] = landed(plain, kicked, U_s + offset, row["loads"])
    landings = row["landings"].values()
    if any("why" in landing for landing in landings):
        every = all("why" in landing for landing in landings)
        row["why"] = "GFMD does not come to rest" if every else "GFMD comes to rest from some starts only"
    elif min(landing["sites"] for landing in landings) * scene.spacing < LEFT:
        row["why"] = "GFMD does not slip after the event"
    return row


def landed(plain, u, load, later):
    """Sites slipped from u at this load, and F_bar, L_bar at later loads; or why there are none."""
    scene, forces, sites = plain.scene, [], np.inf
    try:
        rest = plain.rest(u, load, -scene.delta)
        sites = moved(u, rest.u) / scene.spacing
        for at in later:
            rest = plain.rest(rest.u, at, -scene.delta)
            forces.append((-rest.T[0].sum() / scene.nodes / scene.E, rest.T[1].sum() / scene.nodes / scene.E))
    except NoRest as restless:
        return {"sites": sites, "forces": forces, "why": str(restless)}
    return {"sites": sites, "forces": forces}


def moved(before, after):
    """The largest move of a node, nm."""
    return float(np.abs(after - before).max())


def off(row, a, b):
    """Difference of two (F_bar, L_bar) over the force before the slip."""
    return float(np.abs(np.subtract(a, b)).max() / max(abs(row["F_s"]), 0.1 * abs(row["L_s"])))


def compared(values, row):
    """The class of a scene for the solver that is installed."""
    frames, failure = first_slip(values)
    found = event_of(frames)
    said = any(getattr(frame, "sensitive", False) or frame.may_flutter for frame in frames)
    mine = {"said": said, "sites": None}
    U_s = found and found[1].load
    if (U_s is None) != ("U_s" not in row) or (U_s and abs(U_s - row["U_s"]) > SAME):
        return mine | {"class": "other end", "why": failure or f"U_s {U_s}, not {row.get('U_s')}"}
    if "why" in row:
        return mine | {"class": row["why"].split(":")[0].split(" at ")[0], "why": row["why"]}
    fine = row["landings"]["fine"]
    spread = max(off(row, landing["forces"][0], fine["forces"][0]) for landing in row["landings"].values())
    at = {round(load / PATH.get("du_x", 0.1)): k for k, load in enumerate(row["loads"])}
    frame = next((f for f in frames[found[0] :] if f.stage == "shear" and f.index in at), None)
    if frame is None:  # the solver raised the load past the grid until the surface came to rest
        return mine | {"class": "sensitive" if spread > WRONG else "gives up", "sites": fine["sites"], "why": failure}
    error = off(row, (frame.F_bar, frame.L_bar), fine["forces"][at[frame.index]])
    named = "sensitive" if spread > WRONG else "wrong" if error > WRONG else "right"
    forces = (frame.F_bar, fine["forces"][at[frame.index]][0], row["F_s"])
    numbers = {"error": error, "spread": spread, "sites": fine["sites"], "forces": forces, "early": row.get("early")}
    return mine | {"class": named} | numbers


def soft_gfmd(values):
    """F_bar, L_bar at the end of the run by GFMD, for three starts and steps."""
    ends = {}
    for name, (near, fraction) in {"fine": (1e-3, 1 / 6), "coarse": (1e-3, 0.5), "far": (1e-2, 0.5)}.items():
        start = time.process_time()
        try:
            *_, last = run(scene_of(values, du_z=0.5, tolerance=1e-6), fraction, increment=nearly(near))
            ends[name] = [last.F_bar, last.L_bar]
        except NoRest as restless:
            ends[name] = str(restless)
        print(f"  GFMD {name}: {ends[name]}, {time.process_time() - start:.0f} s", file=sys.stderr, flush=True)
    return ends


def nearly(near):
    """An increment of plain_gfmd.run that starts every slip within `near` nm of the end of its branch."""

    def increment(plain, u, U_x, U_z, p0):
        low = increment.U_x if U_x > increment.U_x else U_x
        while True:
            at, rest = U_x, plain.rest(u, U_x, U_z, p0)
            while at - low > near and moved(u, rest.u) > FAR + 2.0 * (at - low):
                middle = 0.5 * (low + at)
                half = plain.rest(u, middle, U_z, p0)
                if moved(u, half.u) > FAR + 2.0 * (middle - low):
                    at, rest = middle, half
                else:
                    low, u = middle, half.u
            low, u = at, rest.u
            if at == U_x:
                increment.U_x = U_x
                return rest

    increment.U_x = 0.0
    return increment


def soft_compared(values, ends):
    """The class of a soft punch: ends of two runs of the solver, and GFMD's."""
    row = {"said": False, "sites": None, "ends": {}}
    for name, own in {"lax": {"tolerance": 1e-5, "du_x": 0.5}, "strict": {"tolerance": 1e-8, "du_x": 0.1}}.items():
        frames, _, failure = ran(scene_of(values, **own), 3.0 * LIMIT)
        if failure:
            return row | {"class": "gives up", "why": failure}
        row["ends"][name] = (frames[-1].F_bar, frames[-1].L_bar)
        row["said"] |= any(getattr(frame, "sensitive", False) for frame in frames)
    scale = max(abs(frame.F_bar) for frame in frames)
    agreed = [end for end in ends.values() if not isinstance(end, str)]
    row["error"] = float(np.abs(np.subtract(*row["ends"].values())).max() / scale)
    fine = agreed[0] if agreed else row["ends"]["strict"]
    row["against GFMD"] = max(float(np.abs(np.subtract(e, fine)).max() / scale) for e in row["ends"].values())
    spread = max((float(np.abs(np.subtract(end, fine)).max() / scale) for end in agreed), default=np.inf)
    unsure = spread > WRONG or len(agreed) < len(ends)
    wrong = row["error"] > WRONG or (not unsure and row["against GFMD"] > WRONG)
    row |= {"spread": spread, "slips": len(sheared(frames)), "sites": 0.0}
    return row | {"class": "sensitive" if unsure and wrong else "wrong" if wrong else "right"}


def summary(rows):
    """Print the figures of all rows."""
    slips = [row for row in rows if row["class"] in ("right", "wrong", "sensitive")]
    far = sum(row["sites"] >= 1.5 for row in slips)
    print(f"{len(rows)} scenes, {len(slips)} slips judged, {far} by 2 sites or more")
    for name in dict.fromkeys(row["class"] for row in rows):
        own = [row for row in rows if row["class"] == name]
        print(f"{len(own):5}  {name}; {sum(row['said'] for row in own)} carry the caution")
    wrong = [row for row in slips if row["class"] == "wrong"]
    print(f"wrong without the caution: {sum(not row['said'] for row in wrong)} of {len(slips)}", end="; ")
    print(f"by 2 sites or more: {sum(row['sites'] >= 1.5 for row in wrong)}")


def main():
    options = numbered(__doc__, None)
    options.add_argument("--cache", metavar="FILE")
    options.add_argument("--only-gfmd", action="store_true", help="fill the cache, compare nothing")
    options.add_argument("--seed", type=int, default=30, help="of the cells (default: %(default)s)")
    options.add_argument("--soft", action="store_true", help="soft punches, to the end of the run")
    chosen = options.parse_args()
    cache, rows = Cache(chosen.cache), []
    scenes = soft_punches(chosen.scenes or 20) if chosen.soft else cells(chosen.scenes or 300, chosen.seed)
    for k, values in enumerate(scenes):
        if k < chosen.first:
            continue
        gfmd = cache.get(values, soft_gfmd if chosen.soft else by_gfmd)
        if chosen.only_gfmd:
            print(
                k,
                values,
                {name: gfmd[name] for name in ("why", "seconds") if name in gfmd},
                file=sys.stderr,
                flush=True,
            )
            continue
        row = {"number": k, "scene": values} | (soft_compared if chosen.soft else compared)(values, gfmd)
        rows.append(row)
        if row["class"] != "right":
            print({name: value for name, value in row.items() if value is not None}, file=sys.stderr, flush=True)
    if rows:
        summary(rows)
    write(chosen.json, rows)


if __name__ == "__main__":
    main()
