"""What it costs the server that a class opens the page: pages asked for and drawn, with their websockets.

`python tests/load/arrivals.py --pages 100 --within 60 [--json FILE]` starts the server itself, on loopback, and lets
visitors arrive evenly; each stays. Times are until the document is here, the cost is the server's processor time.
"""

import argparse
import asyncio
import os
import time
from contextlib import suppress

from client import Server, Tab, summary, tell


async def arrive(port, number, wait, found):
    """One visitor, who comes after `wait` seconds."""
    tab = Tab(port, number)
    await asyncio.sleep(wait)
    start = time.perf_counter()
    try:
        await tab.arrive(f"?E={70 + number}")
        found["times"].append(time.perf_counter() - start)
        found["bytes"].append(tab.bytes)
    except Exception as error:
        found["errors"].append(f"{type(error).__name__}: {error}")
    return tab


async def arrivals(server, options):
    """Everything measured, as a dictionary."""
    found, over = {"times": [], "bytes": [], "errors": []}, asyncio.Event()
    first = await arrive(server.port, -1, 0.0, {name: [] for name in found})  # what is made once is made now
    lag = asyncio.create_task(server.lag(over))
    start, before = time.monotonic(), server.processor_time()
    waits = [k * options.within / options.pages for k in range(options.pages)]
    tabs = await asyncio.gather(*(arrive(server.port, k, wait, found) for k, wait in enumerate(waits)))
    spent, seconds = server.processor_time() - before, time.monotonic() - start
    over.set()
    lags = summary(await lag)
    before, start = server.processor_time(), time.monotonic()
    await asyncio.sleep(3.0)  # what visitors cost who are just there
    idle = (server.processor_time() - before) / (time.monotonic() - start)
    for tab in (first, *tabs):
        with suppress(Exception):
            tab.leave()
    return {
        "pages": options.pages,
        "seconds": round(seconds, 1),
        "page": summary(found["times"]),
        "s of the server per page": round(spent / options.pages, 4),
        "part of a core, all idle": round(idle, 3),
        "kB by websocket": round(max(found["bytes"], default=0) / 1000),
        "loop lag": lags,
        "memory": round(server.memory()),
        "errors": found["errors"],
        "load": round(os.getloadavg()[0], 1),
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--pages", type=int, default=100, help="at most 300")
    parser.add_argument("--within", type=float, default=60.0, help="s, at most 600")
    parser.add_argument("--json", help="file for what was measured")
    options = parser.parse_args()
    options.pages, options.within = min(options.pages, 300), min(options.within, 600.0)
    with Server() as server:
        report = asyncio.run(arrivals(server, options))
    tell(report, options.json)


if __name__ == "__main__":
    main()
