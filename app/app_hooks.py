"""Called by Bokeh once per server: workers start warming before the first visitor comes, and end with the server."""

import gc
import logging
from pathlib import Path

import numpy as np
from tornado.ioloop import PeriodicCallback

from app import telling, web
from app.page import shared
from app.service import metrics
from app.service.pool import pool
from app.session.session import visitors
from solver import Scene
from solver.mechanics import cohesive_law

LOOK = 1000  # ms between two looks at who waits
log = logging.getLogger("app")
web.install()
shared(f"/{Path(__file__).parent.name}")
cohesive_law.traction(Scene(), np.zeros(1), 0.0)  # of which the page on the law makes use: the kernel is here then


def on_server_loaded(server_context):
    """Start the worker processes, so that kernels are compiled or loaded while nobody waits."""
    telling.begin()
    pool.start()
    PeriodicCallback(lambda: [session.look() for session in list(visitors)], LOOK).start()
    PeriodicCallback(metrics.pulse.beat, 1000 * metrics.Pulse.EVERY).start()
    telling.say_where()
    gc.collect()
    gc.freeze()  # Panel collects all garbage whenever a visitor has left: only what came since is to be looked through


def on_server_unloaded(server_context):
    """End the worker processes with the server."""
    log.info("the server is being stopped", extra={"visitors": len(visitors), "queue": pool.in_flight})
    pool.close()
