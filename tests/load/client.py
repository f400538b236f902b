"""A browser tab without the drawing: what the tools of this folder speak with the server; loopback only."""

import asyncio
import json
import os
import random
import re
import socket
import subprocess
import sys
import threading
import time
import urllib.error
import urllib.request
from contextlib import suppress
from pathlib import Path

from bokeh.core.serialization import Serializer
from bokeh.protocol import Protocol
from bokeh.protocol.receiver import Receiver
from tornado.httpclient import HTTPRequest
from tornado.websocket import websocket_connect

ROOT = Path(__file__).parent.parent.parent
PATIENCE = 60  # s; a limit against hanging
ENDS = ("finished", "failed")
READY = {"type": "event", "name": "document_ready", "values": {"type": "map"}}
READY = {"kind": "MessageSent", "msg_type": "bokeh_event", "msg_data": READY}


class Tab:
    """One visitor's connection."""

    def __init__(self, port, seed):
        self.port, self.random = port, random.Random(seed)
        self.receiver = Receiver(Protocol())
        self.sent, self.orders, self.bytes = 0, 0, 0
        self.status = {}

    async def arrive(self, query=""):
        """Load the page, connect, and find the model through which everything passes."""
        await self.connect(query)
        await self.message("ACK")
        await self.send("PULL-DOC-REQ", {})
        reply = await self.message("PULL-DOC-REPLY")
        self.wire = wire_of(reply.content["doc"])
        await self.send("PATCH-DOC", {"events": [READY]})

    async def connect(self, query=""):
        """Load the page and connect, without a word."""
        address = f"http://127.0.0.1:{self.port}/app{query}"
        page = await asyncio.to_thread(lambda: urllib.request.urlopen(address, timeout=PATIENCE).read().decode())
        token = re.search(r'"token":"([^"]+)"', page)[1]
        origin = f"http://localhost:{self.port}"
        headers = {"Sec-WebSocket-Protocol": f"bokeh, {token}", "Origin": origin}
        request = HTTPRequest(f"ws://127.0.0.1:{self.port}/app/ws", headers=headers)
        self.socket = await websocket_connect(request, subprotocols=["bokeh", token], max_message_size=2**28)
        self.socket.protocol.set_nodelay(True)  # as browsers do

    async def send(self, kind, content):
        self.sent += 1
        for part in ({"msgid": f"{self.sent}", "msgtype": kind}, {}, content):
            await self.socket.write_message(json.dumps(part, separators=(",", ":")))

    async def message(self, kind=None):
        """The next whole message, of that kind."""
        while True:
            fragment = await asyncio.wait_for(self.socket.read_message(), PATIENCE)
            if fragment is None:
                raise ConnectionError("the server closed the connection")
            self.bytes += len(fragment)
            message = await self.receiver.consume(fragment)
            if message is not None and kind in (None, message.msgtype):
                return message

    def patch(self, order):
        """The content of a message that gives an order, {"do": parameter of the Stage, name: value}."""
        new = Serializer(deferred=False).encode({name: value for name, value in order.items() if name != "do"})
        return {"events": [{"kind": "ModelChanged", "model": {"id": self.wire}, "attr": order["do"], "new": new}]}

    async def order(self, what, **values):
        """Ask for something, and wait until its run has ended: seconds to the first frames and to the last, status."""
        start, first = time.perf_counter(), None
        await self.give({"do": what} | ({"values": values} if what in ("scene", "restore") else values))
        while (heard := await self.heard()) != "status" or self.status["state"] not in ENDS:
            first = (first or time.perf_counter() - start) if heard == "run" else first
        whole = time.perf_counter() - start
        return first or whole, whole, self.status

    async def drag(self, name, values, pace):
        """Move a slider through values, one every `pace` seconds, and let go: what was seen.

        As a browser does, the newest position goes out once the last has been answered. Returns seconds to the first
        change, from letting go to the end of the exact run, pictures of the moving hand, status.
        """
        start, sent, first, pictures = time.perf_counter(), -1, None, 0
        while sent < len(values) - 1:
            wait = start + (sent + 1) * pace - time.perf_counter()
            if wait > 0:
                await asyncio.sleep(wait)
            sent = min(len(values) - 1, int((time.perf_counter() - start) / pace))
            await self.give({"do": "scene", "values": {name: values[sent]}, "held": True})
            while (what := await self.heard()) == "run":
                first = first or time.perf_counter() - start
            if what == "skeleton":
                pictures += 1
                first = first or time.perf_counter() - start
        begun, predicted = time.perf_counter(), self.status["run"] if what == "skeleton" else None
        await self.give({"do": "release"})
        # the run before a prediction has ended long ago: its exact run has another number
        while await self.heard() != "status" or self.status["state"] not in ENDS or self.status["run"] == predicted:
            first = first or time.perf_counter() - start
        return first, time.perf_counter() - begun, pictures, self.status

    async def give(self, order):
        self.orders += 1
        await self.send("PATCH-DOC", self.patch(order | {"n": self.orders}))

    async def heard(self):
        """What comes next of "run", "skeleton" and "status", of these what answers the last order."""
        while True:
            message = await self.message("PATCH-DOC")
            for what, news in told(message):
                if what == "status":
                    self.status |= news
                if what in ("run", "skeleton") or (what == "status" and self.status["acknowledged"] == self.orders):
                    return what

    def leave(self):
        self.socket.close()


def wire_of(document):
    """The id of the Stage's parameters in a serialized document; None of a document without a Stage."""
    roots = (root["attributes"] for root in document["roots"])
    return next((root["data"]["id"] for root in roots if root.get("name") == "Wire"), None)


def told(message):
    """[(parameter of the Stage, what it was set to)] of a message of the server."""
    changes = [event for event in message.content["events"] if event["kind"] == "ModelChanged"]
    return [(change["attr"], decoded(change["new"])) for change in changes]


def decoded(value):
    """A value as Bokeh writes it; what is bytes is left out."""
    if isinstance(value, list):
        return [decoded(each) for each in value]
    if not isinstance(value, dict):
        return value
    if value["type"] == "map":
        return {name: decoded(each) for name, each in value.get("entries", ())}
    return float(value["value"]) if value["type"] == "number" else None


class Server:
    """`panel serve app` on a free port of this machine's own, with warm workers; `lines` is what it logs."""

    def __init__(self, visitors=400):
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            self.port = probe.getsockname()[1]
        command = [Path(sys.executable).parent / "panel", "serve", "app", "--port", str(self.port)]
        command += ["--address", "127.0.0.1", "--allow-websocket-origin", f"localhost:{self.port}"]
        room = os.environ | {"APP_VISITORS": str(visitors)}
        piped = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT, "text": True}
        self.process = subprocess.Popen(command, cwd=ROOT, env=room, **piped)
        self.lines, warm = [], threading.Event()
        threading.Thread(target=self._listen, args=(warm,), daemon=True).start()
        if not warm.wait(300):
            raise RuntimeError("the server did not start:\n" + "".join(self.lines))

    def _listen(self, warm):
        for line in self.process.stdout:  # a full pipe would stop the server
            self.lines.append(line)
            if "workers are warm" in line:
                warm.set()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.terminate()
        self.process.wait(30)

    def workers(self):
        """Process ids of those that compute (Linux): forked by a child of the server."""
        return [pid for child in children(self.process.pid) for pid in children(child)]

    def memory(self):
        """MB that the server itself holds (Linux)."""
        lines = Path(f"/proc/{self.process.pid}/status").read_text().splitlines()
        return int(next(line for line in lines if line.startswith("VmRSS")).split()[1]) / 1e3

    def metrics(self):
        """{name: number} of what it tells of itself."""
        text = urllib.request.urlopen(f"http://127.0.0.1:{self.port}/metrics", timeout=PATIENCE).read().decode()
        told = dict(
            line.removeprefix("contact_").rsplit(" ", 1) for line in text.splitlines() if not line.startswith("#")
        )
        return {name: float(value) for name, value in told.items()}

    def processor_time(self, pid=None):
        """Seconds of processor time of the server, or of a worker, so far (Linux)."""
        fields = Path(f"/proc/{pid or self.process.pid}/stat").read_text().rsplit(")", 1)[1].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def tracebacks(self):
        return sum("Traceback" in line for line in self.lines)

    async def lag(self, until, every=0.1):
        """Seconds that a small request takes, asked every `every` seconds until the event: how busy the loop is."""
        times, address = [], f"http://127.0.0.1:{self.port}/app/static/style.css"
        while not until.is_set():
            start = time.perf_counter()
            await asyncio.to_thread(_ask, address)
            times.append(time.perf_counter() - start)
            await asyncio.sleep(every)
        return times


def children(pid):
    """Process ids of what a process has started, in whatever thread (Linux)."""
    with suppress(FileNotFoundError):  # it has just ended
        tasks = Path(f"/proc/{pid}/task").glob("*/children")
        return [int(child) for path in tasks for child in path.read_text().split()]
    return []


def _ask(address):
    urllib.request.urlopen(urllib.request.Request(address, method="HEAD"), timeout=PATIENCE).read()


def percentile(values, part):
    """The smallest value that `part` of all do not exceed; None of none."""
    ordered = sorted(values)
    return ordered[min(len(ordered) - 1, int(part * len(ordered)))] if ordered else None


def summary(values):
    """{p50, p95, p99, max} rounded to ms."""
    parts = {"p50": 0.5, "p95": 0.95, "p99": 0.99, "max": 1.0}
    return {name: round(percentile(values, part), 3) for name, part in parts.items()} if values else {}


def tell(report, path):
    """Print what was measured, {name: value}, and write it as JSON to a file if there is a path."""
    for name, value in report.items():
        print(f"{name:26s} {value}")
    if path:
        Path(path).write_text(json.dumps(report, indent=1), encoding="utf-8")
