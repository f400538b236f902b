"""What the commands share: what is given to them, what they show while they work, and how they end."""

import os
from contextlib import contextmanager
from pathlib import Path

from .profile import ProfileError, read_profile
from .scene import CHOICES, PARAMETERS, Scene
from .text import number_from_text, scene_from_text

NOT_CONVERGED, BAD_INPUT, INTERRUPTED = 1, 2, 130  # exit codes


class InputError(ValueError):
    """Bad input on the command line; the message is one line that names it and says what is allowed."""


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


def check_writable(option, file):
    """Raises InputError where the file of --option cannot be written; leaves what is there as it is."""
    if file is None:
        return
    new = not os.path.lexists(file)
    try:
        with open(file, "ab"):
            pass
    except (OSError, ValueError) as error:  # ValueError: a null character in the name
        reason = getattr(error, "strerror", None) or error
        raise InputError(f"--{option} {file!r}: {reason}; allowed: a writable file in an existing directory") from None
    if new:
        os.remove(file)


@contextmanager
def writing():
    """Raises InputError where what is done within cannot be written."""
    try:
        yield
    except OSError as error:
        raise InputError(f"Writing the results failed: {error}; name a file where there is room") from None


def progress(total, unit):
    """A bar of one line that wipes itself, on a terminal only."""
    from tqdm import tqdm  # which a caller of functions does not need

    return tqdm(total=total, unit=unit, leave=False, disable=None)
