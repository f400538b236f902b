"""What each constant of the continuation decides: halve it and double it, and compare runs.

    python tests/bench/constants.py [--only TEXT] [--scenes N] [--json FILE]

Scenes: the default, five of the slider box and six small cells, or the first N of these. A row per constant: its
value, and for half and twice of it the force evaluations over those of the value, and in how many scenes the loads of
slips (to 1e-4 nm), their number, or the last force (to 1e-4) differ.
"""

import sys
from dataclasses import fields, is_dataclass
from functools import partial
from importlib import import_module
from pkgutil import iter_modules

import numpy as np
from scenes import cells, options, ran, scene_of, slider_box, write

from solver import Scene, continuation

SMALL = {"nodes": 512, "width": 1250.0, "radius": 5.0, "u_x_max": 20.0}


def constants():
    """Yield (name, value, function that sets it): numbers of every module, and of its default options."""
    modules = [import_module(f"solver.continuation.{module.name}") for module in iter_modules(continuation.__path__)]
    for name, value in {name: value for module in modules for name, value in vars(module).items()}.items():
        if name.isupper() and type(value) in (int, float):
            yield name, value, partial(put, modules, name)
        elif name.isupper() and is_dataclass(value):
            for field in fields(value):
                yield f"{name}.{field.name}", getattr(value, field.name), partial(vary, value, field.name)


def put(modules, name, new):
    """Set a constant wherever it has been imported."""
    for module in modules:
        if hasattr(module, name):
            setattr(module, name, new)


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
