"""What this app uses of a Bokeh document beyond its documentation; tests/app/test_document.py guards it.

`doc.models.freeze` and Panel's `set_curdoc` are internal.
"""

from collections.abc import Callable
from contextlib import AbstractContextManager

from bokeh.document import Document
from panel.io.state import set_curdoc

from app.on_loop import on_loop


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
