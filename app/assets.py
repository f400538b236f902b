"""Addresses of scripts and styles: each carries the hash of its content, so that a browser asks for it once only.

The server gives a file with a version in its address for ten years (tornado.web.StaticFileHandler). Modules import each
other by plain names; the import map of the page says which address that is. All are relative to the address of the
page, so that they hold behind any prefix.
"""

import hashlib
from functools import cache
from pathlib import Path

STATIC = Path(__file__).parent / "static"


def assets(page):
    """{address: the same with its version} of every file under static/, for the page at this address."""
    folder = page.rstrip("/").rsplit("/", 1)[-1]
    files = sorted(path for path in STATIC.rglob("*") if path.suffix in (".js", ".css"))
    names = {path: f"./{folder}/static/{path.relative_to(STATIC).as_posix()}" for path in files}
    return {name: f"{name}?v={_version(path, path.stat().st_mtime_ns)}" for path, name in names.items()}


@cache
def _version(path, changed):
    return hashlib.sha256(path.read_bytes()).hexdigest()[:12]
