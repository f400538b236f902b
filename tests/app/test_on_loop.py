"""What Bokeh and Panel call runs on the loop of the server. Bokeh 3.10 calls plain functions in threads.

Otherwise orders of two visitors would run at the same time.
"""

import ast
import asyncio
import threading
from pathlib import Path

from bokeh.document import Document
from bokeh.server.session import ServerSession
from tornado.ioloop import IOLoop
from visitor import waited

from app import document

APP = Path(document.__file__).parent
CALLED = {  # method of a document or of Panel's state: position of the callback
    "add_next_tick_callback": 0,
    "add_timeout_callback": 0,
    "add_periodic_callback": 0,
    "with_document_locked": 0,
    "onload": 0,
    "execute": 0,
    "on_event": 1,
    "on_change": 1,
}


def registered():
    """(file, line, callback as ast) of all that the app lets Bokeh or Panel call."""
    for path in APP.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and getattr(node.func, "attr", "") in CALLED:
                yield path, node.lineno, node.args[CALLED[node.func.attr]]
            elif isinstance(node, ast.Call):
                yield from ((path, node.lineno, given.value) for given in node.keywords if given.arg == "on_click")


def is_coroutine_function(path, callback):
    """Whether an expression is on_loop(...), a name given by that, an `async def`, or a lambda that schedules one."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    if isinstance(callback, ast.Lambda):  # Bokeh takes plain functions only there
        return getattr(callback.body.func, "attr", "") == "execute"
    if isinstance(callback, ast.Call):
        return getattr(callback.func, "id", "") == "on_loop"
    name = getattr(callback, "id", None) or getattr(callback, "attr", "")
    for node in ast.walk(tree):
        if isinstance(node, ast.AsyncFunctionDef) and node.name == name:
            return True
        if isinstance(node, ast.Assign) and getattr(node.targets[0], "id", "") == name:
            return is_coroutine_function(path, node.value)
    return False


def test_all_callbacks_that_are_registered_are_coroutine_functions():
    found = list(registered())
    assert len(found) >= 4
    assert [f"{path.name}:{line}" for path, line, callback in found if not is_coroutine_function(path, callback)] == []


def test_four_visitors_count_twenty_of_twenty_on_the_thread_of_the_loop():
    """Each reads, waits for nothing, and writes: in threads, most of the counts would be lost."""
    count, threads = [0], set()

    def raise_count():
        threads.add(threading.get_ident())
        before = count[0]
        for _ in range(20_000):
            pass  # long enough that threads would take turns
        count[0] = before + 1

    async def visits():
        loop = IOLoop.current()
        sessions = [ServerSession(f"visitor {k}", Document(), io_loop=loop) for k in range(4)]
        for each in [session for session in sessions for _ in range(5)]:
            document.later(each.document, raise_count)
        while count[0] < 20 and any(session.document.session_callbacks for session in sessions):
            await asyncio.sleep(0.01)
        return threading.get_ident()

    assert (threads, count) == ({waited(visits())}, [20])
