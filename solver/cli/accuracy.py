"""The command `accuracy`: error against run time of one scene."""

import argparse
from typing import Any

from ..files import write_json
from ..scene import Scene, SceneError
from .options import add_command, add_file, count, progress, write


def add_accuracy(commands: Any) -> None:
    """Adds `accuracy` to the subcommands."""
    text = "Measures error against run time of one experiment, by fast and the paper's GFMD, over tolerance and du_x."
    parser = add_command(commands, "accuracy", accuracy, "error against run time", text)
    parser.add_argument("--quick", action="store_true", help="one slip and fewer runs")
    slips = "end just beyond slip N in shear, default 2 (with --quick: 1)"
    parser.add_argument("--slips", type=count, metavar="N", help=slips)
    add_file(parser, "json", "all results")


def accuracy(scene: Scene, arguments: argparse.Namespace) -> int:
    """Measures error against run time, writes the files asked for, prints tables; returns the exit code."""
    from ..accuracy.measure import measure  # imported here because `run` does not need them
    from ..accuracy.report import data, text

    for name, only in (("path", "shear"), ("hold", "delta")):
        if (value := getattr(scene, name)) != only:
            allowed = f"allowed with `accuracy`: {only}, which every method knows"
            raise SceneError(name, value, allowed, f"use {name}={only}")
    with progress(100, "%") as bar:
        for done, so_far in measure(scene, arguments.quick, arguments.slips):
            bar.update(int(100 * done) - bar.n)
            if so_far is not None:
                report = so_far
    print(text(report))
    write(arguments.json, write_json, data(report))
    return 0
