"""Strangers: random and mutated messages from several clients, while visitors work.

`python tests/load/hostile.py --messages 10000 [--clients 5] [--visitors 3] [--seed 0] [--json FILE]` starts the server
itself, on loopback, and is bounded by its number of messages. It tells tracebacks, memory, the lag of the server's loop
and whether every visitor's runs came to their end, and exits with 1 where a traceback was logged or a visitor is stuck.
"""

import argparse
import asyncio
import base64
import gzip
import json
import random
import sys
import time
from contextlib import suppress

from client import Server, Tab, summary, tell

ODD = [None, True, -1, 0, 1e308, -1e-308, 10**9, 2**70, "", "nan", "inf", "x" * 70, "1,5", "−3", [], {}, [1], {"a": 1},
       "<b>", "\ud800", "0x10", "1e999", [[[]]]]  # fmt: skip
NAMES = ["E", "delta_bar", "nodes", "surface", "path", "du_x", "damping", "measured", "__class__", "profile", "seed"]
KINDS = ["scene", "hello", "pause", "go", "one", "reset", "preset", "page", "ask", "profile", "measure", "cancel",
         "close", "__init__", "tell", "", 3, None]  # fmt: skip
PAGES = ["law", "stickslip", "arealaws", "solid", "", "secret"]


def order(dice):
    """An order, more or less wrong."""
    kind = dice.choice(KINDS)
    values = {dice.choice(NAMES): dice.choice(ODD) for _ in range(dice.randrange(4))}
    if kind == "page":
        values = {"page": dice.choice([*PAGES, *ODD])}
    elif kind == "ask":
        names = ["run", "frame", "half", "quantity", "per_fringe", "mesh", "what", "series", "E", "phi_t"]
        said = [*ODD, 1, 0.5, "add", "show", "cancel", "normal"]
        values = {name: dice.choice(said) for name in names[: dice.randrange(11)]}
    elif kind == "preset":
        values = {"preset": dice.choice(["fig6", "fig99", *ODD])}
    elif kind == "profile":
        values = {"text": dice.choice(["x,z\n1,2\n", "," * 1000, *ODD])}
    made = {"do": kind, "values": dice.choice([values, values, values, dice.choice(ODD)]), "n": dice.choice([*ODD, 7])}
    if dice.random() < 0.4:
        made["from"] = dice.choice([[1, 10**9], [1, -5], [1, 3], "11", [1], [None, 1], [2**70, 0], [1, 0.5], *ODD])
    return json.dumps(made)


def mutated(text, dice):
    """The text with a few characters changed, cut or doubled."""
    text = list(text)
    for _ in range(dice.randrange(1, 5)):
        k = dice.randrange(len(text))
        text[k : k + dice.randrange(3)] = dice.choice(['"', "{", "[" * 50, "}", "9" * 30, "\\u0000", "é", ""])
    return "".join(text)


BOMB = base64.b64encode(gzip.compress(bytes(10**7))).decode()


def event(tab, dice):
    """A patch that no page of ours sends."""
    wire = {"id": tab.wire}
    div = {"type": "object", "name": "Div", "id": "x1", "attributes": {"text": "x" * 5000}}
    return dice.choice(
        [
            {"kind": "ModelChanged", "model": wire, "attr": "message", "new": {"type": "bytes", "data": BOMB}},
            {"kind": "ModelChanged", "model": wire, "attr": "status", "new": "{}"},
            {"kind": "ModelChanged", "model": wire, "attr": "order", "new": dice.choice(ODD)},
            {"kind": "ModelChanged", "model": {"id": "p1001"}, "attr": "title", "new": "mine"},
            {"kind": "RootAdded", "model": div},
            {"kind": "RootAdded", "model": {"type": "object", "name": "os.system", "id": "x2"}},
            {"kind": "TitleChanged", "title": "mine"},
            {"kind": "ColumnDataChanged", "model": wire, "attr": "data", "data": {}, "cols": []},
            {"kind": "MessageSent", "msg_type": "bokeh_event", "msg_data": {"event_name": "tap"}},
            dice.choice(ODD),
        ]
    )  # fmt: skip


async def say(tab, dice):
    """One message."""
    kind = dice.random()
    if kind < 0.6:
        await tab.send("PATCH-DOC", tab.patch(order(dice)))
    elif kind < 0.75:
        await tab.send("PATCH-DOC", tab.patch(mutated(order(dice), dice)))
    elif kind < 0.9:
        await tab.send("PATCH-DOC", {"events": [event(tab, dice) for _ in range(dice.randrange(1, 4))]})
    elif kind < 0.93:
        await tab.send(dice.choice(["PUSH-DOC", "OK", "ERROR", "ACK", "NONE"]), {"doc": {}})
    elif kind < 0.96:
        await tab.socket.write_message(mutated('{"msgid":"1","msgtype":"PATCH-DOC","num_buffers":1}', dice))
    elif kind < 0.97:
        await tab.socket.write_message(bytes(dice.randrange(1000)), binary=True)
    else:
        await tab.socket.write_message("[" * dice.randrange(1, 100_000))


async def stranger(port, number, count, seed):
    """Sends its messages, coming back whenever it is thrown out; how often it was."""
    dice, thrown, tab = random.Random(1000 * seed + number), 0, None
    drain = None
    for _ in range(count):
        try:
            if tab is None:
                tab = Tab(port, number)
                await tab.arrive()
                drain = asyncio.create_task(listen(tab))
            await say(tab, dice)
        except Exception:
            thrown, tab = thrown + 1, None
            drain and drain.cancel()
            await asyncio.sleep(0.1)
    if tab is not None:
        with suppress(Exception):
            tab.leave()
    return thrown


async def listen(tab):
    """Read, so that the server is not held up by what it has to send."""
    with suppress(Exception):
        while await tab.socket.read_message() is not None:
            pass


async def visitor(port, number, over):
    """Moves a slider until it is over: seconds of every run, or what went wrong."""
    tab, times = Tab(port, number), []
    try:
        await tab.arrive()
        await tab.order("hello")
        while not over.is_set():
            times.append((await tab.order("scene", delta_bar=round(tab.random.uniform(-1, 1), 3)))[1])
            await asyncio.sleep(1.0)
    except Exception as error:
        return times, f"{type(error).__name__}: {error}"
    return times, None


async def watched(server, over):
    """[(MB of memory but for runs that are kept, s by which the server's loop was late at most)] of every 5 s."""
    rows = []
    while not over.is_set():
        told = await asyncio.to_thread(server.metrics)
        rows.append((round((told["memory_bytes"] - told["shelf_bytes"]) / 1e6), round(told["loop_lag_seconds"], 3)))
        await asyncio.sleep(5.0)
    return rows


async def attack(server, options):
    over = asyncio.Event()
    lag, watch = asyncio.create_task(server.lag(over)), asyncio.create_task(watched(server, over))
    visitors = [asyncio.create_task(visitor(server.port, k, over)) for k in range(options.visitors)]
    await asyncio.sleep(5.0)
    memory, shelf, start = server.memory(), server.metrics()["shelf_bytes"] / 1e6, time.monotonic()
    share = options.messages // options.clients
    thrown = await asyncio.gather(*(stranger(server.port, k, share, options.seed) for k in range(options.clients)))
    seconds = time.monotonic() - start
    start = time.perf_counter()
    last = Tab(server.port, 99)
    await last.arrive()
    await last.order("hello")
    after = time.perf_counter() - start
    over.set()
    seen = await asyncio.gather(*visitors)
    return {
        "messages": share * options.clients,
        "seconds": round(seconds, 1),
        "thrown out": sum(thrown),
        "tracebacks": server.tracebacks(),
        "lines logged": len(server.lines),
        "memory before, after": (round(memory), round(server.memory())),
        "of runs that are kept": (round(shelf), round(server.metrics()["shelf_bytes"] / 1e6)),
        "answers": summary(await lag),
        "every 5 s: MB, loop lag": await watch,
        "visitors' runs": summary([time for times, _ in seen for time in times]),
        "visitors stuck": [why for _, why in seen if why],
        "a visit afterwards": round(after, 2),
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--messages", type=int, default=10_000, help="at most 100,000")
    parser.add_argument("--clients", type=int, default=5)
    parser.add_argument("--visitors", type=int, default=3)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--json", help="file for what was measured")
    options = parser.parse_args()
    options.messages = min(options.messages, 100_000)
    with Server() as server:
        report = asyncio.run(attack(server, options))
        if report["tracebacks"]:
            print("".join(line for line in server.lines if "Traceback" in line))
    tell(report, options.json)
    sys.exit(bool(report["tracebacks"] or report["visitors stuck"]))


if __name__ == "__main__":
    main()
