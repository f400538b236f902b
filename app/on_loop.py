"""Callbacks for Bokeh and Panel: coroutine functions, which run on the loop of the server.

Bokeh 3.10 calls plain functions in threads, so that those of two visitors run at the same time. Whatever Bokeh or Panel
calls later is passed through `on_loop`. An exception is a callback for the end of a session, which must be plain: both
call it on the loop.
"""

from collections.abc import Callable, Coroutine
from typing import Any


def on_loop(call: Callable[..., Any], *arguments: Any) -> Callable[..., Coroutine[Any, Any, Any]]:
    """Return a coroutine function that makes a call on the loop, under the lock of the document.

    arguments: the first ones of the call.
    """

    async def called(*more: Any) -> Any:
        return call(*arguments, *more)

    called.lock = True  # type: ignore[attr-defined]  # else Panel runs it without the lock of the document
    return called
