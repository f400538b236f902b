"""Addresses of scripts, styles and stored runs: ./app/VERSION/NAME, where VERSION is a hash of all these files.

NAME is that of a file below `static` or `features`, or of one that is MADE: STYLE, all styles, and the scripts of
app/modules.py. A browser caches such an address for a year (app/web.py). Scripts import each other relatively, so they
come from the same version. All addresses
are relative to the page, so a proxy may add any prefix. Files are read once: a server shows changed ones after its next
start.
"""

import gzip
import hashlib
import re
from collections.abc import Callable
from functools import cache
from pathlib import Path, PurePosixPath
from posixpath import normpath

from app import interface

HERE = Path(__file__).parent
STATIC = HERE / "static"
STYLE = "static/all.css"
MADE: dict[str, Callable[[], str]] = {}  # {name: what makes its text}
MAIN, SCRIPT = "static/js/main.js", "features/{}/index.js"
SERVED = {".js", ".html", ".bin"}  # endings of files of features that a browser may request
IMPORT = re.compile(r'(?:\bfrom|^import) "(\.[^"]+)"', re.M)  # of what a script needs at once


def root(page: str) -> str:
    """Return the address of this folder's current version, relative to the page at this address."""
    return f"./{page.rstrip('/').rsplit('/', 1)[-1]}/{version()}"


@cache
def files() -> dict[str, Path]:
    """Return {name: path} of all files that a browser may request."""
    found = {path.relative_to(HERE).as_posix(): path for path in STATIC.rglob("*.*")}
    for feature in interface.classes():
        folder = interface.folder(feature)
        inner = [path for path in folder.rglob("*.*") if path.suffix in SERVED]
        found |= {f"features/{feature}/{path.relative_to(folder).as_posix()}": path for path in inner}
    return dict(sorted(found.items()))


@cache
def version() -> str:
    """Return a hash of all files that a browser may request."""
    tree = hashlib.sha256()
    for name in [*files(), STYLE]:
        tree.update(f"{name} {content(name)[2]}\n".encode())
    return tree.hexdigest()[:16]


def style() -> str:
    """Return the styles of the core, then those of features in their order."""
    own = [path for name, path in files().items() if name.endswith(".css")]
    return "".join(path.read_text(encoding="utf-8") for path in [*own, *interface.files("style.css")])


MADE[STYLE] = style


def scripts(kind: str = interface.PAGE) -> list[str]:
    """Return the names of the scripts of features, in their order; kind: as of `interface.used`."""
    return [name for name in map(SCRIPT.format, interface.used(kind)) if name in files()]


def needed(*scripts: str) -> set[str]:
    """Return the names of scripts with all that they import at once."""
    found, left = set(), set(scripts)
    while left:
        name = left.pop()
        found.add(name)
        left |= {imported(name, each) for each in IMPORT.findall(text(name))} - found
    return found


def preloaded() -> list[str]:
    """Return the names of all scripts that the page needs at once, in the order in which they are run."""
    return list(dict.fromkeys(name for script in (MAIN, *scripts()) for name in sorted(needed(script))))


def imported(by: str, name: str) -> str:
    """Return the name of the script that the script `by` imports as `name`."""
    return normpath((PurePosixPath(by).parent / name).as_posix())


def text(name: str) -> str:
    """Return the text of a file by its name."""
    return content(name)[0].decode()


def hashed(raw: bytes) -> str:
    """Return a hash of a content, as it stands in an address."""
    return hashlib.sha256(raw).hexdigest()[:16]


@cache
def content(name: str | Path) -> tuple[bytes, bytes, str]:
    """Return (content, compressed content, hash) of a name, or of a path of another package."""
    if name in MADE:
        raw = MADE[str(name)]().encode()
    else:
        raw = (name if isinstance(name, Path) else files()[name]).read_bytes()
    return raw, gzip.compress(raw, 9, mtime=0), hashed(raw)
