"""Called by Bokeh once per server: workers start warming before the first visitor comes, and end with the server."""

import logging

from app.service.pool import pool
from app.views.pages import compose_all


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
    compose_all()


def on_server_unloaded(server_context):
    """End the worker processes with the server."""
    pool.close()
