"""Certificates of followed runs: whether they find predictions that are wrong, and what they cost.

    python tests/bench/certify.py [--moves N] [--box N] [--rough N] [--wrong N] [--seed N] [--minutes M] [--json FILE]

Moves: random ones of held loads, drives, flats, waves; box: of the sliders' box; rough: of rough surfaces. Each is
followed from the exact skeleton of its start, certified, and compared with its exact run: they are one if slips agree
to 1e-3 nm and F and L to 5e-3 of their largest, 0.01 nm off slips. A certificate that holds over another run is false,
one that finds something in the same run a needless alarm. Of slips, exact: the largest difference of their loads.
Wrong: so many skeletons of each kind are made wrong on purpose in each of the ways of `on_purpose`; all are refused, or
right once their states are solved. Times are of the processor; those of the exact run are of a skeleton.
"""

import sys
import time
from dataclasses import replace
from math import inf

import numpy as np
from scenes import options, spread, write

from solver import NotConverged, NotFollowed, Scene, SceneError, certify, follow, skeleton_of
from solver.continuation.trace import Branch

KINDS = "box", "held", "drive", "flat", "wave", "rough"
LIMIT = 20.0  # s of processor time, of an exact run


def drawn(kind, rng):
    """(parameters of a scene, (name, value) of a move)."""
    values = {
        "E": float(f"{10 ** rng.uniform(1.3, 2.4):.4g}"),
        "phi_ratio": float(f"{10 ** rng.uniform(-1.0, 0.3):.3g}"),
        "delta_bar": float(f"{rng.uniform(-0.2, 0.8):.3g}"),
    }
    names = list(values)
    if kind == "held":
        values["hold"] = "load"
    elif kind == "drive":
        names.append(str(rng.choice(["drive_t", "drive_n"])))
        values[names[-1]] = float(f"{10 ** rng.uniform(1.0, 2.5):.3g}")
    elif kind == "flat":
        ratio = float(f"{10 ** rng.uniform(-2.7, -0.7):.3g}")
        values |= {"surface": "flat", "phi_ratio": ratio, "damping": inf if rng.random() < 0.5 else 1.0}
    elif kind == "wave":
        names.append("amplitude")
        values |= {
            "surface": "wave",
            "amplitude": float(f"{rng.uniform(1.0, 8.0):.3g}"),
            "waves": int(rng.integers(1, 5)),
        }
    elif kind == "rough":
        E = float(f"{10 ** rng.uniform(1.6, 2.6):.4g}")
        values |= {"surface": "rough", "seed": int(rng.integers(1, 99)), "E": E}
    name = names[int(rng.integers(len(names)))]
    if name == "delta_bar":
        return values, (name, float(f"{values[name] + rng.uniform(-0.2, 0.2):.3g}"))
    return values, (name, float(f"{values[name] * 2 ** rng.uniform(-0.5, 0.5):.4g}"))


def timed(call, *arguments, **options):
    """(the result or the failure, processor time, s)."""
    begun = time.thread_time()
    try:
        result = call(*arguments, **options)
    except (NotFollowed, NotConverged, SceneError) as failure:
        result = failure
    return result, time.thread_time() - begun


def apart(exact, found):
    """(largest difference of loads of slips, nm, inf if there are not as many; that of F and L over the largest)."""
    theirs, mine = ([event.load for event in one.slips] for one in (exact, found))
    slips = float(np.abs(np.subtract(theirs, mine)).max(initial=0.0)) if len(theirs) == len(mine) else inf
    U_x = np.linspace(0.0, exact.scene.u_x_max, 57)
    near = np.abs(U_x[:, None] - np.array([*theirs, -inf])).min(axis=1) < 0.01
    curves = np.array([one.curve(U_x)[:2] for one in (exact, found)])
    return slips, float(np.abs(curves[0] - curves[1])[:, ~near].max() / max(np.abs(curves[0]).max(), 1e-12))


def row_of(kind, rng):
    """One random move in numbers."""
    values, (name, value) = drawn(kind, rng)
    row = {"kind": kind, "scene": values, "move": [name, value]}
    try:
        scene, moved = Scene(**values), Scene(**(values | {name: value}))
    except SceneError:
        return row | {"what": "no scene"}
    base, _ = timed(skeleton_of, scene, LIMIT)
    if isinstance(base, Exception):
        return row | {"what": "no base"}
    followed, _ = timed(follow, base, moved)
    if isinstance(followed, Exception):
        return row | {"what": "not followed"}
    certificate, row["certified"] = timed(certify, followed)
    exact, row["seconds"] = timed(skeleton_of, moved, LIMIT)
    row |= {"holds": certificate.holds, "found": repr(certificate), "evaluations": certificate.evaluations}
    if isinstance(exact, Exception):
        return row | {"what": "no exact run", "exact": str(exact)}
    slips, curve = apart(exact, followed)
    same = slips < 1e-3 and curve < 5e-3
    if certificate.holds:
        row["U_s"] = apart(exact, certificate.skeleton)[0]
    word = {(True, True): "right", (True, False): "alarm", (False, True): "FALSE", (False, False): "wrong, found"}
    return row | {"what": word[same, certificate.holds], "ratio": row["certified"] / row["seconds"]}


def on_purpose(sk):
    """Yields (what, a Skeleton made wrong)."""
    scene, trace, branch = sk.scene, sk.trace, sk.branches[0]

    def changed(**values):
        return replace(sk, scene=scene.changed(**values))

    if branch.slip and sk.period:
        yield "lands two sites on", replace(sk, trace=replace(trace, period=2.0 * sk.period))
    yield "another E", changed(E=1.06 * scene.E)
    yield "another nu", changed(nu=scene.nu - 0.03)
    if scene.phi_ratio:
        yield "another ratio", changed(phi_ratio=1.02 * scene.phi_ratio)
    if branch.slip:
        beyond = Branch.of(np.append(branch.loads[:-1], branch.end + 0.3), branch.v)
        yield "a missing slip", replace(sk, trace=replace(trace, branches=(beyond,), period=0.0, home=0))
        early = branch.without(np.array([len(branch.states) - 1]))
        fold = branch.slip._replace(load=early.end, v=early.states[-1].v)
        yield "a slip too many", replace(sk, trace=replace(trace, branches=(replace(early, slip=fold),), home=0))
    if trace.jumps:
        yield "a missing jump", replace(sk, trace=replace(trace, jumps=trace.jumps[:-1]))


def wrongs(kind, count, rng):
    """Rows of skeletons made wrong on purpose: refused, or right as handed on."""
    made = 0
    while made < count:
        base, _ = timed(skeleton_of, Scene(**drawn(kind, rng)[0]), LIMIT)
        if isinstance(base, Exception):
            continue
        made += 1
        for what, wrong in on_purpose(base):
            certificate = certify(wrong)
            row = {"kind": kind, "wrong": what, "refused": not certificate.holds, "scene": base.scene.differences()}
            if certificate.holds:
                exact, _ = timed(skeleton_of, wrong.scene, 5.0 * LIMIT)
                row["right"] = not isinstance(exact, Exception) and apart(exact, certificate.skeleton)[0] < 1e-3
            yield row


def printed(rows):
    """Prints the figures of all rows."""
    for kind in KINDS:
        mine = [row for row in rows if row["kind"] == kind and "what" in row]
        print(
            f"{kind}: { ({what: sum(r['what'] == what for r in mine) for what in sorted({r['what'] for r in mine})}) }"
        )
        right = [row for row in mine if row["what"] == "right"]
        if right:
            both = [sum(row[name] for row in mine if "ratio" in row) for name in ("certified", "seconds")]
            ratios, U_s = spread([row["ratio"] for row in right]), max(row["U_s"] for row in right)
            shown = ", ".join(f"{ratio:.2f}" for ratio in ratios)
            print(f"    certified over exact {shown}; all together {both[0] / both[1]:.2f}; U_s off by {U_s:.1e} nm")
    wrong = [row for row in rows if "wrong" in row]
    for what in sorted({row["wrong"] for row in wrong}):
        mine = [row for row in wrong if row["wrong"] == what]
        right = sum(row.get("right", False) for row in mine)
        print(f"{what}: refused {sum(row['refused'] for row in mine)} of {len(mine)}, right as handed on {right}")


def main():
    parser = options(__doc__)
    for name, count in {"moves": 20, "box": 20, "rough": 10, "wrong": 2, "seed": 1}.items():
        parser.add_argument(f"--{name}", metavar="N", type=int, default=count, help="default %(default)s")
    parser.add_argument("--minutes", type=float, default=10.0, help="most time, default %(default)s")
    chosen = parser.parse_args()
    rng, end, rows = np.random.default_rng(chosen.seed), time.monotonic() + 60.0 * chosen.minutes, []
    counts = {kind: chosen.moves for kind in KINDS} | {"box": chosen.box, "rough": chosen.rough}
    certify(skeleton_of(Scene(nodes=64, width=160.0)))  # compiles
    for kind in KINDS:
        for _ in range(counts[kind]):
            if time.monotonic() < end:
                rows.append(row_of(kind, rng))
                if rows[-1]["what"] in ("FALSE", "alarm", "wrong, found"):
                    print(rows[-1], file=sys.stderr, flush=True)
        if time.monotonic() < end:
            rows += wrongs(kind, chosen.wrong, rng)
    printed(rows)
    write(chosen.json, rows)


if __name__ == "__main__":
    main()
