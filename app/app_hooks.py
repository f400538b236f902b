"""Called by Bokeh once per server: workers start warming before the first visitor comes, and end with the server."""

import logging

from tornado.ioloop import PeriodicCallback

from app.service.pool import pool
from app.session import gate
from app.session.session import visitors
from app.views.pages import compose_all

LOOK = 1000  # ms between two looks at who waits
gate.install()


def on_server_loaded(server_context):
    """Start the worker processes, so that kernels are compiled or loaded while nobody waits."""
    log = logging.getLogger("app")
    log.setLevel(logging.INFO)
    if not log.handlers:
        handler = logging.StreamHandler()
        handler.setFormatter(logging.Formatter("%(asctime)s app: %(message)s"))
        log.addHandler(handler)
        log.propagate = False
    pool.start()
    PeriodicCallback(lambda: [session.look() for session in list(visitors)], LOOK).start()
    compose_all()


def on_server_unloaded(server_context):
    """End the worker processes with the server."""
    pool.close()
