"""The command line, `python -m solver` or `mixed-mode-contact`: its commands, exit codes and listings."""

import argparse
import codecs
import os
import sys
from collections.abc import Sequence
from io import TextIOWrapper
from textwrap import wrap
from typing import NoReturn

from numba.core.event import Event, Listener, install_listener

from .. import NotConverged, Scene, SceneError, __version__
from ..presets import presets
from ..scene import CHOICES, LIMITS, PARAMETERS
from ..text import named
from ..threads import one_thread
from .accuracy import add_accuracy
from .options import BAD_INPUT, INTERRUPTED, NOT_CONVERGED, program
from .pairs import InputError
from .run import add_run
from .serve import add_serve
from .sweep import add_sweep
from .verify import add_verify

CLOSED_PIPE = 141  # exit code, as shells report SIGPIPE
COLUMNS = 100  # characters of a line of `parameters`: a terminal beside another window
COMMANDS = add_run, add_sweep, add_verify, add_accuracy, add_serve


class CompilingNotice(Listener):
    """Reports on standard error that kernels are being compiled, once."""

    shown = False

    def on_start(self, event: Event) -> None:
        if not self.shown:
            self.shown = True
            print("Compiling: a later run starts at once, where compiled code can be kept", file=sys.stderr, flush=True)

    def on_end(self, event: Event) -> None:
        pass


def process() -> int:
    """Runs `main` as a process of its own; returns the exit code, also where `| head` ends standard output early."""
    codecs.register_error("solver", named)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors="solver")  # some terminals and files cannot show the Greek letters of units
    try:
        try:
            with install_listener("numba:compile", CompilingNotice()):
                return main()
        finally:
            sys.stdout.flush()
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # what is left to write has no reader
        return CLOSED_PIPE


class Parser(argparse.ArgumentParser):
    """Raises InputError for bad arguments, in place of printing the usage."""

    def error(self, message: str) -> NoReturn:
        raise InputError(f"{self.prog}: {message}; see {self.prog} --help")


def main(argv: Sequence[str] | None = None) -> int:
    """Runs the subcommand named in `argv` and returns the exit code."""
    try:
        arguments = parser().parse_args(argv)
        with one_thread():
            return arguments.command(arguments) or 0
    except (InputError, SceneError) as error:
        print(error, file=sys.stderr)
        return BAD_INPUT
    except NotConverged as error:
        print(error, file=sys.stderr)
        return NOT_CONVERGED
    except KeyboardInterrupt:
        print("Interrupted; run again to finish", file=sys.stderr)
        return INTERRUPTED


def parser() -> Parser:
    """The parser of all commands."""
    text = "Computes adhesive contacts under mixed-mode loading. COMMAND --help shows its options."
    parser = Parser(prog=program(), description=text)
    parser.add_argument("--version", action="version", version=__version__)
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    for add in COMMANDS:
        add(commands)
    for name, listing in (("parameters", parameter_table), ("presets", preset_table)):
        listed = commands.add_parser(name, help=f"list all {name}", description=f"Lists all {name}.")
        listed.set_defaults(command=lambda _, listing=listing: print(listing()))
    return parser


def parameter_table() -> str:
    """Every parameter with its range, default, unit and meaning."""
    lines, indent = [], 12 * " "
    for name, parameter in PARAMETERS.items():
        default = getattr(Scene, name)
        lines.append(f"{name:<11} {parameter.span}, default {f'{default:g}' if name in LIMITS else default}")
        words = (f"{word}: {meaning}" for word, meaning in CHOICES.get(name, {}).items())
        for text in (parameter.meaning, *words):
            lines += wrap(text, COLUMNS, initial_indent=indent, subsequent_indent=indent + "  ")
    file = "columns x, z in nm, for surface=measured; all of its length is used, or the middle part of a width given;"
    file += " --columns and --units name what the file does not; in Python, Scene takes measured=read_profile(FILE)"
    lines += ["profile     the name of a file", *wrap(file, COLUMNS, initial_indent=indent, subsequent_indent=indent)]
    return "\n".join(lines)


def preset_table() -> str:
    """Every preset with its title."""
    return "\n".join(f"{name:<11} {preset.label}" for name, preset in presets().items())
