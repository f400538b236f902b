"""Copies of the repository that have some of its features only."""

import shutil
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

from app import interface

ROOT = Path(__file__).parents[2]
LEFT_OUT = shutil.ignore_patterns(".*", "build", "dist", "*.egg-info")  # __pycache__ has the compiled kernels
NAMES = sorted(interface.found())


def needed(name):
    """A feature with all that it needs."""
    return {name}.union(*map(needed, interface.needed(name)))


@contextmanager
def copy_with(features):
    """A copy of the repository in which the folders of all other features, and of their tests, are deleted."""
    with TemporaryDirectory() as place:
        folder = Path(place, "copy")
        shutil.copytree(ROOT, folder, ignore=LEFT_OUT)
        for name in set(NAMES) - set(features):
            shutil.rmtree(folder / "app" / "features" / name)
            shutil.rmtree(folder / "tests" / "features" / name, ignore_errors=True)
        yield folder


def copy_without(name):
    """A copy of the repository without a feature, and without those that need it."""
    return copy_with([other for other in NAMES if name not in needed(other)])
