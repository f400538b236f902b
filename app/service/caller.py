"""Calls with a time limit in separate processes: a call that hangs or crashes costs a process and nothing else."""

import os
import pickle
import signal
import sys
from collections.abc import Callable
from contextlib import contextmanager, suppress
from inspect import isgenerator
from math import inf
from multiprocessing import get_context, parent_process
from multiprocessing.connection import wait
from threading import Lock, RLock, Thread
from time import monotonic
from traceback import format_exc
from typing import Any

# Read by the libraries when they are loaded: processes as many as cores need no further threads.
ONE_THREAD = "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS", "NUMBA_NUM_THREADS"
SAFE = "PYTHONSAFEPATH"  # the fork server would import an `app` of the current folder; a process gets this one's path
# A plain fork copies the locks of threads in whatever state they are. The fork server has one thread, and has imported
# what `multiprocessing.set_forkserver_preload` names, so a process starts at once. Other systems do not have it.
START = "forkserver" if sys.platform == "linux" else "spawn"
STOP = b""  # a message: end the generator that runs
TRACEBACK = -6  # the innermost calls that a message shows: enough to find the cause
starting = RLock()


class Lost(Exception):
    """A call without a result: kind 'hang', 'crash', 'absent', 'closed' or 'error', and why; of an error its traceback.

    A visitor sees it as str.
    """

    def __init__(self, kind: str, reason: str) -> None:
        super().__init__(kind, reason)
        self.kind, self.reason = kind, reason

    def __str__(self) -> str:
        return "the server could not compute it; its log says why" if self.kind == "error" else self.reason


class Caller:
    """A process that makes one call at a time and ends with this one; any thread may `end` it."""

    def __init__(self) -> None:
        context: Any = get_context(START)  # which kind it has depends on the system
        self._pipe, theirs = context.Pipe()
        self._sending = Lock()  # `stop` is called by another thread
        self.process = context.Process(target=_serve, args=(theirs,), daemon=True)
        with theirs, _prepared():  # their end is closed here, so that the pipe ends with the process
            self.process.start()

    def alive(self) -> bool:
        """Whether the process is running."""
        return self.process.is_alive()

    def call(
        self, function: Callable, *arguments: Any, limit: float = inf, hear: Callable[[Any], Any] | None = None
    ) -> Any:
        """function(*arguments), computed in the process.

        Function, arguments and result must be picklable. limit: s until the result arrives. If the function returns a
        generator, hear(item) is called in this process with each item, and the result is the generator's return value.
        Raises Lost; except for kind 'error' the process has ended. Raises what `hear` raises; then it has ended, too.
        """
        if not self.alive():  # its pipe may still hold the rest of an answer
            raise self._crash()
        try:
            with suppress(BrokenPipeError, ConnectionError), self._sending:  # `_answer` reports it
                self._pipe.send((function, arguments))
        except Exception:  # function or arguments cannot be pickled
            raise Lost("error", format_exc(limit=TRACEBACK)) from None
        try:
            return self._result(monotonic() + limit, limit, hear)
        except Lost:
            raise
        except BaseException:  # `hear` failed or was interrupted: the rest of this answer would answer the next call
            self.end()
            raise

    def _result(self, due, limit, hear):
        while True:
            kind, value = self._answer(due, limit)
            if kind == "result":
                return value
            if kind == "error":
                raise Lost("error", value)
            if hear is not None:
                hear(value)

    def _answer(self, due, limit):
        ready = wait([self._pipe, self.process.sentinel], None if due == inf else max(0.0, due - monotonic()))
        if not ready:
            self.end()
            raise Lost("hang", f"no answer within {limit:g} s")
        try:
            return self._pipe.recv()
        except (EOFError, OSError):  # the process ended, maybe in the middle of an answer
            self.end()
            raise self._crash() from None
        except Exception:  # the answer cannot be unpickled
            raise Lost("error", format_exc(limit=TRACEBACK)) from None

    def _crash(self):
        return Lost("crash", f"the process ended with exit code {self.process.exitcode}")

    def stop(self) -> None:
        """End a call of a generator at its next item: its result is then None. Other calls go on.

        It waits for nothing: a call that is just being sent does not hear of it.
        """
        if self._sending.acquire(blocking=False):
            with suppress(OSError):
                self._pipe.send_bytes(STOP)
            self._sending.release()

    def end(self) -> None:
        """Kill the process, whatever it does; a call in progress raises Lost."""
        self.process.kill()
        self.process.join()


@contextmanager
def _prepared():
    """While a process starts: ONE_THREAD and SAFE are set where they are not, and `__main__`'s file is hidden.

    The new process inherits the variables. It would import the file, which may be the start script of a server.
    """
    main = sys.modules["__main__"]
    with starting:
        file = main.__dict__.pop("__file__", None)
        added = {name: "1" for name in (*ONE_THREAD, SAFE) if name not in os.environ}
        os.environ.update(added)
        try:
            yield
        finally:
            for name in added:
                del os.environ[name]
            if file is not None:
                main.__file__ = file


def _serve(pipe):
    """The main loop of the process."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the parent
    Thread(target=_end_with_parent, daemon=True).start()
    while True:
        try:
            sent = pipe.recv_bytes()
        except EOFError:
            return
        if sent == STOP:  # it came after the call had ended
            continue
        try:
            answer = "result", _result(*pickle.loads(sent), pipe)
        except Exception:  # of the call, or its function cannot be imported
            answer = "error", format_exc(limit=TRACEBACK)
        try:
            pipe.send(answer)
        except (BrokenPipeError, ConnectionError):
            return
        except Exception:  # the result cannot be pickled
            pipe.send(("error", format_exc(limit=TRACEBACK)))


def _result(function, arguments, pipe):
    result = function(*arguments)
    while isgenerator(result):
        try:
            pipe.send(("news", next(result)))
        except StopIteration as end:
            result = end.value
        else:
            if pipe.poll() and pipe.recv_bytes() == STOP:
                result.close()
                return None
    return result


def _end_with_parent():
    """End this process when its parent is gone, whatever it is busy with."""
    wait([parent_process().sentinel])
    os._exit(1)
