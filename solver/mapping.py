"""The command `map`: a map of first slips over two parameters, or of the friction of flats (`bulk.flats`)."""

import argparse
import csv
import os
import sys
from pathlib import Path

from .bulk import add_scheduler, flats
from .command import (
    INTERRUPTED,
    NOT_CONVERGED,
    InputError,
    check_writable,
    parameter_table,
    progress,
    scene_of,
    settings,
    writing,
)
from .isolated import Lost, crew

LIMIT = 600.0  # s for a tile of five points


def add_map(commands):
    """Adds `map` to the subcommands."""
    text = (
        "With --x and --y: the first slip over two parameters, each point followed from its neighbours or run."
        " Without: friction of flats over stiffness E and strength phi_t (Figs. 4, 5), from runs and in closed form."
    )
    epilog = (
        "columns of the first: i, j, the two parameters, regime, U_s (nm), F_s, A_s, A_0, asymmetry, sites, reattached,"
        " L_min,\nbranches, followed, evaluations, reason; see solver/analysis/maps/point.py\n"
        "columns of flats: E (GPa), phi_t (N/m), slips, F_s and F_k (over wE), mean and exact (over w tau_max), reason"
        "\n\n"
    )
    raw = argparse.RawDescriptionHelpFormatter
    add = commands.add_parser
    parser = add(
        "map", help="maps over two parameters", description=text, epilog=epilog + parameter_table(), formatter_class=raw
    )
    parser.add_argument("--set", nargs="+", action="extend", default=[], metavar="NAME=VALUE", help="as in run")
    form = "NAME=LOW:HIGH:COUNT[:log]"
    parser.add_argument("--x", metavar=form, help="a continuous parameter and its values")
    parser.add_argument("--y", metavar=form, help="another one")
    parser.add_argument("--of", metavar="COLUMN", help="write only that, as a table of y by x")
    parser.add_argument("--resume", action="store_true", help="go on with the points of the same map in --csv")
    parser.add_argument("--points", type=int, default=12, metavar="N", help="of flats: N x N, 2 .. 100, default 12")
    add_scheduler(parser)
    parser.add_argument("--csv", metavar="FILE", required=True, help="write a row per point")
    parser.set_defaults(command=mapped)


def mapped(arguments):
    """Computes a map and writes it; 1 if a point has no result but a reason."""
    if arguments.x is None and arguments.y is None:
        return flats(arguments)
    from .analysis.maps import COLUMNS, Axis, Map  # what `run` does not need
    from .analysis.maps.point import QUANTITIES

    for option in ("x", "y"):
        if getattr(arguments, option) is None:
            raise InputError(f"--{option}: missing; give --x and --y, or none of them for a map of flats")
    if arguments.of not in (None, "regime", *QUANTITIES):
        raise InputError(f"--of {arguments.of}: allowed: regime, {', '.join(QUANTITIES)}; choose one of them")
    grid = Map(scene_of(settings(arguments.set)), Axis.of(arguments.x), Axis.of(arguments.y))
    points = _known(arguments, grid, COLUMNS) if arguments.resume else []
    check_writable("csv", arguments.csv)
    code = 0
    try:
        with progress(grid.size, " points") as bar:
            bar.update(len(points))
            for point in explored(grid, arguments.scheduler or os.cpu_count() or 1, points):
                points.append(point)
                bar.update()
    except KeyboardInterrupt:
        print("Interrupted; --resume goes on from here" if arguments.of is None else "Interrupted", file=sys.stderr)
        code = INTERRUPTED
    _write(arguments, grid, points, COLUMNS)
    without = sum(bool(point.reason) for point in points)
    print(_described(points))
    return code or (NOT_CONVERGED if without else 0)


def explored(grid, workers, points=()):
    """Yield the Points of a Map but those that are given, coarse to fine; workers: as of `isolated.outcomes`."""
    from .analysis.maps import worked_off

    known = {(point.i, point.j): (point, None) for point in points}
    with crew(workers) as outcomes_of:
        for level in range(grid.levels):
            tiles = list(grid.tiles(level, known))
            for k, found in outcomes_of(worked_off, tiles, LIMIT):
                pairs = grid.lost(tiles[k], found.reason) if isinstance(found, Lost) else found
                for point, skeleton in pairs:
                    known[point.i, point.j] = point, skeleton
                    yield point


def _known(arguments, grid, columns):
    """The Points of a file, of this map as far as it tells; those without a result are left out."""
    from .analysis.maps import Point

    try:
        with open(arguments.csv, newline="", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        points = [Point.from_row(row) for row in rows]
        same = all(
            _parameters(grid, point).items() <= {k: _number(v) for k, v in row.items()}.items()
            for point, row in zip(points, rows, strict=True)
        )
    except FileNotFoundError:
        return []
    except (OSError, ValueError, KeyError, TypeError, IndexError):
        same = False
    if not same:
        raise InputError(f"--resume {arguments.csv!r}: allowed: a file of all columns of this map; leave --resume out")
    return [point for point in points if not point.reason]


def _number(text):
    try:
        return float(text)
    except (TypeError, ValueError):
        return None


def _parameters(grid, point):
    return {grid.x.name: float(grid.x.values[point.i]), grid.y.name: float(grid.y.values[point.j])}


def _write(arguments, grid, points, columns):
    """The file: a row per point, or a table of one column."""
    with writing(), Path(arguments.csv).open("w", newline="", encoding="utf-8") as file:
        if arguments.of is not None:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow([f"{grid.y.name} \\ {grid.x.name}", *map(float, grid.x.values)])
            table = _table(grid, points, arguments.of)
            writer.writerows([float(y), *row] for y, row in zip(grid.y.values, table, strict=True))
            return
        writer = csv.DictWriter(file, [*columns[:2], grid.x.name, grid.y.name, *columns[2:]], lineterminator="\n")
        writer.writeheader()
        writer.writerows(point.as_row() | _parameters(grid, point) for point in points)


def _table(grid, points, of):
    """Rows of a column, "" where there is none."""
    table = [[""] * grid.x.count for _ in range(grid.y.count)]
    for point in points:
        table[point.j][point.i] = point.as_row()[of]
    return table


def _described(points):
    """The map in a line for people."""
    from .analysis.maps import REGIMES

    counts = {regime: sum(point.regime == regime for point in points) for regime in REGIMES}
    followed, spent = sum(point.followed for point in points), sum(point.evaluations for point in points)
    said = ", ".join(f"{regime} {count}" for regime, count in counts.items() if count)
    return f"{len(points)} points, {followed} followed, {spent} evaluations: {said}"
