"""Addresses of scripts and styles: each carries the hash of its content, so that a browser asks for it once only.

A browser keeps a file whose address has a version for a year (app/web.py). Modules import each other by plain names,
and the import map of the page has their addresses. All are relative to the page: a proxy may add any prefix.
"""

import gzip
import hashlib
from functools import lru_cache
from pathlib import Path

HERE = Path(__file__).parent
STATIC, PAGES = HERE / "static", HERE / "pages"


def assets(page):
    """{address: the same with its version} of every script, style and stored run, for the page at this address."""
    folder = page.rstrip("/").rsplit("/", 1)[-1]
    kinds = (".js", ".css", ".bin")
    found = [path for path in STATIC.rglob("*") if path.suffix in kinds] + [*PAGES.glob("*/page.js")]
    names = {path: f"./{folder}/{path.relative_to(HERE).as_posix()}" for path in sorted(found)}
    return {name: f"{name}?v={content(path, path.stat().st_mtime_ns)[2]}" for path, name in names.items()}


@lru_cache(200)
def content(path, changed):
    """(content, the same compressed, its hash) of a file as it was changed last at that time."""
    raw = path.read_bytes()
    return raw, gzip.compress(raw, 9, mtime=0), hashlib.sha256(raw).hexdigest()[:16]
