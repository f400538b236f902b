"""`python -m solver`: the command line of `cli`, as a process of its own."""

import os
import sys
from collections.abc import Callable, Sequence
from io import TextIOWrapper
from typing import Any

from numba.core.event import Event, Listener, install_listener

from .cli import main

CLOSED_PIPE = 141  # exit code, as shells report SIGPIPE


class CompilingNotice(Listener):
    """Reports on standard error that kernels are being compiled, once."""

    shown = False

    def on_start(self, event: Event) -> None:
        if not self.shown:
            self.shown = True
            print("Compiling, once per installation: later runs start at once", file=sys.stderr, flush=True)

    def on_end(self, event: Event) -> None:
        pass


def run(program: str = "python -m solver", more: Sequence[Callable[[Any], None]] = ()) -> int:
    """Runs `cli.main` and returns the exit code, also where the reader of standard output ends early (`| head`).

    program: its name in messages; more: functions that add commands.
    """
    if isinstance(sys.stdout, TextIOWrapper):
        sys.stdout.reconfigure(errors="replace")  # some terminals cannot show the Greek letters of units
    try:
        try:
            with install_listener("numba:compile", CompilingNotice()):
                return main(program=program, more=more)
        finally:
            sys.stdout.flush()
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # what is left to write has no reader
        return CLOSED_PIPE


if __name__ == "__main__":
    sys.exit(run())
