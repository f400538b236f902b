"""Cost and errors over the slider box: 120 scenes over the ranges of the app's sliders, defaults else.

    python tests/bench/box.py [--json FILE] [--gfmd [plain]] [--cache FILE] [--limit SECONDS] [--jobs N] [--every N]
                               [--extreme]

Columns: processor time of a whole run over that of the default scene (the median; the default is timed before every
scene), force evaluations, slips, and how many of them are located. A scene that exceeds the limit or fails prints why.

--extreme takes 30 scenes outside the sliders: layers below 1 GPa, and phi_n of 10 to 20 on soft layers.

--gfmd compares F_bar, L_bar and A_bar with the paper's GFMD, at the last increment at which both rest, relative to
their largest values in the run. GFMD is the solver's method gfmd or, with `plain`, the independent one in
tests/shared/plain_gfmd.py. It also prints the ratio of GFMD's time to that of fast over the same increments at the same
tolerance (du_x = du_z = 0.5, tolerance 1e-5), in units of a fixed numpy job, so that times may be cached.
--cache keeps GFMD's results in a file; --only-gfmd fills it and does nothing else. Where the plain GFMD flutters for
ever, its next increment starts from there, and the row gives the number of such increments. Where fast differs, the
plain GFMD runs again with half the time step and with du_x = 0.1: if it differs from itself, the scene is unsure.
"""

import argparse
import itertools
import json
import signal
import statistics
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import numpy as np

from solver import NotConverged, Scene, load_path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "shared"))
import plain_gfmd
from scenes import extremes

BOX = {
    "E": (10.0, 14.0, 20.0, 50.0, 200.0, 1000.0),
    "delta_bar": (-0.6, -0.15, 0.2, 0.6, 1.0),
    "phi_ratio": (0.02, 0.3, 1.0, 2.0),
}
SCENES = [dict(zip(BOX, values, strict=True)) for values in itertools.product(*BOX.values())]
EQUAL = {"du_x": 0.5, "du_z": 0.5, "tolerance": 1e-5}  # of runs compared with GFMD in time
JUDGES = {"plain": {}, "plain, half step": {}, "plain, du_x 0.1": {"du_x": 0.1}}  # asked where fast differs
WRONG = 1e-4  # relative error of a force or area
BRIEF = 0.3  # s: shorter runs are timed three times
GFMD_LIMIT = 600.0  # s


class OutOfTime(BaseException):
    """Raised by the alarm; no Exception, lest the solver take it for a failure of its own."""


def ran(scene, limit, method="fast"):
    """A run in numbers, with `failure` where it did not end; raises nothing."""
    if method in JUDGES:
        frames = plain_gfmd.run(scene, fraction=0.25 if "half" in method else 0.5, restless=True)
    else:
        frames = load_path(scene, method)
    row = {"evaluations": 0, "slips": 0, "located": 0, "restless": 0, "failure": None, "largest": [0.0, 0.0, 0.0]}
    row["at"] = {}  # F_bar, L_bar and A_bar at rest, by U_x
    signal.signal(signal.SIGPROF, _out_of_time)
    signal.setitimer(signal.ITIMER_PROF, limit)
    start = time.process_time()
    try:
        for frame in frames:
            row["evaluations"] += frame.evaluations
            row["restless"] += bool(frame.residual > scene.tolerance)
            events = getattr(frame, "slips", ())
            row["slips"] += len(events)
            row["located"] += sum(bool(getattr(event, "located", True)) for event in events)
            final = [float(value) for value in (frame.F_bar, frame.L_bar, frame.A_bar)]
            row["largest"] = [max(a, abs(b)) for a, b in zip(row["largest"], final, strict=True)]
            load = round(frame.load if method in JUDGES else frame.U_x, 6)
            if frame.stage == "shear" and frame.residual <= scene.tolerance and load % EQUAL["du_x"] == 0.0:
                row["at"][load] = final
            row["reached"] = f"{frame.stage} {frame.index}"
    except OutOfTime:
        row["failure"] = f"not done in {limit:g} s"
    except (NotConverged, plain_gfmd.NoRest) as failure:
        row["failure"] = str(failure)
    except Exception as failure:  # a crash, which is what this looks for as well
        row["failure"] = f"{type(failure).__name__}: {failure}"
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
    row["seconds"] = time.process_time() - start
    return row


def _out_of_time(*_):
    raise OutOfTime


def timed(scene, limit):
    """As `ran`, brief runs three times over, with the median time."""
    row = ran(scene, limit)
    if row["seconds"] < BRIEF and not row["failure"]:
        row["seconds"] = statistics.median([row["seconds"], *(ran(scene, limit)["seconds"] for _ in range(2))])
    return row


def yard():
    """Seconds of a fixed job, by which times on another day can be compared."""
    field, best = np.linspace(0.0, 1.0, 2048).reshape(2, 1024), np.inf
    for _ in range(20):
        start = time.process_time()
        for _ in range(20):
            np.fft.irfft(np.fft.rfft(np.exp(-field)))
        took = time.process_time() - start
        best = min(best, took) if took > 0 else best  # the clock of a busy virtual machine may stand still
    return best


def measured(values, limit, method, known):
    """All about one scene; method: GFMD's name or None; known: its rows of earlier runs by name, new ones are added."""
    scene = Scene(**values)
    row = {"scene": values, "default": ran(Scene(), limit)["seconds"], "yard": yard(), "fast": timed(scene, limit)}
    if not method:
        return row
    row["equal"], row["known"] = timed(scene.changed(**EQUAL), limit), known
    gfmd = row["gfmd"] = by_gfmd(values, method, known)
    if any(run["failure"] for run in (row["fast"], row["equal"], gfmd)):
        return row
    row["error"], row["error_equal"] = error(row["fast"], gfmd), error(row["equal"], gfmd)
    row["ratio"] = gfmd["seconds"] / gfmd["yard"] / (row["equal"]["seconds"] / row["yard"])
    row["ratio_evaluations"] = gfmd["evaluations"] / max(1, row["equal"]["evaluations"])
    if max(row["error"]) > WRONG:
        judges = {name: by_gfmd(values, name, known) for name in JUDGES if name != method}
        row["judges"] = {name: judge["failure"] or max(error(judge, gfmd)) for name, judge in judges.items()}
    return row


def by_gfmd(values, method, known):
    """GFMD's row, from `known` if it is there; method: "gfmd" or one of JUDGES."""
    if method not in known:
        scene = Scene(**values, **(EQUAL | JUDGES.get(method, {})))
        known[method] = ran(scene, GFMD_LIMIT, method) | {"yard": yard()}
    return known[method]


def error(run, gfmd):
    """Errors of F_bar, L_bar and A_bar at the last increment at which both rest, relative to GFMD's largest."""
    scale = np.maximum(gfmd["largest"], [1e-12, 1e-12, 1e-4])
    mine, theirs = ({float(load): values for load, values in found["at"].items()} for found in (run, gfmd))
    last = max(mine.keys() & theirs.keys())
    return (np.abs(np.subtract(mine[last], theirs[last])) / scale).tolist()


def verdict(row):
    """ "right", "wrong", or "unsure" where GFMD differs from itself; None without a comparison."""
    if "error" not in row:
        return None
    if max(row["error"]) <= WRONG:
        return "right"
    unsure = any(isinstance(judge, str) or judge > WRONG for judge in row["judges"].values())
    return "unsure" if unsure else "wrong"


def shown(row, default):
    """A row as text."""
    fast = row["fast"]
    text = "E {E:5g}  delta_bar {delta_bar:5g}  ratio {phi_ratio:4g}".format(**row["scene"])
    text += "  phi_n {phi_n:g}".format(**row["scene"]) if "phi_n" in row["scene"] else ""
    text += f"{fast['seconds'] / default:9.2f}{fast['evaluations']:9}{fast['slips']:6}{fast['located']:6}"
    if "error" in row:
        text += "".join(f"{value:9.1e}" for value in row["error"]) + f"{row['ratio']:8.0f}"
        text += f"{row['ratio_evaluations']:8.0f}" + ("" if verdict(row) == "right" else f"  {verdict(row).upper()}")
        text += f"  GFMD never rests in {row['gfmd']['restless']}" if row["gfmd"].get("restless") else ""
    elif "gfmd" in row and row["gfmd"]["failure"]:
        text += f"  GFMD: {row['gfmd']['failure']}"
    return text + (f"  {fast['failure']} ({fast.get('reached')})" if fast["failure"] else "")


def summary(rows):
    """The figures of the whole box."""
    default = statistics.median(row["default"] for row in rows)
    cost = [row["fast"]["seconds"] / default for row in rows]
    found = {
        "default_seconds": default,
        "median": statistics.median(cost),
        "worst": max(cost),
        "worst_scene": rows[int(np.argmax(cost))]["scene"],
        "evaluations_median": statistics.median(row["fast"]["evaluations"] for row in rows),
        "evaluations_worst": max(row["fast"]["evaluations"] for row in rows),
        "slips": sum(row["fast"]["slips"] for row in rows),
        "located": sum(row["fast"]["located"] for row in rows),
        "failures": [(row["scene"], row["fast"]["failure"]) for row in rows if row["fast"]["failure"]],
    }
    both = [row for row in rows if "error" in row]
    if both:
        found |= {
            "compared": len(both),
            "wrong": [(row["scene"], max(row["error"])) for row in both if verdict(row) == "wrong"],
            "unsure": [(row["scene"], max(row["error"]), row["judges"]) for row in both if verdict(row) == "unsure"],
            "wrong_equal": sum(max(row["error_equal"]) > WRONG for row in both),
            "restless": [(row["scene"], row["gfmd"]["restless"]) for row in both if row["gfmd"].get("restless")],
        }
        for name in ("ratio", "ratio_evaluations"):
            ratios = [row[name] for row in both]
            found[name] = {"median": statistics.median(ratios), "least": min(ratios)}
    return found


def report(found, scenes):
    print("default {default_seconds:.3f} s; box over default: median {median:.2f}, worst {worst:.2f}".format(**found))
    print("  the worst is {worst_scene}".format(**found))
    print("evaluations: median {evaluations_median:g}, worst {evaluations_worst}".format(**found))
    print(f"slips: {found['slips']}, {found['located']} located")
    print(f"not done: {len(found['failures'])} of {scenes}")
    for scene, failure in found["failures"]:
        print(f"  {scene}: {failure}", file=sys.stderr)
    if "wrong" in found:
        wrong, share = len(found["wrong"]), f"{found['compared']} compared with GFMD"
        print(f"wrong: {wrong} of {share}; over the same increments: {found['wrong_equal']}")
        for scene, worst in found["wrong"]:
            print(f"  {scene}: {worst:.1e}", file=sys.stderr)
        print(f"unsure, as GFMD differs from itself: {len(found['unsure'])}")
        for scene, worst, judges in found["unsure"]:
            print(f"  {scene}: {worst:.1e}, GFMD {judges}", file=sys.stderr)
        for scene, increments in found["restless"]:
            print(f"GFMD itself never rests in {increments} increments of {scene}")
        for name, what in (("ratio", "time"), ("ratio_evaluations", "evaluations")):
            print("GFMD takes {median:.0f} x (median), {least:.1f} x (least) the".format(**found[name]), what)


def _job(arguments):
    return measured(*arguments)


def _warm():
    """Compiled and planned, before anything is timed."""
    for method in ("fast", "gfmd"):
        list(load_path(Scene(u_x_max=0.5, du_z=1.0, tolerance=1e-3), method))
    ran(Scene(), 60.0)


def rows_of(jobs, tasks):
    """The rows of all tasks, in order, as they are done; jobs: processes."""
    if jobs == 1:
        _warm()
        yield from map(_job, tasks)
        return
    with ProcessPoolExecutor(jobs, mp_context=get_context("spawn"), initializer=_warm) as pool:
        yield from pool.map(_job, tasks)


def read(path):
    return json.loads(Path(path).read_text(encoding="utf-8")) if path and Path(path).exists() else {}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", metavar="FILE")
    parser.add_argument("--gfmd", nargs="?", const="gfmd", choices=("gfmd", "plain"))
    parser.add_argument("--cache", metavar="FILE", help="of GFMD's results; read, and written after every scene")
    parser.add_argument("--limit", metavar="SECONDS", type=float, default=60.0, help="of processor time, each scene")
    parser.add_argument("--jobs", type=int, choices=(1, 2), default=1)
    parser.add_argument("--every", metavar="N", type=int, default=1, help="only every N-th scene")
    parser.add_argument("--only-gfmd", action="store_true", help="with --gfmd and --cache: fill the cache")
    parser.add_argument("--extreme", action="store_true", help="scenes outside the sliders")
    arguments = parser.parse_args()
    scenes = (list(extremes(30)) if arguments.extreme else SCENES)[:: arguments.every]
    cache, method = read(arguments.cache), arguments.gfmd
    known = [cache.setdefault(json.dumps(values), {}) for values in scenes]

    def keep():
        if arguments.cache:
            Path(arguments.cache).write_text(json.dumps(cache), encoding="utf-8")

    if arguments.only_gfmd:
        for values, rows in zip(scenes, known, strict=True):
            by_gfmd(values, method, rows)
            keep()
        return
    tasks = [(values, arguments.limit, method, rows) for values, rows in zip(scenes, known, strict=True)]
    gfmd = f"{'F':>9}{'L':>9}{'A':>9}{'time':>8}{'eval':>8}" if method else ""
    print(f"{'':36}{'default=1':>9}{'eval':>9}{'slips':>6}{'loc.':>6}{gfmd}", file=sys.stderr)
    rows = []
    for row in rows_of(arguments.jobs, tasks):
        cache[json.dumps(row["scene"])] |= row.pop("known", {})
        rows.append(row)
        keep()
        print(shown(row, statistics.median(row["default"] for row in rows)), file=sys.stderr, flush=True)
    found = summary(rows)
    report(found, len(scenes))
    if arguments.json:
        Path(arguments.json).write_text(json.dumps({"summary": found, "rows": rows}, indent=2), encoding="utf-8")


if __name__ == "__main__":
    main()
