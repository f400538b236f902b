"""How Bokeh and Panel call this app, and what it uses of a document; tests/app/test_document.py guards it.

Bokeh 3.10 calls plain functions in threads, so that those of two visitors run at the same time. Whatever Bokeh or Panel
calls later is passed through `on_loop`. An exception is a callback for the end of a session, which must be plain: both
call it on the loop. `doc.models.freeze` and Panel's `set_curdoc` are internal.
"""

from collections.abc import Callable, Coroutine
from contextlib import AbstractContextManager
from typing import Any

from bokeh.document import Document
from panel.io.state import set_curdoc


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


def sending(doc: Document) -> AbstractContextManager[None]:
    """Return a context in which Panel sends changes of a document at once, so that they arrive in their order.

    Under Bokeh 3.9 Panel does not know that a coroutine function called by a worker's thread belongs to a document. It
    puts these changes off until the next callback, and others overtake them.
    """
    return set_curdoc(doc)


def later(doc: Document, call: Callable[[], object]) -> None:
    """Make a call under the lock of a document; any thread may call this. A destroyed document makes no call."""
    # a destroyed document has lost them. An error in Bokeh would leave it as the current one of this process
    if not hasattr(doc.callbacks, "_change_callbacks"):
        return
    try:
        doc.add_next_tick_callback(on_loop(call))
    except AttributeError:  # destroyed meanwhile, by another thread
        if hasattr(doc.callbacks, "_change_callbacks"):
            raise
