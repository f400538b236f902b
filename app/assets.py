"""Addresses of scripts and styles. Each has a hash of its content, so a browser requests a version only once.

A browser caches such a file for a year (app/web.py). Modules import each other by plain names; the import map of the
page has their addresses. All addresses are relative to the page, so a proxy may add any prefix.
"""

import gzip
import hashlib
from functools import lru_cache
from pathlib import Path

HERE = Path(__file__).parent
STATIC, PAGES = HERE / "static", HERE / "pages"


def assets(page):
    """Return {address: address with version} of every script, style and stored run, for the page at this address."""
    folder = page.rstrip("/").rsplit("/", 1)[-1]
    kinds = (".js", ".css", ".bin")
    found = [path for path in STATIC.rglob("*") if path.suffix in kinds] + [*PAGES.glob("*/page.js")]
    names = {path: f"./{folder}/{path.relative_to(HERE).as_posix()}" for path in sorted(found)}
    return {name: f"{name}?v={content(path, path.stat().st_mtime_ns)[2]}" for path, name in names.items()}


@lru_cache(200)
def content(path, changed):
    """Return (content, compressed content, hash) of a file; changed: its time of modification, for the cache."""
    raw = path.read_bytes()
    return raw, gzip.compress(raw, 9, mtime=0), hashlib.sha256(raw).hexdigest()[:16]
