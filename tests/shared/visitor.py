"""Replacements for a visitor's document and browser, and a pool that does nothing."""

import asyncio
import json
import queue
import time
from concurrent.futures import ThreadPoolExecutor
from math import inf

import blocks
import numpy as np

from app.experiment import Experiment
from app.service import worker
from app.service.job import Job
from app.service.jobs import Jobs
from app.stage import Wire
from solver import Scene

SHORT = Scene(u_x_max=6.0)
PARTING = Scene(  # its contact pulls off under the held load
    nodes=64, width=160.0, radius=0.2, du_z=0.5, du_x=0.5, u_x_max=10.0, hold="load", delta_bar=-0.2, phi_ratio=0.5
)
OWN = Wire, Wire.__mro__[1]  # the latter has the parameters of features
PATIENCE = 240  # s; a limit against hanging, not a claim about speed


class Page:
    """A stand-in for the visitor's document and browser: runs what is scheduled, collects what is sent."""

    def __init__(self, pool, scene=SHORT, arguments=None, jobs=None):
        self.calls, self.chunks = queue.Queue(), []
        self.session = Experiment(scene, doc=self, arguments=arguments, jobs=jobs or Jobs(pool), stage=Wire())
        self.callbacks, self.messages = self, []  # {kind, ...} but for packed frames and status
        self._change_callbacks = {}  # a document that was destroyed has none
        hear(self.session, self._keep)

    def _keep(self, new):
        """Keep a message: frames of the run on screen or of a film, by their number; or another one."""
        numbers = {"run": new.get("run"), "slip": ("film", new.get("frame"))}
        if new["kind"] in numbers and "body" in new:
            self.chunks.append((numbers[new["kind"]], *unpacked(new["body"])))
        elif new["kind"] != "status":
            self.messages.append(new)

    def add_next_tick_callback(self, call):
        self.calls.put(call)

    def add_timeout_callback(self, call, milliseconds):
        self.calls.put(call)  # however short the time, nothing may get lost

    def order(self, what, **values):
        order(self.session, what, n=time.monotonic(), **values)

    def file(self, text, **chosen):
        send_file(self.session, text, **chosen)

    def status(self):
        return self.session.status

    def until(self, state):
        """Live on until the run has the given state."""
        self.run_scheduled(lambda: self.status().get("state") == state)

    def run_scheduled(self, condition):
        """Run what is scheduled until a condition holds."""
        while not condition():
            self.run_next()

    def run_all(self):
        """Run what is scheduled by now, and what that schedules."""
        self.run_scheduled(self.calls.empty)

    def run_next(self):
        """Run what is scheduled next, once it is."""
        ended(self.calls.get(timeout=PATIENCE)())

    def curve(self, name):
        """The last run's curve of that name, as the browser holds it."""
        last = self.chunks[-1][0]
        return np.concatenate([curves[name] for run, _, curves, _ in self.chunks if run == last])


def ended(coroutine):
    """Run a coroutine that waits for nothing, as the callbacks of a document are."""
    try:
        coroutine.send(None)
    except StopIteration:
        return
    raise AssertionError("it waits")


def waited(coroutine):
    """Its result; in a thread, as Playwright leaves a running loop in this one."""
    with ThreadPoolExecutor(1) as thread:
        return thread.submit(asyncio.run, coroutine).result(PATIENCE)


def whole_run(scene):
    """The Frames of a run, computed at once."""
    return worker.compute(scene, None, inf, limit=inf)


def in_slices(task, *arguments):
    """(result of a task that returns Parts, number of slices)."""
    kept, count = (), 0
    while isinstance(result := task(*arguments, *kept), worker.Part):
        kept, count = (result.state,), count + 1
    return result, count


def slices(scene, budget, **how):
    """The Frames of the parts of a run, each from the state of the one before."""
    part = worker.compute(scene, None, budget, **how)
    while isinstance(part, worker.Part):
        yield part.made
        part = worker.compute(scene, part.state, budget, **how)
    yield part


def unpacked(block):
    """(header, columns, fields in nm and GPa) of a packed block, by name."""
    head, columns, fields = blocks.unpack(block)
    whole, kept = {}, head["kept"]
    for (name, few), step in zip(fields.items(), kept["steps"], strict=True):
        at_nodes = _filled(few.T, kept["nodes"], head["nodes"]).T
        whole[name] = _filled(at_nodes, kept["frames"], head["frames"]) * step * head["scales"][name]
    return head, columns, whole


def _filled(few, kept, count):
    """All rows of which few are kept, by straight lines."""
    at = np.interp(np.arange(count), kept, np.arange(len(kept)))
    before = at.astype(int)
    after = np.minimum(before + 1, len(kept) - 1)
    return few[before] + (at - before)[:, None] * (few[after].astype(float) - few[before])


def asked(pool, call, *arguments, **how):
    """The job of a call, which the pool has from now on; how: as of `Job`."""
    return pool.submit(Job((call, *arguments), **how))


class NoPool:
    """A pool that takes jobs and does none; `answer` does what a worker does when a call has returned."""

    status, in_flight = "ready", 0

    def __init__(self):
        self.jobs = []  # each as often as it was submitted

    def submit(self, job):
        self.jobs.append(job)
        return job

    def answer(self, job, made):
        if job.returned(made):
            self.submit(job)
        job.tell()

    def does(self, job):
        self.answer(job, job.call[0](*job.call[1:], *job.state))

    def move_up(self, job, owner, rank):
        job.owner, job.rank = owner, rank

    def position(self, job):
        return None

    def abandon(self, job):
        job.cancel()


def messages(session):
    """The messages that a session sends from now on, as a list that grows."""
    sent = []
    hear(session, sent.append)
    return sent


def hear(session, call):
    """Call `call` with every message {"kind": parameter of the Stage, ...} that a session sends from now on."""

    def told(*events):
        for event in events:
            call({"kind": event.name} | {name: value for name, value in event.new.items() if name != "sent"})

    own = [name for name, parameter in Wire.param.objects().items() if parameter.owner in OWN and name != "name"]
    session.stage.param.watch(told, [name for name in own if name not in session.orders])


def say(session, order):
    """Give an order, {"do": parameter of the Stage, field: value} or the same in JSON."""
    given = json.loads(order) if isinstance(order, str) else dict(order)
    session.obey(given.pop("do"), given)


def send_file(session, text, **chosen):
    """Give the orders that bring a file with this text, and use it as chosen."""
    content = text.encode()
    order(session, "piece", at=0, of=len(content), content=content)
    order(session, "choice", turn=1, use=True, **chosen)


def order(session, what, /, n=1, **values):
    """Give an order with these fields, or with these values of a scene."""
    of_scene = "values" in session.orders[what].order.needs
    say(session, {"do": what, "n": n} | ({"values": values} if of_scene else values))
