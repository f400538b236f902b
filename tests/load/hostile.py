"""Strangers: random and mutated messages from several clients, while visitors work.

`python tests/load/hostile.py --messages 10000 [--clients 5] [--visitors 3] [--flood] [--seed 0]` starts the server
itself, on loopback, and is bounded by its number of messages. Orders are those that the session declares, with values
that fit, or nearly. `--flood` sends valid orders and the longest messages. Before, it requests addresses that Panel and
Bokeh would serve, and sends halves of long requests. Afterwards silent connections fill the server. It prints
tracebacks, memory, the lag of the server's loop, whether every visitor's runs came to their end, and when a place is
free again. It exits with 1 if a traceback was logged, a visitor is stuck, silence keeps others out, or an address that
is not listed was answered.
"""

import argparse
import asyncio
import base64
import gzip
import http.client
import json
import random
import socket
import sys
import time
from contextlib import suppress
from pathlib import Path
from urllib.error import HTTPError

sys.path.insert(0, str(Path(__file__).parents[2]))

from client import Server, Tab, summary, tell
from tornado.websocket import WebSocketClosedError

from app import interface
from app.environment import VISITORS
from app.experiment import Experiment
from app.features.files import feature as files
from app.features.lesson import feature as lesson
from app.features.share.feature import FORMATS
from app.session import orders
from app.session.pursuit import Pursuit

PAUSE = 0.002  # s between two messages
LONGEST = 60.0  # s of an attack: the server lets its messages wait
ODD = [None, True, -1, 0, 1e308, -1e-308, 10**9, 2**70, "", "nan", "inf", "x" * 70, "1,5", "−3", [], {}, [1], {"a": 1},
       "<b>", "\ud800", "0x10", "1e999", [[[]]]]  # fmt: skip
FITTING = {  # by the test of a field: values of which some pass
    orders.is_text: ["law", "load", "sweep", "cancel", "clear", "ABCD"],
    orders.is_link: ["x" * 1200, "E,phi_ratio"],
    orders.is_content: [b"x,z\n1,2\n"],
    orders.is_number: [0.5, 1, 60, 300.0],
    orders.is_whole: [1, 5, 1_000_001],
    orders.is_flag: [True, False],
    orders.are_entries: [{"E": "80"}, {"delta_bar": 0.3}, {"nodes": 64, "path": "loop"}, {"__class__": "1"}],
    orders.is_address: [{}, {"preset": "fig9"}, {"preset": "fig99", "E": "70"}],
    files.is_kind: ["", "surface", "load"],
    files.are_columns: [{"x": 0, "z": 1}, {"U_x": 1, "F": 99}],
    files.are_units: [{"x": "nm", "z": "0.5 um"}, {"F": "N/m"}],
    files.are_signs: [{"L": -1}],
    files.is_part: [[0.2, 0.5]],
    files.are_stages: [["approach", "shear"], ["none"]],
    FORMATS.__contains__: list(FORMATS),
    lesson.PHASES.__contains__: list(lesson.PHASES),
    lesson.ASKED.__contains__: list(lesson.ASKED),
    lesson.ROLES.__contains__: list(lesson.ROLES),
}


PARTS = Experiment, Pursuit, *interface.classes().values()
ORDERS = {name: getattr(part, method).order for part in PARTS for name, method in orders.declared(part).items()}


def order(dice, odd=0.3):
    """An order that exists, with its fields; each value is an odd one with probability `odd`."""
    name = dice.choice([*ORDERS, "close"] if odd else [*ORDERS])
    kind = ORDERS.get(name, ORDERS["page"])
    tests = kind.needs | kind.takes
    fields = {field: dice.choice(ODD if dice.random() < odd else FITTING[test]) for field, test in tests.items()}
    made = {"do": name, "n": dice.choice([*ODD, 7]) if dice.random() < odd else dice.randrange(10**6)}
    if dice.random() < odd / 3:
        fields[dice.choice(["E", "values", "do"])] = dice.choice(ODD)
    return made | fields


def mutated(content, dice):
    """The JSON of a message's content with a few characters changed, cut or doubled."""
    text = list(json.dumps(content))
    for _ in range(dice.randrange(1, 5)):
        k = dice.randrange(len(text))
        text[k : k + dice.randrange(3)] = dice.choice(['"', "{", "[" * 50, "}", "9" * 30, "\\u0000", "é", ""])
    return "".join(text)


UNLISTED = [  # addresses that `panel serve` answers, and this server does not
    *("/components/venv.__main__/a/b/c", "/components/this/a/b/c", "/app/autoload.js?bokeh-autoload-element=1"),
    *("/app/metadata", "/rest/", "/admin", "/login", "/favicon.ico", "/static/js/types.js", "/static/extensions/x/y"),
    *("/static/extensions/panel/panel.json", "/app/static/%00", "/app/static/../main.py", "/app/static/%2e%2e/web.py"),
]
BOMB = base64.b64encode(gzip.compress(bytes(10**7))).decode()


def event(tab, dice):
    """A patch that no page of ours sends."""
    wire = {"id": tab.wire}
    div = {"type": "object", "name": "Div", "id": "x1", "attributes": {"text": "x" * 5000}}
    return dice.choice(
        [
            {"kind": "ModelChanged", "model": wire, "attr": "piece", "new": {"type": "bytes", "data": BOMB}},
            {"kind": "ModelChanged", "model": wire, "attr": "name", "new": "mine"},
            {"kind": "ModelChanged", "model": wire, "attr": "scene", "new": dice.choice(ODD)},
            {"kind": "ModelChanged", "model": wire, "attr": "vote", "new": {"type": "map", "entries": [[[], {}]]}},
            {"kind": "ModelChanged", "model": {"id": "p1001"}, "attr": "title", "new": "mine"},
            {"kind": "RootAdded", "model": div},
            {"kind": "RootAdded", "model": {"type": "object", "name": "os.system", "id": "x2"}},
            {"kind": "TitleChanged", "title": "mine"},
            {"kind": "ColumnDataChanged", "model": wire, "attr": "data", "data": {}, "cols": []},
            {"kind": "MessageSent", "msg_type": "bokeh_event", "msg_data": {"event_name": "tap"}},
            dice.choice(ODD),
        ]
    )  # fmt: skip


def answered(port):
    """Return {address: status} of the addresses in UNLISTED that are not answered with 404."""
    found = {}
    for address in UNLISTED:
        connection = http.client.HTTPConnection("127.0.0.1", port, timeout=30)
        connection.request("GET", address)
        found[address] = connection.getresponse().status
        connection.close()
    return {address: status for address, status in found.items() if status != 404}


async def speak(tab, dice):
    """One message."""
    kind = dice.random()
    if kind < 0.6:
        await tab.send("PATCH-DOC", tab.patch(order(dice)))
    elif kind < 0.75:
        for part in (json.dumps({"msgid": "1", "msgtype": "PATCH-DOC"}), "{}", mutated(tab.patch(order(dice)), dice)):
            await tab.socket.write_message(part)
    elif kind < 0.9:
        await tab.send("PATCH-DOC", {"events": [event(tab, dice) for _ in range(dice.randrange(1, 4))]})
    elif kind < 0.93:
        await tab.send(dice.choice(["PUSH-DOC", "OK", "ERROR", "ACK", "NONE"]), {"doc": {}})
    elif kind < 0.96:
        await tab.socket.write_message(mutated({"msgid": "1", "msgtype": "PATCH-DOC", "num_buffers": 1}, dice))
    elif kind < 0.97:
        await tab.socket.write_message(bytes(dice.randrange(1000)), binary=True)
    else:
        await tab.socket.write_message("[" * dice.randrange(1, 100_000))


async def flood(tab, dice):
    """One message that costs the server what a message may: a valid order, or the longest that it reads."""
    if dice.random() < 0.8:
        await tab.send("PATCH-DOC", tab.patch(order(dice, odd=0.0)))
    else:
        await tab.send("PATCH-DOC", tab.patch({"do": "scene", "values": [[] for _ in range(4000)]}))
        await tab.send("PATCH-DOC", {"events": [[] for _ in range(dice.choice([2_000, 1_000_000]))]})


def half_sent(server, number=4, size=80_000_000):
    """Return MB of the server before and during requests whose bodies have not come to their end."""
    before, sockets = server.memory(), []
    for _ in range(number):
        sockets.append(socket.create_connection(("127.0.0.1", server.port)))
        head = f"POST /app HTTP/1.1\r\nHost: localhost\r\nContent-Length: {size + 1}\r\n\r\n"
        with suppress(ConnectionError):
            sockets[-1].sendall(head.encode() + bytes(size))
    during = server.memory()
    for connection in sockets:
        connection.close()
    return round(before, 1), round(during, 1)


async def silent(port, most=120.0):
    """Return (silent connections that fill the server, s until a page opens again, or None within `most` s).

    The time counts from the first connection, as the first one ends first.
    """
    tabs, start = [Tab(port, number) for number in range(VISITORS)], time.monotonic()
    for tab in tabs:
        with suppress(HTTPError):  # visitors are here: the server is full before
            await tab.connect()
    seconds = await opened(Tab(port, 0).connect, most)
    return sum(hasattr(tab, "socket") for tab in tabs), seconds and round(time.monotonic() - start, 1)


async def opened(arrive, most=120.0):
    """Return the s that the first arrival took which succeeded; None if none did for `most` s."""
    until = time.monotonic() + most
    while (start := time.monotonic()) < until:
        try:
            await arrive()
        except HTTPError:
            await asyncio.sleep(1.0)
        else:
            return time.monotonic() - start
    return None


async def stranger(port, number, count, seed, say):
    """Sends its messages, coming back whenever it is thrown out; how often it was."""
    dice, thrown, tab = random.Random(1000 * seed + number), 0, None
    drain = None
    until = time.monotonic() + LONGEST
    for _ in range(count):
        if time.monotonic() > until:
            break
        try:
            if tab is None:
                tab = Tab(port, number)
                await tab.arrive()
                drain = asyncio.create_task(listen(tab))
            await say(tab, dice)
            await asyncio.sleep(PAUSE)  # else it hears that it was thrown out a hundred messages later
        except (ConnectionError, HTTPError, WebSocketClosedError):
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
    """MB of memory, but for runs that are kept, every 5 s."""
    rows = []
    while not over.is_set():
        told = await asyncio.to_thread(server.metrics)
        rows.append(round((told["memory_bytes"] - told["cache_bytes"]) / 1e6))
        await asyncio.sleep(5.0)
    return rows


def later(before, after):
    """{s: part of the server's beats that came later than that} between two answers of /metrics."""
    beats = after["loop_lag_seconds_count"] - before["loop_lag_seconds_count"]
    edges = {edge: f'loop_lag_seconds_bucket{{le="{edge}"}}' for edge in ("0.05", "0.1", "0.2", "0.5", "1.0")}
    return {edge: round(1.0 - (after[name] - before[name]) / beats, 4) for edge, name in edges.items()}


async def attack(server, options):
    over = asyncio.Event()
    lag, watch = asyncio.create_task(server.lag(over)), asyncio.create_task(watched(server, over))
    visitors = [asyncio.create_task(visitor(server.port, k, over)) for k in range(options.visitors)]
    await asyncio.sleep(5.0)
    quiet, memory, start = server.metrics(), server.memory(), time.monotonic()
    unlisted = await asyncio.to_thread(answered, server.port)
    bodies = await asyncio.to_thread(half_sent, server)
    share, say = options.messages // options.clients, flood if options.flood else speak
    thrown = await asyncio.gather(*(stranger(server.port, k, share, options.seed, say) for k in range(options.clients)))
    seconds, told = time.monotonic() - start, server.metrics()
    places = await silent(server.port)
    last = Tab(server.port, 99)
    after = await opened(last.arrive)  # others may still be silent
    start = time.perf_counter()
    await last.order("hello")
    after += time.perf_counter() - start
    over.set()
    seen = await asyncio.gather(*visitors)
    return {
        "messages": share * options.clients,
        "seconds": round(seconds, 1),
        "thrown out": sum(thrown),
        "unlisted, but answered": unlisted,
        "tracebacks": server.tracebacks(),
        "lines logged": len(server.lines),
        "memory before, during half-sent bodies": bodies,
        "memory before, after": (round(memory), round(server.memory())),
        "of runs that are kept": (round(quiet["cache_bytes"] / 1e6), round(told["cache_bytes"] / 1e6)),
        "beats later than, s": later(quiet, told),
        "answers": summary(await lag),
        "MB every 5 s": await watch,
        "visitors' runs": summary([time for times, _ in seen for time in times]),
        "visitors stuck": [why for _, why in seen if why],
        "silent connections, s until a place is free": places,
        "a visit afterwards": round(after, 2),
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--messages", type=int, default=10_000, help="at most 100,000")
    parser.add_argument("--clients", type=int, default=5)
    parser.add_argument("--visitors", type=int, default=3)
    parser.add_argument("--flood", action="store_true", help="valid orders and the longest messages")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--json", help="file for what was measured")
    options = parser.parse_args()
    options.messages = min(options.messages, 100_000)
    with Server(VISITORS) as server:
        report = asyncio.run(attack(server, options))
        if report["tracebacks"]:
            print("".join(line for line in server.lines if "Traceback" in line))
    tell(report, options.json)
    full, free = report["silent connections, s until a place is free"]
    bad = any(report[name] for name in ("tracebacks", "visitors stuck", "unlisted, but answered"))
    sys.exit(bad or full < VISITORS // 2 or free is None)


if __name__ == "__main__":
    main()
