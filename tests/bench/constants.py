"""What each constant of the continuation decides: halve it and double it, and compare runs.

    python tests/bench/constants.py [--only TEXT] [--scenes N] [--json FILE]

Scenes: the default, five of the slider box and six small cells, or the first N of these. A row per constant: its
value, and for half and twice of it the force evaluations over those of the value, and in how many scenes the loads of
slips (to 1e-4 nm), their number, or the last force (to 1e-4) differ.
"""

import sys
from dataclasses import fields
from importlib import import_module
from pkgutil import iter_modules

import numpy as np
from scenes import cells, options, ran, scene_of, slider_box, write

from solver import Scene, continuation
from solver.continuation import anderson, branch, state
from solver.run import loadpath

SMALL = {"nodes": 512, "width": 1250.0, "radius": 5.0, "u_x_max": 20.0}
PLAIN = {  # constants outside of records, and the modules that have imported them
    "REGULARISATION": [anderson], "FORGET": [anderson], "MOVED": [state, branch], "FREE": [loadpath],
}  # fmt: skip


def constants():
    """Yield (name, value, function that sets it): plain ones, and the numbers of every module's default options."""
    for name, modules in PLAIN.items():
        yield name, getattr(modules[0], name), lambda x, n=name, some=modules: [setattr(m, n, x) for m in some]
    for module in iter_modules(continuation.__path__):
        record = getattr(import_module(f"{continuation.__name__}.{module.name}"), module.name.upper(), None)
        for field in fields(record) if record else ():
            value = getattr(record, field.name)
            if isinstance(value, (int, float)):
                yield f"{module.name}.{field.name}", value, lambda x, r=record, n=field.name: vary(r, n, x)


def vary(record, name, value):
    """Change a frozen record, which only this bench may do."""
    object.__setattr__(record, name, value)


def results(scenes):
    """[(evaluations, loads of slips, last F_bar)] of runs."""
    for scene in scenes:
        frames = ran(scene)[0]
        loads = np.array([event.load for frame in frames for event in frame.slips])
        yield sum(frame.evaluations for frame in frames), loads, frames[-1].F_bar if frames else np.nan


def differ(a, b):
    """Whether two results do."""
    if a[1].size != b[1].size or np.abs(a[1] - b[1]).max(initial=0.0) > 1e-4:
        return True
    return abs(a[2] - b[2]) > 1e-4 * abs(a[2])


def main():
    parser = options(__doc__)
    parser.add_argument("--only", metavar="TEXT", default="", help="constants whose name contains this")
    parser.add_argument("--scenes", metavar="N", type=int)
    arguments = parser.parse_args()
    values = [*slider_box(5, 77, **SMALL), *list(cells(7, 52))[1:]]
    scenes, rows = [Scene(), *map(scene_of, values)][: arguments.scenes], []
    usual = list(results(scenes))
    for name, value, change in constants():
        if arguments.only not in name:
            continue
        row = {"name": name, "value": value}
        for factor in (0.5, 2.0):
            change(type(value)(value * factor))
            varied = list(results(scenes))
            change(value)
            row[f"x{factor:g}"] = sum(r[0] for r in varied) / sum(r[0] for r in usual)
            row[f"differ x{factor:g}"] = sum(map(differ, usual, varied))
        rows.append(row)
        print("  ".join(f"{key} {x:.4g}" if key != "name" else f"{x:24}" for key, x in row.items()), flush=True)
    write(arguments.json, rows)
    return 0


if __name__ == "__main__":
    sys.exit(main())
