"""The environment variables of the server, checked when it starts. An invalid one ends it with one sentence."""

import os
import re
from collections.abc import Iterable
from importlib.util import find_spec
from typing import Any

SITES = re.compile(r"'self'|'none'|(https?://)?[\w*][\w.*-]*(:\d+)?")  # each site of a Content-Security-Policy
SCHEDULER = re.compile(r"(tcp|tls)://[\w.:\[\]-]+:\d+")


def whole(name: str, most: int, default: int | None = None) -> Any:
    """Return a whole number from 1 to `most`, or the default if the variable is not set."""
    text = os.environ.get(name, "")
    if not text:
        return default
    if re.fullmatch(r"[0-9]{1,9}", text) and 1 <= int(text) <= most:
        return int(text)
    raise SystemExit(f"{name} is {text!r}. Set it to a whole number from 1 to {most}, or leave it out.")


def sites(name: str, default: str) -> str:
    """Return sites of a Content-Security-Policy, separated by spaces."""
    text = os.environ.get(name, "") or default
    if all(map(SITES.fullmatch, text.split(" "))):
        return text
    raise SystemExit(f"{name} is {text!r}. Set it to sites, separated by spaces: https://school.example.")


def scheduler(name: str) -> str | None:
    """Return the address of a dask scheduler, or None if the variable is not set."""
    text = os.environ.get(name, "")
    if not text:
        return None
    if not SCHEDULER.fullmatch(text):
        raise SystemExit(f"{name} is {text!r}. Set it to tcp://host:port or tls://host:port, or leave it out.")
    if find_spec("distributed") is None:
        raise SystemExit(f'{name} needs dask. Run pip install "mixed-mode-contact[cluster]", or leave {name} out.')
    return text


def chosen(name: str, known: Iterable[str]) -> set[str]:
    """Return those of the known names that are chosen: `all`, `none`, or all but some, `-lab -lesson`."""
    text, names = os.environ.get(name, "") or "all", set(known)
    left_out = {word[1:] for word in text.split() if word.startswith("-")}
    if text in ("all", "none"):
        return names if text == "all" else set()
    if left_out and left_out <= names and len(left_out) == len(set(text.split())):
        return names - left_out
    raise SystemExit(
        f"{name} is {text!r}. Set it to all, none or names to leave out, as in -{min(names)}:"
        f" {', '.join(sorted(names))}."
    )


VISITORS = whole("APP_VISITORS", 10_000, 60)  # connected at a time
WORKERS = whole("APP_WORKERS", 1000)  # processes that compute; None: by the number of cores
FRAMES = sites("APP_FRAME_ANCESTORS", "'self'")  # may embed ?embed=1 in a frame
CLUSTER = scheduler("APP_SCHEDULER")  # address of a dask scheduler, or None
