"""The command `map`: first slips over two parameters."""

import argparse
import sys
from functools import partial
from typing import Any
from zlib import crc32

from .. import __version__, plots
from ..analysis.maps import REGIMES, Axis, Map, Point, explored
from ..analysis.maps.point import QUANTITIES
from ..scene import Scene
from .options import (
    INTERRUPTED,
    NOT_CONVERGED,
    InputError,
    add_command,
    add_file,
    add_plot,
    add_scheduler,
    progress,
    write,
)


def add_map(commands: Any) -> None:
    """Adds `map` to the subcommands."""
    text = "Computes the first slip over two parameters. Each point is continued from a neighbour, or is a run."
    epilog = (
        "Columns: i, j, the parameters, regime, U_s, A_s, A_0 (nm), F_s, L_min (N/m), asymmetry, sites,"
        " reattached, branches, followed, evaluations, reason, scene, version. docs/files.md defines them."
    )
    parser = add_command(commands, "map", mapped, "first slips over two parameters", text, epilog)
    form = "NAME=LOW:HIGH:COUNT[:log]"
    parser.add_argument("--x", metavar=form, required=True, help="a continuous parameter, range and number of values")
    parser.add_argument("--y", metavar=form, required=True, help="another continuous parameter")
    column = "write this column only, as a table of y by x"
    parser.add_argument("--column", metavar="NAME", choices=("regime", *QUANTITIES), help=column)
    parser.add_argument("--resume", action="store_true", help="keep the points that --csv has of the same map")
    add_scheduler(parser)
    add_file(parser, "csv", "a row per point", required=True)
    add_plot(parser, "the column and the regimes")


def mapped(scene: Scene, arguments: argparse.Namespace) -> int:
    """Computes a map and writes it; 1 if a point has no result."""
    grid = Map(scene, Axis.of(arguments.x), Axis.of(arguments.y))
    points, code = _resumed(arguments.csv, grid) if arguments.resume else [], 0
    try:
        with progress(grid.size, " points") as bar:
            bar.update(len(points))
            for point in explored(grid, arguments.scheduler, points):
                points.append(point)
                bar.update()
    except KeyboardInterrupt:
        remedy = "run again with --resume to finish" if arguments.column is None else "run again"
        print(f"Interrupted; {remedy}", file=sys.stderr)
        code = INTERRUPTED
    table = grid.table(points).assign(**_origin(grid))
    write(arguments.csv, _write, table, arguments.column, grid)
    save, shown = partial(plots.save, title=repr(scene)), (table, grid.x.name, grid.y.name, arguments.column)
    write(arguments.html, save, plots.first_slips, *shown)
    print(_described(points))
    return code or (NOT_CONVERGED if any(point.reason for point in points) else 0)


def _origin(grid):
    """{column: text} of what every point of a map shares: the parameters that differ from the default, the version."""
    values = {name: value for name, value in grid.scene.differences().items() if name not in (grid.x.name, grid.y.name)}
    if grid.scene.measured:
        values["profile"] = f"{crc32(grid.scene.measured.heights):08x}"  # a checksum of its heights
    return {"scene": " ".join(f"{name}={value}" for name, value in values.items()), "version": __version__}


def _resumed(file, grid):
    """The Points of an earlier file that have a result; raises InputError unless it is of this map."""
    from pandas import read_csv  # takes longer to import than the solver

    try:
        rows = read_csv(file, dtype=str, keep_default_na=False)
        points = [Point.from_row(row) for row in rows.to_dict("records")]
        axes = [grid.x.name, grid.y.name]
        same = rows[axes].astype(float).equals(grid.table(points)[axes])
        others = rows[list(_origin(grid))].drop_duplicates().to_dict("records")
    except FileNotFoundError:
        return []
    except (OSError, ValueError, KeyError, TypeError, IndexError):
        same = False
    if not same:
        raise InputError(f"--resume {file!r}: allowed: a file of all columns of this map; leave --resume out")
    for other in others:
        if other != (own := _origin(grid)):
            held, here = (f"scene '{each['scene']}', version {each['version']}" for each in (other, own))
            message = f"--resume {file!r}: is of {held}; allowed: {here}"
            raise InputError(f"{message}; leave --resume out, or name another file")
    return [point for point in points if not point.reason]


def _write(file, table, of, grid):
    """Writes a table of points; of: only this column, y by x, empty where there is no value."""
    if of is not None:
        table = table.pivot(index=grid.y.name, columns=grid.x.name, values=of)
        table = table.reindex(index=grid.y.values, columns=grid.x.values)
    table.to_csv(file, index=of is not None, index_label=f"{grid.y.name} \\ {grid.x.name}", lineterminator="\n")


def _described(points):
    """The map in a line."""
    counts = {regime: sum(point.regime == regime for point in points) for regime in REGIMES}
    followed, spent = sum(point.followed for point in points), sum(point.evaluations for point in points)
    counted = ", ".join(f"{regime} {count}" for regime, count in counts.items() if count)
    return f"{len(points)} points, {followed} followed, {spent} evaluations: {counted}"
