"""Measure what the project claims, and write docs/evidence.md: `python docs/evidence.py NAME ...`, or `--all`.

Each entry of COMMANDS is one command of the repository. Its standard output is kept in docs/evidence.json with the
commit, date and processor, and shown on the page; no number is typed in. Benches print single scenes to standard error.
Entries older than the last change of the solver's numerics are stale; `--stale` lists them and how long they take.

`--all` measures all entries at the present commit, within two hours on two cores: two at a time, the longest first, and
then one by one those that measure time or have two processes. Each is kept as soon as it is measured, so that a run
that was stopped goes on where it was; one that failed is named and measured by the next run.
"""

import argparse
import json
import platform
import subprocess
import sys
from collections import Counter
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from datetime import date
from functools import partial
from pathlib import Path
from threading import Lock
from time import perf_counter
from typing import Any, NamedTuple

from solver.continuation import NUMERICS

HERE = Path(__file__).parent
ROOT, STORE, PAGE = HERE.parent, HERE / "evidence.json", HERE / "evidence.md"
# files that entries write
WRITTEN = {"docs/evidence.json", "docs/evidence.md", "docs/accuracy.png", "app/features/accuracy/accuracy.json"}


class Entry(NamedTuple):
    """A heading, what the figures show, and the arguments of Python that measure them.

    alone: whether nothing else may run beside it, as for all of the chapters TIMED.
    """

    chapter: str
    title: str
    meaning: str
    command: tuple[str, ...]
    alone: bool = False


TIMED = {"Performance", "Load"}
KEEPING = Lock()  # while an entry is written


BENCH = "tests/bench/"
COMMANDS = {
    "curves": Entry(
        "Accuracy",
        "Error against run time",
        "The default scene by four methods: error of F, L and A before the first slip, and branches after slips.",
        (BENCH + "curves.py", "--picture", "docs/accuracy.png", "--page"),
        alone=True,
    ),
    "landings": Entry(
        "Accuracy",
        "Where first slips land",
        "First slips of random rough, wavy, flat and measured cells against an explicit GFMD without shared code."
        " A slip counts where this GFMD agrees with itself at a third of its time step.",
        (BENCH + "landings.py",),
    ),
    "soft": Entry(
        "Accuracy",
        "Soft punches after many slips",
        "F at 40 nm of 20 random soft punches with strong friction, by long and short increments and by explicit GFMD.",
        (BENCH + "landings.py", "--soft"),
    ),
    "others": Entry(
        "Accuracy",
        "Extreme scenes",
        "160 rough, wavy, thick, thin and nearly incompressible scenes, held loads and other damping, against an"
        " explicit GFMD without shared code.",
        (BENCH + "others.py",),
    ),
    "sensitivities": Entry(
        "Accuracy",
        "Derivatives",
        "Derivatives of slips against central differences, and their cost over that of the run.",
        (BENCH + "sensitivities.py",),
    ),
    "held": Entry(
        "Accuracy",
        "Derivatives under a held load",
        "Derivatives of slips at held loads, in tension too, against exact runs.",
        (BENCH + "sensitivities.py", "--held"),
    ),
    "skeletons": Entry(
        "Accuracy",
        "Skeletons",
        "Skeletons of random scenes against their runs: right, refused, or wrong.",
        (BENCH + "skeletons.py",),
    ),
    "fit": Entry(
        "Accuracy",
        "Fits",
        "Fits to data with known parameters: convergence, coverage of the 95 % intervals, sparse data.",
        (BENCH + "fit.py",),
        alone=True,  # it names seconds
    ),
    "map": Entry(
        "Accuracy",
        "Maps",
        "A map of first slips against exact runs at 60 of its points.",
        (BENCH + "map.py",),
    ),
    "boundary": Entry(
        "Accuracy",
        "Where stick-slip ends",
        "Boundaries of 24 scenes against bisection by whole runs, and runs at 0.997 and 1.003 of each.",
        (BENCH + "boundary.py",),
    ),
    "mixed": Entry(
        "Accuracy",
        "Adhesion with shear against fracture mechanics",
        "Contact width, its shift, J and Gamma of a bonded strip under load and shear, without a free parameter.",
        ("tests/validation/mixed_mode.py",),
    ),
    "mutations": Entry(
        "Accuracy",
        "What this comparison notices",
        "The same with one parameter changed, in the theory or in the run: is the error larger than allowed?",
        ("tests/validation/mixed_mode.py", "--mutations"),
    ),
    "stability": Entry(
        "Robustness",
        "Stiff and extreme scenes",
        "Every eleventh of 2,000 scenes with extreme parameters, rechecked in long double and by dense spectra; closed"
        " forms; round-off of each formula.",
        ("tests/validation/stability.py", "--quick"),
        alone=True,
    ),
    "jumps": Entry(
        "Robustness",
        "Jumps without an event",
        "Frames that moved by more than delta_n without an event, in random scenes with held loads and flats.",
        (BENCH + "jumps.py",),
    ),
    "onset": Entry(
        "Robustness",
        "Onset of stick-slip",
        "U_s and the number of slips near the onset for three increments du_x.",
        (BENCH + "onset.py",),
    ),
    "rests": Entry(
        "Robustness",
        "Frames at rest",
        "Random scenes of the whole range of every parameter: does the fastest mode of every frame decay?",
        (BENCH + "rests.py", "--scenes", "400", "--seed", "1"),
        alone=True,
    ),
    "damping": Entry(
        "Robustness",
        "Estimate of the safe damping",
        "Change of the safe damping of 36 states with other constants of the estimate.",
        (BENCH + "damping.py",),
    ),
    "bench": Entry(
        "Performance",
        "Force evaluations of the presets",
        "Counts differ by 1 to 3 % between processors; times are those of this machine.",
        (BENCH + "bench.py", "--quick"),
    ),
    "start": Entry(
        "Performance",
        "Compiled functions",
        "Processor time of a process that imports the solver and runs a small scene: cold, with nothing compiled, as"
        " after an installation, and warm.",
        (BENCH + "start.py",),
    ),
    "box": Entry(
        "Performance",
        "The slider box",
        "120 scenes over the range of the three sliders: time over that of the default, and slips located.",
        (BENCH + "box.py", "--jobs", "1", "--limit", "60"),
    ),
    "follow": Entry(
        "Performance",
        "Following a slider",
        "Moves of the sliders over their range: share followed, errors, force evaluations, time over that of the run,"
        " and kilobytes on the wire.",
        (BENCH + "follow.py",),
    ),
    "certify": Entry(
        "Performance",
        "Certificates",
        "Certificates of random moves against their exact runs: false ones, needless alarms, time over that of the"
        " exact run; and of predictions made wrong on purpose.",
        (BENCH + "certify.py",),
    ),
    "unstable": Entry(
        "Performance",
        "Unstable branches",
        "Unstable branches of random punches against their mirror images, and processor time over that of the run.",
        (BENCH + "unstable.py",),
    ),
    "slider_step": Entry(
        "Load",
        "A slider step on the server",
        "Functions of the app that one step of a held slider calls, from the order to the prediction that is sent.",
        (BENCH + "slider_step.py",),
    ),
    "drag": Entry(
        "Load",
        "A drag in a browser",
        "Pictures over values of the slider, and the age of a picture when it is drawn.",
        (BENCH + "latency.py", "--drag", "--moves", "40"),
    ),
    "visit": Entry(
        "Load",
        "A first visit",
        "Largest contentful paint, first picture, and bytes, by pages and websocket.",
        (BENCH + "visit.py",),
    ),
    "lab": Entry(
        "Load",
        "The research pages",
        "Time until a page is open, the server's processor time, and the age of another visitor's pictures in a drag.",
        (BENCH + "lab.py",),
    ),
    "classroom": Entry(
        "Load",
        "A class of 30",
        "Visitors who think for 2 to 5 s, then choose a preset or drag a slider; server and workers share their cores.",
        ("tests/load/classroom.py", "--drag", "--visitors", "30", "--seconds", "45"),
    ),
    "hostile": Entry(
        "Load",
        "Strangers",
        "10,000 random and mutated messages of five clients, and addresses that are not listed, beside three visitors.",
        ("tests/load/hostile.py", "--messages", "10000"),
    ),
}


def measured(entry: Entry) -> dict[str, Any]:
    """Runs the command: its output with commit, date, processor and minutes; raises CalledProcessError."""
    begun, made = perf_counter(), output(sys.executable, *entry.command)
    took = {"numerics": NUMERICS, "minutes": round((perf_counter() - begun) / 60.0, 1)}
    return {"command": line(entry), **origin(), **took, "output": made}


def line(entry: Entry) -> str:
    """The command as one types it."""
    return " ".join(["python", *entry.command])


def left(store: dict[str, Any], commit: str) -> list[str]:
    """The entries that were not measured at that commit, by their present commands."""
    known = {name: (result["commit"], result["command"]) for name, result in store.items()}
    return [name for name, entry in COMMANDS.items() if known.get(name) != (commit, line(entry))]


def stale(name: str, store: dict[str, Any]) -> bool:
    """Whether an entry was not measured since the last change of the solver's numerics."""
    return store.get(name, {}).get("numerics", 0) < NUMERICS


def minutes(names: Iterable[str], store: dict[str, Any]) -> str:
    """How long these entries take, as far as it is known."""
    known = [store[name]["minutes"] for name in names if "minutes" in store.get(name, {})]
    return f"{sum(known):.0f} minutes for {len(known)} of {len([*names])} entries, the last time"


def origin() -> dict[str, str]:
    """The commit, the date and the processor of a measurement."""
    commit = output("git", "rev-parse", "--short", "HEAD")
    return {"commit": commit, "date": date.today().isoformat(), "processor": processor()}


def changed() -> list[str]:
    """Files that differ from those of the commit, but for what entries write."""
    lines = output("git", "status", "--porcelain", "--untracked-files=no").splitlines()
    return sorted({each.split(maxsplit=1)[1] for each in lines} - WRITTEN)


def output(*command: str) -> str:
    """What a command prints, run in the repository's root."""
    return subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, text=True, check=True).stdout.strip("\n")


def processor() -> str:
    """The model of the processor, with the number of its cores that are available."""
    info = Path("/proc/cpuinfo")
    lines = info.read_text().splitlines() if info.exists() else []
    models = [line.split(":")[1].strip() for line in lines if line.startswith("model name")]
    return f"{models[0] if models else platform.processor()}, {len(models) or '?'} cores"


def page(store: dict[str, dict[str, Any]]) -> str:
    """The page, a section per entry of COMMANDS."""
    picture = "![Error of F, L and A against run time and force evaluations, for four methods](accuracy.png)"
    places = Counter(place(store[name]) for name in COMMANDS if name in store)
    ((usual, _),) = places.most_common(1) or [("nothing yet", 0)]
    parts = [
        "# Evidence",
        "This page is written by `python docs/evidence.py`. Edit the command, not the page.",
        f"Measured: {usual}, unless an entry names another commit.",
        picture,
    ]
    chapter = ""
    for name, entry in COMMANDS.items():
        if entry.chapter != chapter:
            chapter = entry.chapter
            parts.append(f"## {chapter}")
        shown = section(store.get(name), entry, stale(name, store), usual)
        parts += [f"### {entry.title}", entry.meaning, *shown]
    return "\n\n".join(parts) + "\n"


def place(result: dict[str, Any]) -> str:
    """The commit and the processor of a result."""
    return f"commit {result['commit']}, {result['processor']}"


def section(result: dict[str, Any] | None, entry: Entry, old: bool, usual: str) -> list[str]:
    """Paragraphs that show one result, or the command where there is none."""
    if result is None:
        return [f"Not measured yet: `{line(entry)}`."]
    where = f"`{result['command']}`, {result['date']}"
    where += f", {place(result)}" * (place(result) != usual)
    where += " (before the last change of the solver's numerics):" if old else ":"
    return [where, "\n".join(["```text", result["output"], "```"])]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"what to measure: {', '.join(COMMANDS)}")
    parser.add_argument("--all", action="store_true", help="measure all that this commit lacks")
    parser.add_argument("--stale", action="store_true", help="list what is older than the solver's numerics")
    parser.add_argument("--page", action="store_true", help="only write the page")
    arguments = parser.parse_args()
    unknown = set(arguments.names) - {*COMMANDS}
    if unknown or not (arguments.names or arguments.page or arguments.all or arguments.stale):
        parser.error(f"unknown: {', '.join(unknown) or 'nothing'}; allowed: --all, {', '.join(COMMANDS)}")
    store = json.loads(STORE.read_text()) if STORE.exists() else {}
    if arguments.stale:
        old = [name for name in COMMANDS if stale(name, store)]
        return print("\n".join([*old, minutes(old, store)]))
    if arguments.all and (edited := changed()):
        parser.error(f"--all measures a commit, and {', '.join(edited)} differ from it; commit them first")
    chosen = left(store, origin()["commit"]) if arguments.all else arguments.names
    print(minutes(chosen, store), flush=True)
    failed = [name for name, well in measure(chosen, store).items() if not well]
    PAGE.write_text(page(store), encoding="utf-8")
    print(f"wrote {PAGE.relative_to(ROOT)}")
    if failed:
        sys.exit(f"failed: {', '.join(failed)}; the page shows their last results")


def measure(names: Iterable[str], store: dict[str, Any]) -> dict[str, bool]:
    """Measure these entries, two at a time but for those alone; by name, whether its command ended well."""
    alone = {name: COMMANDS[name].alone or COMMANDS[name].chapter in TIMED for name in names}
    paired = [name for name in alone if not alone[name]]
    paired.sort(key=lambda name: store.get(name, {}).get("minutes", 0.0), reverse=True)
    with ThreadPoolExecutor(2) as pool:
        ended = dict(zip(paired, pool.map(partial(kept, store=store), paired), strict=True))
    return ended | {name: kept(name, store) for name in alone if alone[name]}


def kept(name: str, store: dict[str, Any]) -> bool:
    """Measure an entry and write it to the store; whether its command ended well."""
    print(f"{name}: {line(COMMANDS[name])}", flush=True)
    try:
        found = measured(COMMANDS[name])
    except subprocess.CalledProcessError as failure:
        print(failure, file=sys.stderr)
        return False
    with KEEPING:
        store[name] = found
        STORE.write_text(json.dumps(store, indent=1) + "\n")
    return True


if __name__ == "__main__":
    main()
