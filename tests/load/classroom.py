"""What a class feels: visitors who look at presets and move sliders, some with the dearest scenes, workers that die.

`python tests/load/classroom.py --visitors 30 --seconds 60 [--drag] [--heavy 2] [--kill 3] [--json FILE]` starts the
server itself, on loopback. Visitors arrive within 30 s (less for fewer), think 2 to 5 s, and half of their moves are
presets; the others set a slider or, with --drag, drag one for one to two seconds, as people do. Times are from the
order to the arrival of the first and of the last frames, of a drag from its first move to the first picture and from
letting go to the last frames. Cold arrivals are counted apart.
"""

import argparse
import asyncio
import os
import random
import signal
import time
from collections import Counter
from contextlib import suppress

from client import Server, Tab, summary, tell

from app.session.controls import CONTROLS

PRESETS = ("fig6", "fig7-case1", "fig7-case2", "fig7-case3")
DEAREST = {"E": 10.0, "delta_bar": 1.0, "damping": 0.2}
THINK = 2.0, 5.0  # s
PACE = 0.05  # s between two moves of a hand


async def visit(port, number, options, found):
    """One visitor, from arrival until the lesson is over."""
    tab, end = Tab(port, number), time.monotonic() + options.seconds
    try:
        await asyncio.sleep(min(0.6 * options.visitors, 30.0, 0.5 * options.seconds) * tab.random.random())
        start = time.perf_counter()
        await tab.arrive(f"?E={tab.random.uniform(60, 80):.4f}")
        found["page"].append(time.perf_counter() - start)
        record(found, await tab.order("hello"), "first visit")
        while time.monotonic() < end:
            await asyncio.sleep(tab.random.uniform(*THINK))
            if tab.random.random() < 0.5:
                record(found, await tab.order("restore", preset=tab.random.choice(PRESETS)))
            elif options.drag:
                await drag(tab, found)
            else:
                record(found, await tab.order("scene", delta_bar=round(tab.random.uniform(-1.0, 1.0), 3)))
    except Exception as error:
        found["errors"].append(f"{type(error).__name__}: {error}")
    finally:
        with suppress(Exception):
            tab.leave()


async def drag(tab, found):
    """Move one slider for a while, by some of its positions, and let go."""
    control = tab.random.choice(CONTROLS)
    name, last, value = control.name, len(control.positions) - 1, tab.status["values"][control.name]
    here = min(range(last + 1), key=lambda k: abs(control.positions[k] - value))
    way = 1 if here < 0.3 * last else -1 if here > 0.7 * last else tab.random.choice((-1, 1))
    places = [min(last, max(0, here + way * k)) for k in range(1, tab.random.randint(20, 40))]
    values = [control.positions[k] for k in places]
    first, exact, pictures, status = await tab.drag(name, values, PACE)
    found["drags"].append((first if first is not None else exact, exact))
    found["pictures"].append(pictures / (PACE * len(values)))
    if status["state"] != "finished":
        found["failed"].append(status["why"])


def record(found, outcome, where="moves"):
    first, whole, status = outcome
    found[where].append((first, whole))
    if status["state"] != "finished":
        found["failed"].append(status["why"])


async def hog(port, number, options, found):
    """A visitor with the dearest legal scene, again and again."""
    tab, end = Tab(port, 1000 + number), time.monotonic() + options.seconds
    try:
        await tab.arrive()
        while time.monotonic() < end:
            values = DEAREST | {"phi_ratio": round(tab.random.uniform(0.9, 1.1), 4)}
            *_, status = await asyncio.wait_for(tab.order("scene", **values), max(1.0, end - time.monotonic()))
            found["hogs"].append(status["why"])
    except (TimeoutError, ConnectionError) as error:
        found["hogs"].append(type(error).__name__)
    finally:
        with suppress(Exception):
            tab.leave()


async def killer(server, options, found):
    end = time.monotonic() + options.seconds
    while options.kill and time.monotonic() < end:
        await asyncio.sleep(options.kill)
        workers = server.workers()
        found["seats"].append(len(workers))
        if workers:
            with suppress(ProcessLookupError):
                os.kill(random.choice(workers), signal.SIGKILL)


async def lesson(server, options):
    """Everything measured, as a dictionary."""
    names = ("page", "first visit", "moves", "drags", "pictures", "errors", "failed", "hogs", "seats")
    found, over = {name: [] for name in names}, asyncio.Event()
    lag = asyncio.create_task(server.lag(over))
    before, start = server.processor_time(), time.monotonic()
    computed, known = sum(map(server.processor_time, server.workers())), server.metrics()
    work = [visit(server.port, k, options, found) for k in range(options.visitors)]
    work += [hog(server.port, k, options, found) for k in range(options.heavy)]
    await asyncio.gather(*work, killer(server, options, found))
    over.set()
    report = {"visitors": options.visitors, "heavy": options.heavy, "kill": options.kill, "runs": len(found["moves"])}
    report["page"] = summary(found["page"])
    for name, where in (("", "moves"), ("drags: ", "drags"), ("first visit: ", "first visit")):
        report[f"{name}first frames"] = summary([first for first, _ in found[where]])
        report[f"{name}whole run"] = summary([whole for _, whole in found[where]])
    report["pictures a second"] = summary(found["pictures"])
    report["loop lag"] = summary(await lag)
    report["server"] = round((server.processor_time() - before) / (time.monotonic() - start), 3)
    if not options.kill:  # what limits a machine that has nothing else to do
        new, now = sum(map(server.processor_time, server.workers())) - computed, server.metrics()
        runs = now["run_cache_misses_total"] - known["run_cache_misses_total"]
        report |= {"runs computed": round(runs), "s of workers per run": round(new / max(1, runs), 3)}
    report |= {"memory": round(server.memory()), "tracebacks": server.tracebacks()}
    report |= {"errors": found["errors"], "failed": dict(Counter(found["failed"])), "hogs": sorted(set(found["hogs"]))}
    if options.kill:
        end = time.monotonic() + 20.0
        while len(server.workers()) < max(found["seats"], default=0) and time.monotonic() < end:
            await asyncio.sleep(0.2)
        report["kills"], report["seats after"] = len(found["seats"]), len(server.workers())
    report["load"], report["cores"] = round(os.getloadavg()[0], 1), os.cpu_count()
    return report


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--visitors", type=int, default=30, help="at most 200")
    parser.add_argument("--seconds", type=float, default=60.0, help="at most 600")
    parser.add_argument("--drag", action="store_true", help="sliders are dragged, not set")
    parser.add_argument("--heavy", type=int, default=0, help="visitors more, with the dearest legal scene")
    parser.add_argument("--kill", type=float, default=0.0, help="s between two kills of a worker")
    parser.add_argument("--json", help="file for what was measured")
    options = parser.parse_args()
    options.visitors, options.seconds = min(options.visitors, 200), min(options.seconds, 600.0)
    with Server() as server:
        report = asyncio.run(lesson(server, options))
    tell(report, options.json)


if __name__ == "__main__":
    main()
