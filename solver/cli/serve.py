"""The command `serve`: opens the page that was installed with this package, from any folder."""

import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

HERE = Path(__file__).parents[2]  # holds both packages


def add_serve(commands: Any) -> None:
    """Adds `serve` to the subcommands."""
    text = "Serves the page until Ctrl-C. `panel serve --help` lists further options, which all are passed on."
    # Words with a dash are options of Panel. This parser has none.
    parser = commands.add_parser("serve", help="open the page", description=text, prefix_chars="+", add_help=False)
    parser.add_argument("options", nargs="*", metavar="OPTION", help="--show, --port 5006, ...")
    parser.set_defaults(command=lambda arguments: serve(arguments.options, parser.print_help))


def serve(options: list[str], explain: Callable[[], None]) -> None:
    """Serves the page with options of `panel serve`; explain() prints the help."""
    if {"-h", "--help"} & {*options}:
        return explain()
    from panel.command import main  # here: other commands need no server

    # `python -m` puts the current folder on the path, which may have an `app` of its own.
    sys.path[:] = [place for place in sys.path if place != os.getcwd() or place == str(HERE)]
    sys.argv = ["panel", "serve", str(HERE / "app"), *options]
    return main()
