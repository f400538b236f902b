"""Replacements for a visitor's document and browser, and a pool that does nothing."""

import json
import queue
import struct
import time

import numpy as np

from app.pages import Pages
from app.service import packing, worker
from app.service.pool import Task
from app.service.run_cache import RunCache
from app.session.session import Session
from solver import Scene

SHORT = Scene(u_x_max=6.0)
PATIENCE = 240  # s; a limit against hanging, not a claim about speed


class Page:
    """A stand-in for the visitor's document and browser: runs what is scheduled, collects what is sent."""

    def __init__(self, pool, scene=SHORT, arguments=None, run_cache=None):
        self.calls, self.chunks = queue.Queue(), []
        self.session = Session(self, Pages, arguments, pool, run_cache or RunCache())
        self.session.scene = scene
        self.messages = []  # [(header, body)], but for packed frames
        self.session.wire.on_change("message", self._take)

    def _take(self, attribute, old, new):
        """Keep a message: frames of the run on screen, of a pin or of a film, by their number; or another one."""
        if new is None:
            return
        head, body = opened(new)
        numbers = {"run": head.get("run"), "pinned": ("pin", head.get("pin")), "film": ("film", head.get("frame"))}
        if head["kind"] in numbers:
            self.chunks.append((numbers[head["kind"]], *unpacked(body)))
        else:
            self.messages.append((head, body))

    def add_next_tick_callback(self, call):
        self.calls.put(call)

    def add_timeout_callback(self, call, milliseconds):
        self.calls.put(call)  # however short the time, nothing may get lost

    def order(self, what, **values):
        say(self.session, {"do": what, "values": values, "n": time.monotonic()})

    def file(self, entry, text):
        send_file(self.session, entry, text)

    def status(self):
        return json.loads(self.session.wire.status)

    def until(self, state):
        """Live on until the run has the given state."""
        while self.status().get("state") != state:
            self.calls.get(timeout=PATIENCE)()

    def curve(self, name):
        """The last run's curve of that name, as the browser holds it."""
        last = self.chunks[-1][0]
        return np.concatenate([curves[name] for run, _, curves, _ in self.chunks if run == last])


def slices(scene, budget, **how):
    """The Slices of a run, each from what the one before has kept."""
    piece = worker.compute(scene, None, budget, **how)
    yield piece
    while not piece.done:
        piece = worker.compute(scene, piece.state, budget, **how)
        yield piece


def opened(message):
    """(header, body) of a message."""
    return packing.header(message), message[4 + struct.unpack_from("<I", message)[0] :]


def unpacked(block):
    """(header, columns, fields in nm and GPa) of a packed block, by name."""
    head, columns, fields = packing.unpack(block)
    return head, columns, {name: field * head["scales"][name] for name, field in fields.items()}


class NoPool:
    """A pool that takes tasks and never does any."""

    status, in_flight = "ready", 0

    def __init__(self):
        self.tasks = []

    def submit(self, *task, owner=None, rank=0, seconds=0.0):
        self.tasks.append(Task(task, owner, rank))
        return self.tasks[-1]

    def position(self, task):
        return None

    def abandon(self, task):
        task.cancel()


def say(session, order):
    """Give an order, a text or what is one in JSON, as the message filter does."""
    session.obey(order if isinstance(order, str | bytes) else json.dumps(order))


def send_file(session, entry, text):
    """Give an order that brings a file."""
    session.obey(packing.headed({"do": "file", "values": {"entry": entry}, "n": 1}, text.encode()))


def order(session, what, /, **values):
    say(session, {"do": what, "values": values, "n": 1})
