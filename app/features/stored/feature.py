"""Stored runs: those of the experiments at the top of the page are on screen until the computed run has come."""

from collections.abc import Iterable
from contextlib import suppress
from typing import Any

from tornado.ioloop import IOLoop

from app import interface
from app.features.stored.store import FOLDER, row
from app.service.caller import Lost
from app.service.job import NOBODY
from app.service.jobs import Jobs, jobs
from app.service.worker import compute
from solver import Scene
from solver.presets import presets

PRELOAD = '<link rel="preload" id="stored" as="fetch" crossorigin="anonymous" href="{}">'


class Feature(interface.Feature):
    """The page fetches them as files."""

    PAGE = True
    ORDER = 1
    ALONE = True

    @classmethod
    def declared(cls, root: str) -> dict[str, Any]:
        runs = {path.stem: f"{root}/features/stored/runs/{path.name}" for path in sorted(FOLDER.glob("*.bin"))}
        return {"stored": runs}

    @classmethod
    def head(cls, root: str, scene: Scene, preset: str) -> str:
        address = cls.declared(root)["stored"].get(preset) if scene == presets()[preset].scene else None
        return PRELOAD.format(address) if address else ""

    @classmethod
    def begin(cls, several: bool) -> None:
        """Compute these runs on workers that nobody needs."""
        IOLoop.current().spawn_callback(precompute, jobs, [preset.scene for preset in row().values()])


async def precompute(jobs: Jobs, scenes: Iterable[Scene]) -> None:
    """Compute runs one by one on workers that nobody needs, so that they are in the cache."""
    with suppress(Lost):  # the pool has been closed
        for scene in scenes:
            await jobs.result(compute, scene, owner=NOBODY)
