"""Calls in processes of their own, each with a limit of time: a call that hangs or crashes costs a process, no more."""

import os
import signal
import sys
from concurrent.futures import ThreadPoolExecutor, as_completed
from contextlib import contextmanager, suppress
from inspect import isgenerator
from math import inf
from multiprocessing import get_context, parent_process
from multiprocessing.connection import wait
from threading import Event, RLock, Thread, local
from time import monotonic
from traceback import format_exc

# The limit of `threads.one_thread` from the start: as many processes as cores, of which none makes threads in vain
ONE_THREAD = "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS", "NUMBA_NUM_THREADS"
# A plain fork copies threads' locks in whatever state they are. A server of forks has one thread, and holds what was
# imported with `multiprocessing.set_forkserver_preload`: a process is there at once. Not every system bears it.
START = "forkserver" if sys.platform == "linux" else "spawn"
spawning = RLock()


class Lost(Exception):
    """A call without a result: kind 'hang', 'crash' or 'error', and what is known of it; of an error its traceback."""

    def __init__(self, kind, reason):
        super().__init__(kind, reason)
        self.kind, self.reason = kind, reason

    def __str__(self):
        return self.reason


class Caller:
    """A process that makes one call at a time, and ends with this one; `end` it from any thread."""

    def __init__(self):
        for name in ONE_THREAD:
            os.environ.setdefault(name, "1")
        context = get_context(START)
        self._pipe, theirs = context.Pipe()
        self.process = context.Process(target=_serve, args=(theirs,), daemon=True)
        with theirs, _bare_main():  # their end is closed here, so that the pipe ends with the process
            self.process.start()

    def alive(self):
        """Whether the process still is."""
        return self.process.is_alive()

    def call(self, function, *arguments, limit=inf, hear=None):
        """function(*arguments), made in the process; raises Lost, and but for kind 'error' the process is gone then.

        All must be picklable, the function importable. limit: s until the result is here. Of a generator, hear(each)
        is called here for all it yields, and the result is what it returns.
        """
        due = monotonic() + limit
        try:
            with suppress(BrokenPipeError, ConnectionError):  # heard below
                self._pipe.send((function, arguments))
            while True:
                kind, value = self._answer(due, limit)
                if kind == "result":
                    return value
                if kind == "error":
                    raise Lost("error", value)
                hear(value)
        except Lost:
            raise
        except (EOFError, OSError):  # the process ended, maybe in the middle of an answer
            self.end()
            raise Lost("crash", f"the process ended with exit code {self.process.exitcode}") from None
        except Exception:  # what cannot be pickled
            raise Lost("error", format_exc(limit=-6)) from None

    def _answer(self, due, limit):
        ready = wait([self._pipe, self.process.sentinel], None if due == inf else max(0.0, due - monotonic()))
        if ready:
            return self._pipe.recv()
        self.end()
        raise Lost("hang", f"no answer within {limit:g} s")

    def end(self):
        """Kill the process, whatever it does; a call that goes on raises Lost."""
        self.process.kill()
        self.process.join()


@contextmanager
def _bare_main():
    """Hide `__main__`'s file while a process is spawned: it would import the start script, of a server all of it."""
    main = sys.modules["__main__"]
    with spawning:
        file = main.__dict__.pop("__file__", None)
        try:
            yield
        finally:
            if file is not None:
                main.__file__ = file


def outcomes(call, items, workers, limit):
    """Yield (index, call(item) or Lost) as they come; call importable, items picklable, limit in seconds for each.

    workers: how many processes of this machine, or the address of a dask cluster's scheduler; then raises ClusterError.
    """
    with crew(workers) as outcomes_of:
        yield from outcomes_of(call, items, limit)


@contextmanager
def crew(workers):
    """A function (call, items, limit) as `outcomes`, whose processes stay from one use to the next."""
    if isinstance(workers, str):
        from . import cluster  # which makes use of what is here

        yield lambda call, items, limit: cluster.outcomes(call, items, workers, limit)
        return
    callers, own, over = [], local(), Event()

    def outcome(call, item, limit):
        """In a thread with a process of its own, a new one after each that was lost."""
        try:
            if getattr(own, "caller", None) is None:
                own.caller = Caller()
                callers.append(own.caller)
                if over.is_set():  # it has come too late to be ended with the others
                    own.caller.end()
            return own.caller.call(call, item, limit=limit)
        except Lost as lost:
            if lost.kind != "error":
                own.caller = None
            return lost

    def outcomes_of(call, items, limit):
        made = {threads.submit(outcome, call, item, limit): index for index, item in enumerate(items)}
        for future in as_completed(made):
            yield made[future], future.result()

    with ThreadPoolExecutor(workers) as threads:
        try:
            yield outcomes_of
        finally:  # nobody wants the rest
            over.set()
            threads.shutdown(wait=False, cancel_futures=True)
            for caller in list(callers):
                caller.end()


def _serve(pipe):
    """The life of the process."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the parent
    Thread(target=_end_with_parent, daemon=True).start()
    while True:
        try:
            function, arguments = pipe.recv()
        except EOFError:
            return
        except Exception:  # what cannot be imported
            pipe.send(("error", format_exc(limit=-6)))
            continue
        try:
            answer = "result", _made(function, arguments, pipe)
        except Exception:
            answer = "error", format_exc(limit=-6)
        try:
            pipe.send(answer)
        except (BrokenPipeError, ConnectionError):
            return
        except Exception:  # what cannot be pickled
            pipe.send(("error", format_exc(limit=-6)))


def _made(function, arguments, pipe):
    made = function(*arguments)
    while isgenerator(made):
        try:
            pipe.send(("news", next(made)))
        except StopIteration as end:
            made = end.value
    return made


def _end_with_parent():
    """End this process when its parent is gone, whatever it is busy with."""
    wait([parent_process().sentinel])
    os._exit(1)
