"""What this app uses of a Bokeh document beyond its documentation; tests/app/test_document.py guards it.

`doc.models.freeze` is internal.
"""

from collections.abc import Callable
from contextlib import AbstractContextManager

from bokeh.document import Document

from app.on_loop import on_loop


def frozen(doc: Document) -> AbstractContextManager[None]:
    """Return a context in which models are added and removed; Bokeh then collects them once."""
    return doc.models.freeze()


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
