"""The command `map`: a map of first slips over two parameters, or of the friction of flats."""

import csv
import os
import sys

from .analysis import regimes
from .analysis.maps import COLUMNS, REGIMES, Axis, Map, Point, worked_off
from .analysis.maps.point import QUANTITIES
from .command import (
    INTERRUPTED,
    NOT_CONVERGED,
    InputError,
    add_command,
    add_file,
    add_scheduler,
    progress,
    scene_of,
    settings,
    write,
)
from .files import write_rows
from .isolated import Lost, crew, outcomes

LIMIT = 600.0  # s for a tile of five points


def add_map(commands):
    """Adds `map` to the subcommands."""
    text = (
        "With --x and --y: the first slip over two parameters, each point followed from its neighbours or run."
        " Without: friction of flats over stiffness E and strength phi_t (Figs. 4, 5), from runs and in closed form."
    )
    epilog = (
        "\n\ncolumns of the first: i, j, the two parameters, regime, U_s (nm), F_s, A_s, A_0, asymmetry, sites,"
        " reattached, L_min,\nbranches, followed, evaluations, reason; see solver/analysis/maps/point.py\n"
        "columns of flats: E (GPa), phi_t (N/m), slips, F_s and F_k (over wE), mean and exact (over w tau_max), reason"
    )
    parser = add_command(commands, "map", mapped, "maps over two parameters", text, epilog)
    form = "NAME=LOW:HIGH:COUNT[:log]"
    parser.add_argument("--x", metavar=form, help="a continuous parameter and its values")
    parser.add_argument("--y", metavar=form, help="another one")
    parser.add_argument("--of", metavar="COLUMN", help="write only that, as a table of y by x")
    parser.add_argument("--resume", action="store_true", help="go on with the points of the same map in --csv")
    parser.add_argument("--points", type=int, default=12, metavar="N", help="of flats: N x N, 2 .. 100, default 12")
    add_scheduler(parser)
    add_file(parser, "csv", "a row per point", required=True)


def mapped(arguments):
    """Computes a map and writes it; 1 if a point has no result but a reason."""
    if arguments.x is None and arguments.y is None:
        return flats(arguments)
    for option in ("x", "y"):
        if getattr(arguments, option) is None:
            raise InputError(f"--{option}: missing; give --x and --y, or none of them for a map of flats")
    if arguments.of not in (None, "regime", *QUANTITIES):
        raise InputError(f"--of {arguments.of}: allowed: regime, {', '.join(QUANTITIES)}; choose one of them")
    grid = Map(scene_of(settings(arguments.set)), Axis.of(arguments.x), Axis.of(arguments.y))
    points = _known(arguments, grid) if arguments.resume else []
    code = 0
    try:
        with progress(grid.size, " points") as bar:
            bar.update(len(points))
            for point in explored(grid, _workers(arguments), points):
                points.append(point)
                bar.update()
    except KeyboardInterrupt:
        print("Interrupted; --resume goes on from here" if arguments.of is None else "Interrupted", file=sys.stderr)
        code = INTERRUPTED
    if arguments.of is None:
        heading = [*COLUMNS[:2], grid.x.name, grid.y.name, *COLUMNS[2:]]
        write(arguments.csv, write_rows, heading, [_row(grid, point) for point in points])
    else:
        write(arguments.csv, write_rows, *_table(grid, points, arguments.of))
    without = sum(bool(point.reason) for point in points)
    print(_described(points))
    return code or (NOT_CONVERGED if without else 0)


def flats(arguments):
    """Computes the map of regimes of flats and writes it; 1 if a point has no result but a reason."""
    if not 2 <= arguments.points <= 100:
        raise InputError(f"--points {arguments.points}: allowed: 2 .. 100")
    asked = regimes.points(scene_of(settings(arguments.set)), arguments.points)
    rows = [None] * len(asked)
    with progress(len(asked), " points") as bar:
        for k, found in outcomes(regimes.regime, asked, _workers(arguments), regimes.LIMIT):
            _, E, phi_t = asked[k]
            rows[k] = {"E": E, "phi_t": phi_t, "reason": found.reason} if isinstance(found, Lost) else found
            bar.update()
    columns = regimes.COLUMNS
    write(arguments.csv, write_rows, columns, ([row.get(name, "") for name in columns] for row in rows))
    slip, without = (sum(bool(row.get(name)) for row in rows) for name in ("slips", "reason"))
    print(f"{len(rows)} points: {slip} stick and slip, {without} without a result")
    return NOT_CONVERGED if without else 0


def _workers(arguments):
    """As of `isolated.outcomes`."""
    return arguments.scheduler or os.cpu_count() or 1


def explored(grid, workers, points=()):
    """Yield the Points of a Map but those that are given, coarse to fine; workers: as of `isolated.outcomes`."""
    known = {(point.i, point.j): (point, None) for point in points}
    with crew(workers) as outcomes_of:
        for level in range(grid.levels):
            tiles = list(grid.tiles(level, known))
            for k, found in outcomes_of(worked_off, tiles, LIMIT):
                pairs = grid.lost(tiles[k], found.reason) if isinstance(found, Lost) else found
                for point, skeleton in pairs:
                    known[point.i, point.j] = point, skeleton
                    yield point


def _known(arguments, grid):
    """The Points of a file, of this map as far as it tells; those without a result are left out."""
    try:
        with open(arguments.csv, newline="", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        points = [Point.from_row(row) for row in rows]
        places = [[float(row[axis.name]) for axis in (grid.x, grid.y)] for row in rows]
        same = places == [_parameters(grid, point) for point in points]
    except FileNotFoundError:
        return []
    except (OSError, ValueError, KeyError, TypeError, IndexError):
        same = False
    if not same:
        raise InputError(f"--resume {arguments.csv!r}: allowed: a file of all columns of this map; leave --resume out")
    return [point for point in points if not point.reason]


def _parameters(grid, point):
    """[value of x, value of y]"""
    return [float(grid.x.values[point.i]), float(grid.y.values[point.j])]


def _row(grid, point):
    """All columns of a point, the two parameters behind their places."""
    i, j, *rest = point.as_row().values()
    return [i, j, *_parameters(grid, point), *rest]


def _table(grid, points, of):
    """(heading, rows) of a column as a table of y by x, "" where there is none."""
    found = {(point.i, point.j): point.as_row()[of] for point in points}
    rows = ([float(y), *(found.get((i, j), "") for i in range(grid.x.count))] for j, y in enumerate(grid.y.values))
    return [f"{grid.y.name} \\ {grid.x.name}", *map(float, grid.x.values)], rows


def _described(points):
    """The map in a line for people."""
    counts = {regime: sum(point.regime == regime for point in points) for regime in REGIMES}
    followed, spent = sum(point.followed for point in points), sum(point.evaluations for point in points)
    said = ", ".join(f"{regime} {count}" for regime, count in counts.items() if count)
    return f"{len(points)} points, {followed} followed, {spent} evaluations: {said}"
