"""Whether slips land where the paper's GFMD lands: 160 scenes unlike the default, against tests/shared/plain_gfmd.py.

    python tests/bench/others.py [--cache FILE] [--json FILE] [--only-gfmd] [--kinds NAME ...] [--every N] [--length NM]

Rough, wavy, thick (h = 5 w), thin (0.3 w) and nearly incompressible layers, held loads (in tension, too), and other
damping; indentation, friction and modulus from a low-discrepancy sequence in the slider box. Both methods make the same
increments until just after the second slip in shear; F_bar and L_bar are compared in every frame, to 1e-4 of their
largest. GFMD locates the start of every slip by halving the increment. It then repeats the slip from farther beyond the
end of the branch (a 16th of the increment, and all of it) and with half the time step. Where fast differs, GFMD also
starts from the state of fast before the slip, as it is and with a kick of 1e-3 nm. A difference is

    bifurcation  GFMD itself lands elsewhere with half the time step or from a 16th of the increment
    increment    GFMD lands as fast does, but only where it makes the whole increment at once, or is kicked
    fast wrong   GFMD lands in one state, fast in another

--cache keeps GFMD's results in a file, --only-gfmd fills it and compares nothing; --kinds takes the optional ones too.
"""

import json
import sys
import time

import numpy as np
from scenes import Cache, options, write

from plain_gfmd import NoRest, Plain, run  # isort: skip  (scenes makes it importable)
from solver import NotConverged, Scene, load_path, whole_surface

COMMON = {"nodes": 256, "width": 625.0, "du_x": 0.25, "du_z": 0.25, "tolerance": 1e-6, "u_x_max": 25.0}
BOX = {"delta_bar": (-0.6, 1.0), "phi_ratio": (0.05, 2.0), "E": (10.0, 300.0)}  # the last two by their logarithms
KINDS = {  # number of scenes, their parameters, the range of delta_bar where it is another one
    "rough": (25, {"surface": "rough"}, (-0.2, 1.0)),
    "wave": (20, {"surface": "wave"}, (-0.2, 1.0)),
    "thick": (20, {"height": 5.0}, None),
    "thin": (20, {"height": 0.3}, None),
    "nu 0.49": (15, {"nu": 0.49}, None),
    "nu 0.499": (15, {"nu": 0.499}, None),
    "nu 0.4999": (10, {"nu": 0.4999}, None),
    "held": (20, {"hold": "load"}, (-0.4, 0.8)),
    "damping 0.3": (8, {"damping": 0.3}, None),
    "damping 4": (7, {"damping": 4.0}, None),
}
OPTIONAL = {
    "loop": (8, {"path": "loop", "u_x_max": 10.0}, None),
    "damping inf": (6, {"damping": float("inf")}, None),
}
SLIPS = 2  # in shear
AFTER = 3  # increments after the last of them
FAR = 0.5  # nm, beyond twice the increment: a larger move of a node is a slip
FINE, CLOSEST = 4, 10  # halvings of an increment: the second start of a slip, and the first
SAME = 0.05  # nm, between two states
WRONG = 1e-4  # of the largest F_bar or L_bar
KICK = 1e-3  # nm
CLASSES = ("same", "bifurcation", "increment", "fast wrong", "fast gives up", "gfmd has no rest")


def scenes(kinds):
    """(kind, parameters) of all scenes; a kind's scenes do not depend on the choice of other kinds."""
    growth = (
        1.2207440846057596  # the root of x^4 = x + 1: the additive sequence that fills three dimensions most evenly
    )
    found, k = [], 0
    for kind, (count, values, pressed) in (KINDS | OPTIONAL).items():
        for i in range(count):
            k += 1
            x = [(0.5 + k * growth**-d) % 1.0 for d in (1, 2, 3)]
            low, high = pressed or BOX["delta_bar"]
            own = {"delta_bar": round(low + (high - low) * x[0], 3)}
            own["phi_ratio"], own["E"] = (
                float(f"{low * (high / low) ** y:.4g}")
                for (low, high), y in zip((BOX["phi_ratio"], BOX["E"]), x[1:], strict=True)
            )
            if kind == "rough":
                own |= {"seed": i + 1, "rms_slope": (0.01, 0.03)[i % 2]}
            if kind == "wave":
                own |= {"waves": (2, 3)[i % 2], "amplitude": (5.0, 3.0)[i % 2]}
            if kind in kinds:
                found.append((kind, COMMON | values | own))
    return found


class Closely:
    """Increments of the plain GFMD that locate slips; `slips`: those of the last increment, as numbers."""

    def __init__(self, scene):
        self.scene, self.top, self.slips = scene, None, []
        self.finer = Plain(scene, 0.25)

    def __call__(self, plain, u, U_x, U_z, p0):
        start, end, self.slips = np.array(self.top or (U_x, U_z)), np.array((U_x, U_z)), []
        if p0 is not None:
            start[1] = U_z  # a result of the held load
        far, done = FAR * min(self.scene.delta_n, self.scene.delta_t) + 2.0 * np.abs(end - start).max(), 0.0
        while True:
            rest = plain.rest(u, *end, p0)
            if self._moved(rest, u, far):
                rest, u, done = self._slip(plain, u, start, end, done, rest, p0, far)
            else:
                done = 1.0
            if done == 1.0:
                self.top = U_x, rest.U_z
                return rest

    def _moved(self, rest, u, far):
        return np.abs(rest.u - u).max() > far

    def _slip(self, plain, u, start, end, low, whole, p0, far):
        """(rest, u, share of the increment done) after the slip between share `low` of the increment and its end."""
        high, after, others = 1.0, whole, {"whole": whole}
        for k in range(CLOSEST):
            if k == FINE:
                others["fine"] = plain.rest(after.u, *end, p0)
            middle = 0.5 * (low + high)
            half = plain.rest(u, *(start + middle * (end - start)), p0)
            if self._moved(half, u, far):
                high, after = middle, half
            else:
                low, u = middle, half.u
        beyond = start + high * (end - start)
        others["half step"] = self.finer.rest(self.finer.rest(u, *beyond, p0).u, *end, p0)
        reached = plain.rest(after.u, *end, p0)
        lowest = int(np.argmin(self.scene.profile + u[1]))
        self.slips.append(
            {
                "at": (beyond * (1.0, -1.0)).tolist(),
                "sites": round(float(after.u[0, lowest] - u[0, lowest]) / self.scene.spacing, 2),
                "minds": {name: float(np.abs(rest.u - reached.u).max()) for name, rest in others.items()},
                "before": np.round(u, 7).tolist(),
                "after": np.round(after.u, 7).tolist(),
            }
        )
        return (after, after.u, 1.0) if high == 1.0 else (reached, after.u, high)


def by_gfmd(values):
    """The run of the plain GFMD as numbers: frames (stage, index, F_bar, L_bar, A_bar), slips, p0, failure."""
    scene = Scene(**values)
    closely = Closely(scene)
    found = {"frames": [], "slips": [], "p0": None, "failure": None}
    begun, spent, last, slips = time.perf_counter(), 0, None, 0
    try:
        for record in run(scene, increment=closely):
            spent += record.evaluations
            if record.stage == "approach" and scene.hold == "load":
                found["p0"] = record.L_bar * scene.E
            found["frames"].append((record.stage, record.index, record.F_bar, record.L_bar, record.A_bar))
            found["slips"] += [slip | {"stage": record.stage, "index": record.index} for slip in closely.slips]
            slips += len(closely.slips) if record.stage != "approach" else 0
            if scene.path == "shear" and slips >= SLIPS:
                last = record.index + AFTER if last is None else last
                if record.index >= last:
                    break
    except NoRest as failure:
        found["failure"] = str(failure)
    spent += closely.finer.evaluations
    return found | {"evaluations": spent, "seconds": time.perf_counter() - begun}


def compared(values, gfmd):
    """The class of a scene, and where and how fast differs."""
    scene, frames, failure = Scene(**values), [], None
    try:
        for _, frame in zip(gfmd["frames"], load_path(scene), strict=False):
            frames.append(frame)
    except NotConverged as given_up:
        failure = str(given_up)
    except Exception as crash:  # a crash is a result, too
        failure = f"{type(crash).__name__}: {crash}"
    mine = np.array([(f.F_bar, f.L_bar) for f in frames]).reshape(-1, 2)
    theirs = np.array([frame[2:4] for frame in gfmd["frames"]]).reshape(-1, 2)
    error = (np.abs(mine - theirs[: len(mine)]) / np.maximum(np.abs(theirs).max(axis=0), 1e-12)).max(axis=1)
    bad = error > WRONG
    both = np.flatnonzero(bad & np.append(bad[1:], True))  # in one frame alone, the slip came just before or after it
    row = {"error": float(error[~bad].max(initial=0.0)), "alone": int(bad.sum()), "where": None, "why": failure}
    row["sites"] = [slip["sites"] for slip in gfmd["slips"]]
    if not both.size:
        if gfmd["failure"] and len(frames) == len(gfmd["frames"]):
            named, row["why"] = "gfmd has no rest", gfmd["failure"]
        else:
            named = "fast gives up" if len(frames) < len(gfmd["frames"]) else "same"
        return row | {"class": named}
    k = int(both[0])
    row |= {"where": gfmd["frames"][k][:2], "alone": int(bad[:k].sum())}
    return row | differs(scene, gfmd, frames, k)


def differs(scene, gfmd, frames, k):
    """Why frame k is the first that differs from GFMD's: where GFMD goes from the state of fast before it."""
    place = list(gfmd["frames"][k][:2])
    minds = [slip["minds"] for slip in gfmd["slips"] if [slip["stage"], slip["index"]] == place]
    unsure = [name for mind in minds for name, value in mind.items() if value > SAME and name != "whole"]
    evidence = {"fast F": frames[k].F_bar, "gfmd F": gfmd["frames"][k][2], "slips": (len(frames[k].slips), len(minds))}
    evidence["whole"] = [mind["whole"] for mind in minds]
    landed = {}
    for name, kick in (("as it is", 0.0), ("kicked", KICK)):
        u = whole_surface(frames[k - 1])
        u += kick * np.random.default_rng(0).uniform(-1.0, 1.0, u.shape)
        p0 = gfmd["p0"] if frames[k].stage != "approach" else None
        try:
            T = Plain(scene).rest(u, frames[k].U_x, -frames[k].delta, p0).T
            landed[name] = float(-T[0].sum() / (scene.nodes * scene.E))
        except NoRest as failure:
            landed[name] = str(failure)
    scale = max(abs(frame[2]) for frame in gfmd["frames"])
    as_fast = [
        name for name, F in landed.items() if not isinstance(F, str) and abs(F - frames[k].F_bar) < WRONG * scale
    ]
    evidence |= {"from fast's state": landed, "gfmd lands as fast": as_fast, "gfmd unsure": unsure}
    named = "bifurcation" if unsure else "increment" if as_fast else "fast wrong"
    return {"class": named, "evidence": evidence}


def table(rows):
    """Scenes by kind and class, and the share that lands where GFMD lands."""
    print(
        f"{'':14}{'scenes':>8}{'slipping':>9}{'slips':>7}"
        + "".join(f"{name:>18}" for name in CLASSES)
        + f"{'share':>8}"
    )
    for kind in [*dict.fromkeys(row["kind"] for row in rows), "all"]:
        own = [row for row in rows if kind in ("all", row["kind"])]
        counts = [sum(row["class"] == name for row in own) for name in CLASSES]
        slips = [len(row["sites"]) for row in own]
        share = counts[0] / max(1, sum(counts[:-1]))
        text = "".join(f"{count:18}" for count in counts)
        print(f"{kind:14}{len(own):8}{sum(s > 0 for s in slips):9}{sum(slips):7}{text}{share:8.0%}")


def main():
    parser = options(__doc__)
    parser.add_argument("--cache", metavar="FILE")
    parser.add_argument("--only-gfmd", action="store_true")
    parser.add_argument("--kinds", metavar="NAME", nargs="+", choices=[*KINDS, *OPTIONAL], default=list(KINDS))
    parser.add_argument("--every", metavar="N", type=int, default=1, help="only every N-th scene")
    parser.add_argument("--length", metavar="NM", type=float, default=COMMON["u_x_max"], help="of the path in shear")
    arguments = parser.parse_args()
    cache, rows = Cache(arguments.cache), []
    for kind, values in scenes(arguments.kinds)[:: arguments.every]:
        values["u_x_max"] = min(values["u_x_max"], arguments.length)
        gfmd = json.loads(json.dumps(cache.get(values, by_gfmd)))
        if arguments.only_gfmd:
            continue
        begun = time.perf_counter()
        rows.append({"kind": kind, "scene": values, **compared(values, gfmd), "seconds": time.perf_counter() - begun})
        row = rows[-1]
        own = {name: value for name, value in values.items() if COMMON.get(name) != value}
        print(
            f"{kind:12}{row['class']:18}{row['where'] or ''!s:18}{row['why'] or ''} {own}", file=sys.stderr, flush=True
        )
        if "evidence" in row:
            print(f"{'':12}{row['evidence']}", file=sys.stderr, flush=True)
    if rows:
        table(rows)
    write(arguments.json, rows)


if __name__ == "__main__":
    main()
