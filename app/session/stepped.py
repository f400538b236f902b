"""A coroutine of a visitor whose steps run under the lock of the visitor's document, so that it may change models."""

from collections.abc import Callable, Coroutine, Generator
from types import coroutine
from typing import Any


@coroutine
def news() -> Generator[None, None, None]:
    """Wait until the coroutine is woken. The reason is not passed on: look what has changed."""
    yield


class Stepped:
    """Runs a coroutine that awaits nothing but `news()`; schedule(function) calls it under the lock of the document."""

    def __init__(self, made: Coroutine[Any, Any, None], schedule: Callable[[Callable[[], None]], None]) -> None:
        self._coroutine, self._schedule = made, schedule
        self._due = self._running = self._closed = False

    def ring(self, *_: object) -> None:
        """Wake the coroutine soon; any thread may call this."""
        if not self._closed:
            self._schedule(self.step)

    def step(self) -> None:
        """Wake the coroutine, and return when it waits again. Call this under the lock of the document."""
        self._due = not self._closed
        if self._running:  # it looks again before it waits
            return
        self._running = True
        try:
            while self._due:
                self._due = False
                self._coroutine.send(None)
        finally:
            self._running = False

    def close(self) -> None:
        """End the coroutine where it waits."""
        self._closed = True
        self._coroutine.close()
