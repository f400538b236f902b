"""Hooks that Bokeh calls once per server: workers start before the first visit, and end with the server."""

import gc
import logging
import os
import signal
from contextlib import suppress
from pathlib import Path
from threading import Thread
from typing import Any

from bokeh.settings import settings
from tornado.ioloop import PeriodicCallback

import app

if not (HERE := Path(__file__).parent).samefile(app.__path__[0]):  # before anything of another version is imported
    other = f"The folder {HERE} is served, but another version is installed: {app.__path__[0]}."
    raise SystemExit(f"{other} Install this one: pip install -e {HERE.parent}")

from app import interface, routes, server_log
from app.experiment import LOOK, example, visitors
from app.page import shared
from app.service import metrics, worker
from app.service.caller import Lost
from app.service.job import LATER, NOBODY, Job
from app.service.pool import pool

log = logging.getLogger("app")
server_log.configure()  # before Bokeh logs the first line
settings.perform_document_validation = False  # a walk through all models at each visit, for developers
routes.install()
PARENT = os.getpid()  # that of a server made by --num-procs, which forks after this line


def on_server_loaded(server_context: Any) -> None:
    """Start the workers, then load code and compute runs that the first page does not need: the port is open."""
    shared(example)
    pool.start()
    if os.getpid() != PARENT:
        PeriodicCallback(_end_with_parent, LOOK).start()
    PeriodicCallback(lambda: [session.look() for session in list(visitors)], LOOK).start()
    PeriodicCallback(metrics.loop_lag.record, 1000 * metrics.LoopLag.EVERY).start()
    server_log.log_addresses()
    Thread(target=_load, name="load", daemon=True).start()
    for feature in interface.classes().values():
        feature.begin(os.getpid() != PARENT)


def _end_with_parent():
    """End this server, one of --num-procs, when its parent has ended: Tornado's parent tells its children nothing."""
    if os.getppid() != PARENT:
        os.kill(os.getpid(), signal.SIGTERM)


def _load():
    """Load what features need for later visitors, after a worker has compiled the kernels."""
    with suppress(Lost):
        pool.submit(Job((worker.ready,), NOBODY, LATER)).result()
        for feature in interface.classes().values():
            feature.load()
    gc.collect()
    gc.freeze()  # Panel collects garbage after every visit: objects of what is loaded are skipped


def on_server_unloaded(server_context: Any) -> None:
    """End the worker processes."""
    log.info("the server is being stopped", extra={"visitors": len(visitors), "queue": pool.in_flight})
    pool.close()
