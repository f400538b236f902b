"""The console script `mixed-mode-contact`: all commands of `python -m solver`, and `serve` for the page."""

import os
import subprocess
import sys
from pathlib import Path

from solver.__main__ import run


def main() -> int:
    """Run the command in `sys.argv` and return the exit code."""
    if sys.argv[1:2] == ["serve"]:
        return serve(sys.argv[2:])
    return run("mixed-mode-contact", [add_serve])


def serve(options: list[str]) -> int:
    """Serve the page from the installed package with options of `panel serve`."""
    command = [sys.executable, "-m", "panel", "serve", str(Path(__file__).parent), *options]
    if os.name == "posix":  # signals then reach the server
        os.execv(command[0], command)
    try:
        return subprocess.run(command).returncode
    except KeyboardInterrupt:
        return 0


def add_serve(commands) -> None:
    """Add `serve` to the list of commands; `main` runs it."""
    commands.add_parser("serve", help="serve the page; options are those of `panel serve`, such as --show and --port")
