"""The commands that test the solver: `accuracy` on one scene, `stability` on many."""

import argparse
from typing import Any

from .command import (
    NOT_CONVERGED,
    InputError,
    add_command,
    add_file,
    add_scheduler,
    progress,
    within,
    write,
)
from .files import write_json
from .scene import Scene, SceneError


def add_accuracy(commands: Any) -> None:
    """Adds `accuracy` to the subcommands."""
    text = "Measures the error of one experiment against run time, by every method, over tolerance and increment du_x."
    parser = add_command(commands, "accuracy", accuracy, "error against run time", text)
    parser.add_argument("--quick", action="store_true", help="one slip and fewer runs")
    slips = "end just beyond slip N in shear, default 2 (with --quick: 1)"
    parser.add_argument("--slips", type=within(1), metavar="N", help=slips)
    add_file(parser, "json", "all results")
    add_file(parser, "html", "the diagram as a page that opens offline")


def accuracy(scene: Scene, arguments: argparse.Namespace) -> int:
    """Measures error against run time, writes the files asked for, prints tables; returns the exit code."""
    from .validation.accuracy import measure  # imported here because `run` does not need them
    from .validation.accuracy_report import data, document

    for name, only in (("path", "shear"), ("hold", "delta")):
        if (value := getattr(scene, name)) != only:
            allowed = f"allowed with `accuracy`: {only}, which every method knows"
            raise SceneError(name, value, allowed, f"use {name}={only}")
    with progress(100, "%") as bar:
        for done, so_far in measure(scene, arguments.quick, arguments.slips):
            bar.update(int(100 * done) - bar.n)
            if so_far is not None:
                report = so_far
    shown = document(report)
    print(shown.text())
    write(arguments.json, write_json, data(report))
    write(arguments.html, shown.write_page)
    return 0


def add_stability(commands: Any) -> None:
    """Adds `stability` to the subcommands."""
    text = "Checks stiff and extreme scenes in extended precision, then closed forms and the conditioning of formulas."
    parser = commands.add_parser("stability", help="stiff and extreme scenes", description=text)
    parser.add_argument("--quick", action="store_true", help="a part of the scenes")
    parser.add_argument("--scenes", nargs="+", type=int, metavar="N", help="only these numbers, without closed forms")
    limit = "time limit of one scene, at least 1, default 120"
    parser.add_argument("--limit", type=within(1, kind=float), metavar="SECONDS", help=limit)
    add_scheduler(parser)
    add_file(parser, "json", "all results")
    add_file(parser, "html", "the report as a page that opens offline")
    parser.set_defaults(command=stability)


def stability(arguments: argparse.Namespace) -> int:
    """Computes the atlas, writes the files asked for, prints tables; 1 if anything fails its check."""
    from .validation.atlas import cases  # `run` does not need these
    from .validation.closed_forms import closed_forms
    from .validation.conditioning import conditioning
    from .validation.stability import LIMIT, atlas
    from .validation.stability_report import Report

    asked = cases(arguments.quick)
    if unknown := set(arguments.scenes or ()) - {case.number for case in asked}:
        raise InputError(f"--scenes {min(unknown)}: allowed: 0 .. {len(asked) - 1}")
    with progress(100, "%") as bar:
        asked = [case for case in asked if arguments.scenes is None or case.number in arguments.scenes]
        limit = arguments.limit or LIMIT
        results = atlas(asked, arguments.scheduler, lambda part: bar.update(int(100 * part) - bar.n), limit)
    report = Report(results, closed_forms() if arguments.scenes is None else [], conditioning())
    shown = report.document()
    print(shown.text())
    write(arguments.json, write_json, report.data())
    write(arguments.html, shown.write_page)
    return NOT_CONVERGED if report.failed else 0
