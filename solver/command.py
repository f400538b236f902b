"""What the commands share: what is given to them, what they show while they work, and how they end."""

import argparse
import os
from pathlib import Path

from .profile import ProfileError, read_profile
from .scene import CHOICES, PARAMETERS, Scene
from .text import number_from_text, scene_from_text

NOT_CONVERGED, BAD_INPUT, INTERRUPTED = 1, 2, 130  # exit codes
FILES = ("csv", "npz", "json", "html")  # options that name a file to be written


class InputError(ValueError):
    """Bad input on the command line; the message is one line that names it and says what is allowed."""


def add_command(commands, name, run, said, text, epilog=""):
    """Adds the subcommand run(arguments) -> exit code, of a scene that --set gives, and returns its parser."""
    parser = commands.add_parser(
        name,
        help=said,
        description=text,
        epilog=parameter_table() + epilog,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    setting = {"nargs": "+", "action": "extend", "default": [], "metavar": "NAME=VALUE"}
    parser.add_argument("--set", **setting, help="parameters, listed below")
    parser.set_defaults(command=run)
    return parser


def add_file(parser, option, what, **how):
    """Adds --option FILE, one of FILES."""
    parser.add_argument(f"--{option}", metavar="FILE", help=f"write {what}", **how)


def add_scheduler(parser):
    """Adds --scheduler."""
    said = "compute on a dask cluster, tcp://host:8786, whose workers have this version and one thread each"
    parser.add_argument("--scheduler", metavar="ADDRESS", help=said)


def parameter_table():
    """Every parameter with its range, default, unit and meaning, as text."""
    lines = ["parameters:"]
    for name, known in PARAMETERS.items():
        if name in CHOICES:
            span = " | ".join(known.choices)
            meaning = f"{known.meaning}; " + "; ".join(f"{word}: {what}" for word, what in known.choices.items())
        else:
            span, meaning = known.span, known.meaning
        lines.append(f"  {name:<11} {span}, default {getattr(Scene, name):{'' if name in CHOICES else 'g'}}: {meaning}")
    lines += ["  profile     a file of x, z in nm for surface=measured, over all its length or over the width given"]
    return "\n".join(lines)


def scene_of(texts):
    """The Scene of {'name': 'text'}, where profile=FILE reads a measured surface; raises SceneError or InputError."""
    file, notes, profile = texts.pop("profile", None), [], None
    if file is not None:
        width = number_from_text("width", texts["width"]) if "width" in texts else None
        try:
            profile = read_profile(Path(file), width)
        except ProfileError as error:
            raise InputError(f"profile = {file!r}: {error}") from None
    scene = scene_from_text(texts, profile, notes)
    for note in notes:
        print(note)
    return scene


def settings(pairs):
    """{'name': 'text'} from NAME=VALUE arguments; raises InputError."""
    texts = {}
    for pair in pairs:
        name, equals, text = pair.partition("=")
        if not equals:
            raise InputError(f"--set {pair}: give NAME=VALUE, NAME one of {', '.join([*PARAMETERS, 'profile'])}")
        texts[name.strip()] = text.strip()
    return texts


def check_writable(arguments):
    """Raises InputError where one of the FILES cannot be written; leaves what is there as it is."""
    for option in FILES:
        file = getattr(arguments, option, None)
        if file is None:
            continue
        new = not os.path.lexists(file)
        try:
            with open(file, "ab"):
                pass
        except (OSError, ValueError) as error:  # ValueError: a null character in the name
            reason = getattr(error, "strerror", None) or error
            allowed = "allowed: a writable file in an existing directory"
            raise InputError(f"--{option} {file!r}: {reason}; {allowed}") from None
        if new:
            os.remove(file)


def write(file, writer, *given):
    """Has writer(file, *given) write a file, if one is named; raises InputError where it cannot."""
    if file is not None:
        try:
            writer(file, *given)
        except OSError as error:
            raise InputError(f"Writing the results failed: {error}; name a file where there is room") from None


def progress(total, unit):
    """A bar of one line that wipes itself, on a terminal only."""
    from tqdm import tqdm  # which a caller of functions does not need

    return tqdm(total=total, unit=unit, leave=False, disable=None)
