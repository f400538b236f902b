"""How Bokeh and Panel call this app, and what it uses of a document; tests/app/test_document.py guards it.

Bokeh 3.10 calls plain functions in threads, so that those of two visitors run at the same time. Whatever Bokeh or Panel
calls later is passed through `on_loop`. An exception is a callback for the end of a session, which must be plain: both
call it on the loop. `doc.models.freeze` and Panel's `set_curdoc` are internal.

A notebook has no document of a session: there a `Kernel` makes the same calls.
"""

import asyncio
from collections.abc import Callable, Coroutine
from contextlib import AbstractContextManager, nullcontext
from contextvars import copy_context
from typing import Any

from bokeh.document import Document
from panel.io.state import set_curdoc


class Kernel:
    """The loop of a notebook, in place of the document of a session, whose methods it has. RuntimeError without one."""

    def __init__(self) -> None:
        self.loop, self._calls = asyncio.get_running_loop(), set[asyncio.Task]()
        self._context = copy_context()  # of the cell: in that of a message Panel has the document of another output

    def add_next_tick_callback(self, call: Callable[[], Coroutine]) -> None:
        """Make a call; any thread may call this."""
        self.loop.call_soon_threadsafe(self._begin, call, context=self._context)

    def add_timeout_callback(self, call: Callable[[], Coroutine], ms: int) -> None:
        """Make a call after a time; only the loop may call this."""
        self.loop.call_later(ms / 1000, self._begin, call, context=self._context)

    def add_periodic_callback(self, call: Callable[[], Coroutine], ms: int) -> None:
        async def again():
            self.add_timeout_callback(again, ms)
            await call()

        self.add_timeout_callback(again, ms)

    def _begin(self, call):
        self._calls.add(task := self.loop.create_task(call()))  # asyncio itself keeps no task
        task.add_done_callback(self._calls.discard)


def kernel() -> Kernel | None:
    """Return the Kernel of this notebook; None without a running loop."""
    try:
        return Kernel()
    except RuntimeError:
        return None


def on_loop(call: Callable[..., Any], *arguments: Any) -> Callable[..., Coroutine[Any, Any, Any]]:
    """Return a coroutine function that makes a call on the loop, under the lock of the document.

    arguments: the first ones of the call.
    """

    async def called(*more: Any) -> Any:
        return call(*arguments, *more)

    called.lock = True  # type: ignore[attr-defined]  # else Panel runs it without the lock of the document
    return called


def frozen(doc: Document) -> AbstractContextManager[None]:
    """Return a context in which models are added and removed; Bokeh then collects them once."""
    return doc.models.freeze()


def current(doc: Document | Kernel) -> AbstractContextManager[None]:
    """Return a context in which a document is Panel's current one; its changes are sent at once, so in their order.

    Under Bokeh 3.9 Panel does not know that a coroutine function called by a worker's thread belongs to a document. It
    puts these changes off until the next callback, and others overtake them.
    """
    return nullcontext() if isinstance(doc, Kernel) else set_curdoc(doc)


def later(doc: Document | Kernel, call: Callable[[], object]) -> None:
    """Make a call under the lock of a document; any thread may call this. A destroyed document makes no call."""
    if isinstance(doc, Kernel):
        doc.add_next_tick_callback(on_loop(call))
        return
    # a destroyed document has lost them. An error in Bokeh would leave it as the current one of this process
    if not hasattr(doc.callbacks, "_change_callbacks"):
        return
    try:
        doc.add_next_tick_callback(on_loop(call))
    except AttributeError:  # destroyed meanwhile, by another thread
        if hasattr(doc.callbacks, "_change_callbacks"):
            raise
