"""Finished runs, shared by all visitors: a class that takes the same steps computes each run only once."""

from concurrent.futures import CancelledError

from app.service import metrics, tasks
from app.service.cache import Cache
from app.service.packing import Frames
from app.service.pool import LATER, NOBODY
from app.service.requests import shared_requests
from solver.isolated import Lost

CAPACITY = 100e6  # bytes, about 70 runs


def fill(run_cache, pool, scenes, later):
    """Compute the runs of scenes one by one on idle workers, and put them into the cache.

    later(function, *arguments): makes a call in the thread that uses the cache.
    """
    scenes = iter(scenes)

    def compute_next():
        scene = next((scene for scene in scenes if scene not in run_cache), None)
        run = scene and shared_requests.ask(pool, (tasks.whole_run, scene), notify, owner=NOBODY, rank=LATER)
        if run:
            notify((tasks.whole_run, scene), run)

    def notify(call, run):
        later(store, call, run)

    def store(call, run):
        if isinstance(run, Frames):
            run_cache.put(call[1], run)
        if not isinstance(run, (Lost, CancelledError)):  # the pool has been closed
            compute_next()

    compute_next()


run_cache = Cache(CAPACITY)  # Frames by Scene
metrics.gauge("run_cache_bytes", "bytes of the finished runs in the cache", lambda: run_cache.currsize)
