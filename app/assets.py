"""Addresses of scripts, styles and stored runs: ./app/VERSION/static/..., where VERSION is a hash of all these files.

A browser caches such an address for a year (app/web.py). Modules import each other relatively, so they come from the
same version. All addresses are relative to the page, so a proxy may add any prefix. Files are read once: a server shows
changed ones after its next start.
"""

import gzip
import hashlib
import re
from functools import cache
from pathlib import Path

HERE = Path(__file__).parent
STATIC, PAGES = HERE / "static", HERE / "pages"
IMPORT = re.compile(r'(?:\bfrom|^import) "(\.[^"]+)"', re.M)  # of what a script needs at once


def root(page: str) -> str:
    """Return the address of this folder's current version, relative to the page at this address."""
    return f"./{page.rstrip('/').rsplit('/', 1)[-1]}/{version()}"


@cache
def version() -> str:
    """Return a hash of all files that a browser requests."""
    tree = hashlib.sha256()
    for path in sorted([*STATIC.rglob("*.*"), *PAGES.glob("*/page.js")]):
        tree.update(f"{named(path)} {content(path)[2]}\n".encode())
    return tree.hexdigest()[:16]


def named(path: Path) -> str:
    """Return the name of a file below `root`."""
    return path.relative_to(HERE).as_posix()


def styles() -> list[str]:
    """Return the names of all styles."""
    return [named(path) for path in sorted(STATIC.glob("*.css"))]


def needed(script: Path) -> set[Path]:
    """Return a script with all scripts that it imports at once."""
    found, left = set(), {script}
    while left:
        path = left.pop()
        found.add(path)
        imported = IMPORT.findall(path.read_text(encoding="utf-8"))
        left |= {(path.parent / name).resolve() for name in imported} - found
    return found


@cache
def content(path: Path) -> tuple[bytes, bytes, str]:
    """Return (content, compressed content, hash) of a file."""
    raw = path.read_bytes()
    return raw, gzip.compress(raw, 9, mtime=0), hashlib.sha256(raw).hexdigest()[:16]
