"""What it costs the server that a class opens the page: pages asked for and drawn, with their websockets.

`python tests/load/arrivals.py --pages 100 --within 60 [--json FILE]` starts the server itself, on loopback, and lets
visitors arrive evenly; each stays. Times are until the document is here, the cost is the server's processor time.
`--visits 1000` has so many come after that, compute two new scenes, open a page beside and leave: does memory grow?
"""

import argparse
import asyncio
import os
import time
from contextlib import suppress

from client import Server, Tab, summary, tell

from app.features.pages import feature as pages

TOGETHER = 4  # visits at a time
PAGES = "", *pages.listed()


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


async def visit(port, numbers, errors):
    """Visits one after the other, each of somebody who looks around and leaves."""
    for number in numbers:
        tab = Tab(port, number)
        try:
            await tab.arrive(f"?u_x_max=10&E={60 + 20 * tab.random.random():.6f}")
            await tab.order("hello")
            await tab.order("scene", delta_bar=round(tab.random.uniform(-1.0, 1.0), 6))
            await tab.order("page", page=PAGES[number % len(PAGES)])
            tab.leave()
        except Exception as error:
            errors.append(f"{type(error).__name__}: {error}")


async def memory_after(server, numbers, errors):
    """MB of the server but for runs that are kept, and MB of these, when the visits are over and forgotten."""
    numbers = iter(numbers)
    await asyncio.gather(*(visit(server.port, numbers, errors) for _ in range(TOGETHER)))
    while (told := await asyncio.to_thread(server.metrics))["visitors"]:
        await asyncio.sleep(1.0)
    return round((told["memory_bytes"] - told["cache_bytes"]) / 1e6), round(told["cache_bytes"] / 1e6)


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
    grown, few = {}, min(100, options.visits)
    for visits in (range(few), range(few, options.visits)) if few else ():
        grown[visits.stop] = await memory_after(server, visits, found["errors"])
    return {
        "pages": options.pages,
        "seconds": round(seconds, 1),
        "page": summary(found["times"]),
        "s of the server per page": round(spent / options.pages, 4),
        "part of a core, all idle": round(idle, 3),
        "kB by websocket": round(max(found["bytes"], default=0) / 1000),
        "loop lag": lags,
        "memory": round(server.memory()),
        "after visits: MB, runs kept": grown,
        "errors": found["errors"],
        "load": round(os.getloadavg()[0], 1),
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--pages", type=int, default=100, help="at most 300")
    parser.add_argument("--within", type=float, default=60.0, help="s, at most 600")
    parser.add_argument("--visits", type=int, default=0, help="at most 5000")
    parser.add_argument("--json", help="file for what was measured")
    options = parser.parse_args()
    options.pages, options.within = min(options.pages, 300), min(options.within, 600.0)
    options.visits = min(options.visits, 5000)
    with Server() as server:
        report = asyncio.run(arrivals(server, options))
    tell(report, options.json)


if __name__ == "__main__":
    main()
