"""The runs that the server computes while nobody needs its workers, without a browser."""

import asyncio
from concurrent.futures import ThreadPoolExecutor

from helpers import until
from visitor import PATIENCE, NoPool

from app.features.stored.feature import precompute
from app.service.caller import Lost
from app.service.job import LATER, NOBODY
from app.service.jobs import Jobs
from app.service.packing import Frames
from app.service.worker import compute
from solver import Scene


def precomputed(jobs, scenes):
    """Compute runs in the background of another thread, which ends when they are all there."""
    return ThreadPoolExecutor(1).submit(asyncio.run, precompute(jobs, scenes))


def test_server_precomputes_runs_one_by_one_at_background_rank():
    jobs, scenes = Jobs(NoPool()), [Scene(), Scene(E=80.0), Scene(E=90.0)]
    jobs.results.put((compute, scenes[1]), ((compute, scenes[1]), Frames()))
    done = precomputed(jobs, scenes)
    for count, scene in ((1, scenes[0]), (2, scenes[2])):
        until(lambda count=count: len(jobs.pool.jobs) == count)
        job = jobs.pool.jobs[-1]
        assert job.call == (compute, scene) and (job.owner, job.rank) == (NOBODY, LATER)
        jobs.pool.answer(job, Frames(frames=7))
    done.result(PATIENCE)
    assert jobs.results[compute, scenes[2]][1].frames == 7


def test_precomputing_runs_ends_with_the_pool():
    jobs = Jobs(NoPool())
    done = precomputed(jobs, [Scene(), Scene(E=80.0)])
    until(lambda: jobs.pool.jobs)
    jobs.pool.answer(jobs.pool.jobs[0], Lost("closed", "the server is being stopped"))
    done.result(PATIENCE)
    assert len(jobs.pool.jobs) == 1
