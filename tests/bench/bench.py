"""Cost of the presets in one process, against the method gfmd at equal error, and against the number of nodes.

    python tests/bench/bench.py [--json FILE] [--quick] [--scenes N]

Columns: force evaluations; median seconds of five runs (compiled, warm); microseconds per evaluation; median
evaluations per increment on a branch, with earlier states reused and with every state solved. The error is that of
F_bar before the first slip, relative to its largest value, against a run at tolerance 1e-12 with a tenth of the step.
The last columns give gfmd's time over that of fast. gfmd runs once, at the same tolerance, up to its third slip; its
later periods are assumed to cost as much as the last one. --quick leaves out gfmd, the error and the larger sizes;
--scenes takes the first N presets and sizes only.
"""

import argparse
import json
import platform
import resource
import statistics
import time
from math import inf

import numpy as np

from solver import Scene, load_path
from solver.continuation.anderson import Secants
from solver.continuation.corrector import MEMORY
from solver.mechanics.contact import Contact, patch
from solver.mechanics.equilibrium import Equilibrium
from solver.mechanics.layer import Convolution, Transform
from solver.presets import preset
from solver.run.load_steps import vertical

PRESETS = {
    "Fig. 6": preset("fig6").scene,
    "case I": preset("fig7-case1").scene,
    "case II": preset("fig7-case2").scene,
    "case III": preset("fig7-case3").scene,
    "deep compression": Scene(delta_bar=1.0),
    "stiff": Scene(E=1000.0),
    "soft": Scene(E=10.0),
    "low friction": Scene(phi_ratio=0.05),
    "high friction": Scene(phi_ratio=2.0),
}
SLIPS = 3  # that gfmd has to compute
RUNS = 5
SIZES = (512, 1024, 2048, 4096, 8192, 16384)


def timed(scene, method="fast", replay=True, runs=RUNS):
    """(frames, median seconds) of whole runs."""
    seconds = []
    for _ in range(runs):
        start = time.perf_counter()
        frames = list(load_path(scene, method, replay))
        seconds.append(time.perf_counter() - start)
        if sum(seconds) > 20.0:
            break
    return frames, statistics.median(seconds)


def shear(frames):
    return [f for f in frames if f.stage == "shear"]


def evaluations(frames):
    return sum(f.evaluations for f in frames)


def force_error(scene, frames, reference):
    """Largest deviation of F_bar before the first slip, relative to its largest value; reference: ten frames to one."""
    pairs = list(zip(shear(frames), shear(reference)[::10], strict=False))
    before = next((i for i, (f, _) in enumerate(pairs) if f.slip), len(pairs))
    force = np.array([(f.F_bar, g.F_bar) for f, g in pairs[:before]])
    return float(np.abs(force[:, 0] - force[:, 1]).max() / np.abs(force[:, 1]).max())


def measured(name, scene, quick):
    """One row of the table."""
    reused, t_reused = timed(scene)
    solved, t_solved = timed(scene, replay=False)
    branch = [f.evaluations for f in shear(solved) if not f.slip]
    row = {
        "preset": name,
        "reused": {"evaluations": evaluations(reused), "seconds": t_reused},
        "solved": {"evaluations": evaluations(solved), "seconds": t_solved},
        "median_per_increment": {
            "reused": statistics.median(f.evaluations for f in shear(reused) if not f.slip),
            "solved": statistics.median(branch),
        },
        "slips": sum(len(f.slips) for f in shear(solved)),
    }
    if not quick:
        row |= against_gfmd(scene, solved, row)
    return row


def against_gfmd(scene, solved, row):
    """Errors of both methods and the ratios of their times over the first slips."""
    slips = [f.U_x for f in shear(solved) if f.slip]
    short = scene.changed(u_x_max=slips[min(SLIPS, len(slips)) - 1] + 0.5 if slips else scene.u_x_max)
    reference, _ = timed(short.changed(tolerance=max(1e-12, 2.0 * short.attainable), du_x=0.1 * scene.du_x), runs=1)
    gfmd, t_gfmd = timed(short, "gfmd", runs=1)
    part, t_part = timed(short, replay=False, runs=3)
    share = short.shear_increments / scene.shear_increments
    steady = t_gfmd * steady_share(gfmd, scene, short)
    return {
        "error": {"fast": force_error(scene, part, reference), "gfmd": force_error(scene, gfmd, reference)},
        "gfmd": {"evaluations": evaluations(gfmd), "seconds": t_gfmd, "u_x_max": short.u_x_max, "share": share},
        "ratio": {"solved": t_gfmd / t_part, "reused": steady / row["reused"]["seconds"]},
    }


def steady_share(gfmd, scene, short):
    """How many times the whole experiment costs gfmd the part it ran: sliding goes on as in the last period."""
    part = evaluations(gfmd)
    slips = [i for i, f in enumerate(gfmd) if f.stage == "shear" and f.slip]
    if len(slips) < 2:
        return 1.0
    period = evaluations(gfmd[slips[-2] : slips[-1]]) / (slips[-1] - slips[-2])
    return 1.0 + period * (scene.shear_increments - short.shear_increments) / part


def size(nodes):
    """Cost against nodes at fixed node spacing, R/w and h/w: one row."""
    scene = Scene(nodes=nodes, width=nodes * Scene().spacing, u_x_max=12.0)
    frames, seconds = timed(scene, runs=3)
    return {
        "nodes": nodes,
        "patch": frames[-1].u.shape[1],
        "ms_per_increment": 1e3 * seconds / len(frames),
        "evaluations_per_increment": evaluations(frames) / len(frames),
    }


def flat():
    """Flat on flat: seconds per 1000 increments."""
    scene = Scene(surface="flat", phi_ratio=0.1, u_x_max=100.0, damping=inf)
    frames, seconds = timed(scene)
    return {"increments": len(frames), "seconds": seconds, "per_1000": 1e3 * seconds / len(frames)}


def parts(row):
    """Microseconds of the parts of a force evaluation and of a secant step, on the default patch."""
    scene = Scene()
    contact = Contact(scene, *patch(scene))
    problem = Equilibrium(contact, vertical(1.0))
    v = np.random.default_rng(0).normal(size=problem.size)
    r = np.empty_like(v)
    layer = Convolution(contact.modes, contact.size)
    secants = Secants(MEMORY, v.size)
    for _ in range(MEMORY):
        secants.push(*np.random.default_rng(1).normal(size=(4, v.size)))
    fft = Transform(contact.nodes)
    micro = {
        "two transforms": lambda: (fft.forward(), fft.backward()),
        "layer (transforms and product)": layer.apply,
        "force evaluation": lambda: problem.residual(v, 0.0, r),
        "secant step without it": lambda: secants.push(*[secants.move(r)] * 4),
    }
    found = {}
    for name, call in micro.items():
        best = min(_clock(call) for _ in range(7))
        found[name] = 1e6 * best
    share = row["reused"]["evaluations"] * found["two transforms"] * 1e-6
    found["run over its transforms"] = row["reused"]["seconds"] / share
    return found


def _clock(call, times=500):
    start = time.perf_counter()
    for _ in range(times):
        call()
    return (time.perf_counter() - start) / times


def shown(row):
    """A row as text."""
    a, b = row["reused"], row["solved"]
    text = f"{row['preset']:18}{row['slips']:4}"
    for part, median in ((a, row["median_per_increment"]["reused"]), (b, row["median_per_increment"]["solved"])):
        micro = 1e6 * part["seconds"] / part["evaluations"]
        text += f"{part['evaluations']:9}{part['seconds']:8.3f}{micro:6.1f}{median:5g}"
    if "ratio" in row:
        error, ratio = row["error"], row["ratio"]
        text += f"{error['fast']:10.1e}{error['gfmd']:9.1e}{ratio['reused']:8.0f}{ratio['solved']:7.0f}"
    return text


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", metavar="FILE")
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--scenes", type=int, default=len(PRESETS), metavar="N")
    arguments = parser.parse_args()
    for method in ("fast", "gfmd"):
        list(load_path(Scene(nodes=128, width=312.5, radius=20.0, u_x_max=16.0, tolerance=1e-6), method))
    head = f"{'':18}{'':4}{'known states reused':>28}{'everything solved':>28}{'error of F':>19}{'gfmd takes x':>15}"
    print(head)
    print(
        f"{'preset':18}{'slip':>4}"
        + f"{'eval':>9}{'s':>8}{'us':>6}{'med':>5}" * 2
        + f"{'fast':>10}{'gfmd':>9}{'reused':>8}{'solved':>7}"
    )
    rows = []
    for name, scene in list(PRESETS.items())[: arguments.scenes]:
        rows.append(measured(name, scene, arguments.quick))
        print(shown(rows[-1]), flush=True)
    report = {"machine": platform.machine(), "python": platform.python_version(), "presets": rows, "flat": flat()}
    if not arguments.quick:
        ratios = [[row["ratio"][kind] for row in rows] for kind in ("reused", "solved")]
        report["median_ratio"] = {"reused": statistics.median(ratios[0]), "solved": statistics.median(ratios[1])}
        print("median: gfmd takes {reused:.0f} x (reused), {solved:.0f} x (solved)".format(**report["median_ratio"]))
    report["parts"] = parts(rows[0])
    for name, value in report["parts"].items():
        print(f"{name}: {value:.1f}" + (" x" if " over " in name else " us"))
    default = rows[0]["reused"]["seconds"]
    for row in rows[4:6]:
        print(f"{row['preset']} against Fig. 6: {row['reused']['seconds'] / default:.2f} x")
    print(f"flat on flat: {1e3 * report['flat']['per_1000']:.1f} ms per 1000 increments")
    report["sizes"] = [size(nodes) for nodes in (SIZES[:3] if arguments.quick else SIZES)[: max(2, arguments.scenes)]]
    for row in report["sizes"]:
        line = (
            "nodes {nodes:6}  patch {patch:5}: {ms_per_increment:7.3f} ms, {evaluations_per_increment:5.1f} evaluations"
        )
        print((line + " per increment").format(**row))
    first, last = report["sizes"][0], report["sizes"][-1]
    growth = np.log(last["ms_per_increment"] / first["ms_per_increment"]) / np.log(last["nodes"] / first["nodes"])
    report["growth"] = float(growth)
    report["memory_MB"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(f"cost per increment grows as nodes^{growth:.2f}; peak memory {report['memory_MB']:.0f} MB")
    if arguments.json:
        with open(arguments.json, "w", encoding="utf-8") as out:
            json.dump(report, out, indent=2)


if __name__ == "__main__":
    main()
