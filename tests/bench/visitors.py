"""What a class costs: N visitors who all move a slider again and again; server-side latency and processor time.

`python tests/bench/visitors.py [--visitors 30] [--moves 20] [--pause 1.0] [--together]` starts `panel serve app` itself
and speaks Bokeh's websocket protocol as a browser does, without drawing. Latency is from sending the order to the
arrival of the first and of the last frames: order received, computed, sent; loopback. With one visitor it is what the
server adds to what a browser needs for drawing.
"""

import argparse
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
import urllib.request
from pathlib import Path

from bokeh.protocol import Protocol
from bokeh.protocol.receiver import Receiver
from tornado.httpclient import HTTPRequest
from tornado.websocket import websocket_connect

ROOT = Path(__file__).parent.parent.parent
PATIENCE = 60  # s; a limit against hanging


class Visitor:
    """One browser tab without the drawing."""

    def __init__(self, port, seed):
        self.port, self.random = port, random.Random(seed)
        self.receiver = Receiver(Protocol())
        self.sent, self.orders, self.times, self.bytes = 0, 0, [], 0

    async def arrive(self):
        """Load the page, connect, and find the model through which everything passes."""
        address = f"http://localhost:{self.port}/app?E={self.random.uniform(60, 80):.4f}"
        page = await asyncio.to_thread(lambda: urllib.request.urlopen(address, timeout=PATIENCE).read().decode())
        token = re.search(r'"token":"([^"]+)"', page)[1]
        request = HTTPRequest(
            f"ws://localhost:{self.port}/app/ws", headers={"Sec-WebSocket-Protocol": f"bokeh, {token}"}
        )
        self.socket = await websocket_connect(request, subprotocols=["bokeh", token], max_message_size=2**28)
        self.socket.protocol.set_nodelay(True)  # as browsers do
        await self.message("ACK")
        await self.send("PULL-DOC-REQ", {})
        reply = await self.message("PULL-DOC-REPLY")
        self.wire = wire_of(reply.content["doc"])

    async def send(self, kind, content):
        self.sent += 1
        for part in ({"msgid": f"{self.sent}", "msgtype": kind}, {}, content):
            await self.socket.write_message(json.dumps(part))

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

    async def order(self, what, **values):
        """Ask for something, and wait until its run is whole."""
        self.orders += 1
        order = json.dumps({"do": what, "values": values, "n": self.orders})
        event = {"kind": "ModelChanged", "model": {"id": self.wire}, "attr": "order", "new": order}
        start, first = time.perf_counter(), None
        await self.send("PATCH-DOC", {"events": [event]})
        while True:
            message = await self.message("PATCH-DOC")
            for event in message.content["events"]:
                if event.get("attr") == "chunk":
                    first = first or time.perf_counter() - start
                    whole = time.perf_counter() - start
                elif event.get("attr") == "status":
                    status = json.loads(event["new"])
                    if status["heard"] == self.orders and status["state"] in ("finished", "failed") and first:
                        return first, whole

    async def experiment(self, moves, pause, together):
        """Watch the first run, then move a slider to a new place every `pause` seconds or so."""
        await self.order("hello")
        for move in range(moves):
            await asyncio.sleep(pause * self.random.uniform(0.5, 1.5))
            value = -0.3 + 0.01 * move if together else self.random.uniform(-1.0, 1.0)
            known = {"E": 70.0} if together else {}
            self.times.append(await self.order("scene", delta_bar=value, **known))
        self.socket.close()


def wire_of(content):
    """The id of the Wire model in a serialized document."""
    if isinstance(content, dict):
        if str(content.get("name", "")).endswith("Wire") and "id" in content:
            return content["id"]
        content = list(content.values())
    found = map(wire_of, content) if isinstance(content, list) else ()
    return next(filter(None, found), None)


def processor_time(process):
    """Seconds of processor time of the server and of its workers, so far (Linux)."""
    threads = Path(f"/proc/{process}/task").glob("*/children")  # workers are children of the threads that started them
    children = [pid for path in threads for pid in path.read_text().split()]

    def used(pid):
        fields = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    return used(process), sum(map(used, children))


def served():
    """(process, port) of a server of its own, with warm workers."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    command = [Path(sys.executable).parent / "panel", "serve", "app", "--port", str(port)]
    process = subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    while "workers are warm" not in (line := process.stdout.readline()):
        if not line:
            raise RuntimeError("the server did not start")
    threading.Thread(target=process.stdout.read, daemon=True).start()  # a full pipe would stop the server
    return process, port


async def lesson(options, process, port):
    """All arrive, then all experiment; prints what it took."""
    visitors = [Visitor(port, seed) for seed in range(options.visitors)]
    start = time.perf_counter()
    await asyncio.gather(*(visitor.arrive() for visitor in visitors))
    arrived = time.perf_counter() - start
    await asyncio.sleep(options.settle)
    before, start = processor_time(process.pid), time.perf_counter()
    await asyncio.gather(*(visitor.experiment(options.moves, options.pause, options.together) for visitor in visitors))
    seconds = time.perf_counter() - start
    server, workers = (after - b for after, b in zip(processor_time(process.pid), before, strict=True))
    load = " ".join(f"{part:.1f}" for part in os.getloadavg())
    print(f"{options.visitors} visitors arrived within {arrived:.1f} s; load {load}, {os.cpu_count()} cores")
    times = [times for visitor in visitors for times in visitor.times]
    sent = sum(visitor.bytes for visitor in visitors) / seconds / 1e6
    print(
        f"{len(times)} runs in {seconds:.1f} s, {sent:.1f} MB/s, {1000 * server / len(times):.1f} ms of the server each"
    )
    print(f"server {server / seconds:.0%}, workers {workers / seconds:.0%} of a core")
    for column, name in enumerate(("first frames", "whole run")):
        ordered = sorted(time[column] for time in times)
        p50, p95 = (1000 * ordered[min(len(ordered) - 1, int(part * len(ordered)))] for part in (0.5, 0.95))
        print(f"{name:12s} p50 {p50:5.0f} ms   p95 {p95:5.0f} ms")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--visitors", type=int, default=30)
    parser.add_argument("--moves", type=int, default=20)
    parser.add_argument("--pause", type=float, default=1.0, help="s between two moves of a visitor")
    parser.add_argument("--settle", type=float, default=8.0, help="s until the workers have their plans")
    parser.add_argument("--together", action="store_true", help="all go through the same scenes, as a class does")
    options = parser.parse_args()
    process, port = served()
    try:
        asyncio.run(lesson(options, process, port))
    finally:
        process.terminate()
        process.wait()


if __name__ == "__main__":
    main()
