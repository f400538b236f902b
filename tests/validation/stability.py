"""Is the solver right on stiff and extreme scenes? One command answers, with the figures behind it.

    python tests/validation/stability.py [--quick] [--scenes N ...] [--limit SECONDS] [--jobs N]

Computes 2,000 scenes and more (`atlas`; --quick: every 11th), an approach and a short shear each. Sums over springs and
modes in long double and all growth rates of the disturbances check a sample of their frames (`recheck`, `spectrum`).
Then come problems with published solutions (`closed_forms`) and the round-off of each formula (`conditioning`).
`extended` has the springs and the layer of these checks, without a line of `solver.mechanics`.
The exit code is 1 if anything is wrong.
"""

import argparse
import sys
from collections.abc import Iterable, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from pandas import DataFrame

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "shared"))  # of helpers

from atlas import CENTRE, cases
from closed_forms import closed_forms
from conditioning import conditioning
from verdicts import BAD, GOOD, LIMIT, atlas

FRAMES = "unstable", "cautioned", "spectra"  # numbers of `verdicts.stable`
# part of the message of a scene that gave up: its cause. The first one that fits counts
CAUSES = {
    "where the approach begins": "the layer is too soft to begin",
    "s of processor time": "out of time",
    "still moving": "still moving after the most steps",
    "flutters": "flutters for ever",
    "moves on while the load rises": "does not rest while the load rises",
    "diverges": "the motion diverges",
    "more than 100 slips": "too many slips in one increment",
    "": "no equilibrium in reach of the tolerance",
}
ROUND_OFF = "Conditioning: relative error attained, and by the printed formula in float64 (nan: it overflows)"


def counted(results: Iterable[Mapping[str, Any]]) -> dict[str, int]:
    """Scenes per verdict; frames that are unstable, unstable with a caution, and all with a computed spectrum."""
    results = list(results)
    verdicts = {verdict: sum(r["verdict"] == verdict for r in results) for verdict in (*GOOD, *BAD)}
    return verdicts | {name: sum(r.get(name, 0) for r in results) for name in FRAMES}


def regions(results: list) -> dict[str, dict[str, int]]:
    """The counts of all scenes, of each axis, and of every other parameter in which scenes differ."""
    names = dict.fromkeys([*CENTRE, *(name for r in results for name in r["probed"])])
    groups = {"all": results} | {name: [r for r in results if name in r["probed"]] for name in names}
    return {name: counted(group) for name, group in groups.items() if group}


def causes(results: list) -> list[dict]:
    """Rows of the causes for which scenes gave up: how many, and which `numbers`."""
    why = [
        (next(c for part, c in CAUSES.items() if part in r["reason"]), r["number"]) for r in _with(results, "gave up")
    ]
    rows = {cause: [number for each, number in why if each == cause] for cause in dict(why)}
    return [{"cause": cause, "scenes": len(found), "numbers": found} for cause, found in rows.items()]


def failed(results: list, forms: list, limits: list) -> bool:
    """Whether a scene has a bad verdict, a closed form does not hold or a limit is exceeded."""
    exceeded = any(limit.attained > limit.allowed for limit in limits)
    return exceeded or any(r["verdict"] in BAD for r in results) or not all(form.held for form in forms)


def report(results: list, forms: list, limits: list) -> str:
    """Everything found, as text; `results` are plain data of `verdicts.assess`."""
    counts = counted(results)
    share = 100.0 * counts["converged"] / max(1, len(results) - counts["refused"])
    residual = max((r["residual"] for r in results if r.get("residual")), default=0.0)
    verdict = "WRONG: see below" if failed(results, forms, limits) else "nothing wrong"
    lines = [
        f"Verdict: {verdict}. {len(results)} scenes; {share:.2f}% of the valid ones converged, the others gave up.",
        f"Largest recomputed residual over the tolerance: {residual:.2f}. Unstable frames: {counts['unstable']}, and"
        f" {counts['cautioned']} with a caution, of {counts['spectra']} with a computed spectrum.",
    ]
    tables = {
        "Scenes by extreme parameter": [{"probed": name} | row for name, row in regions(results).items()],
        "Causes for which scenes gave up": causes(results),
        "Closed forms": [asdict(form) | {"held": form.held} for form in forms],
        ROUND_OFF: [asdict(limit) for limit in limits],
        "Scenes that gave up, or worse": _scenes(results, ["gave up", *BAD]),
        "Scenes refused for their combination": _scenes(results, ["refused"]),
    }
    for title, rows in tables.items():
        if rows:
            table = DataFrame(map(_texts, rows), dtype=str)
            lines += ["", title, *(line.rstrip() for line in table.to_string(index=False, justify="left").splitlines())]
    return "\n".join(lines)


def _scenes(results, verdicts):
    some = _with(results, *verdicts)
    return [{"verdict": r["verdict"], "python -m solver run": r["set"], "reason": r["reason"]} for r in some]


def _with(results, *verdicts):
    """The results with one of these verdicts."""
    return [r for r in results if r["verdict"] in verdicts]


def _texts(row):
    """The row with numbers as text, and nothing for None."""
    shown = {name: f"{value:.1e}" if isinstance(value, float) else value for name, value in row.items()}
    return {name: "" if value is None else str(value) for name, value in shown.items()}


def main(argv: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="a part of the scenes")
    parser.add_argument("--scenes", nargs="+", type=int, metavar="N", help="only these numbers, without closed forms")
    parser.add_argument("--limit", type=float, default=LIMIT, metavar="SECONDS", help="of one scene; default 300")
    parser.add_argument("--jobs", type=int, metavar="N", help="processes; default: one per core")
    arguments = parser.parse_args(argv)
    asked = cases(arguments.quick)
    if unknown := set(arguments.scenes or ()) - {case.number for case in asked}:
        parser.error(f"--scenes {min(unknown)}: allowed: 0 .. {len(asked) - 1}")
    asked = [case for case in asked if arguments.scenes is None or case.number in arguments.scenes]
    results = atlas(asked, arguments.jobs, limit=arguments.limit, progress=_shown)
    found = results, closed_forms() if arguments.scenes is None else [], conditioning()
    print(report(*found))
    return int(failed(*found))


def _shown(part):
    print(f"\r{part:.0%}", end="" if part < 1.0 else "\n", file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
