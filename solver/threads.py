"""One thread for linear algebra during a computation: on small matrices several threads wait for each other."""

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from threading import Lock
from typing import Any

import numpy as np  # noqa: F401  its BLAS must be loaded before the search
import scipy.linalg  # noqa: F401  so must SciPy's own
from threadpoolctl import ThreadpoolController


@cache
def _blas() -> ThreadpoolController:
    """Controls each BLAS of this process; kept, as the search takes milliseconds."""
    return ThreadpoolController().select(user_api="blas")


_lock = Lock()
_open: list[Any] = []  # a place for each context that is open now, in any thread; the first one holds the limit


@contextmanager
def one_thread() -> Iterator[None]:
    """BLAS has one thread within this context and its former number afterwards; also a decorator.

    Within another one it costs nothing: setting the limit takes as long as a force evaluation.
    """
    with _lock:
        _open.append(None if _open else _blas().limit(limits=1))
    try:
        yield
    finally:
        with _lock:
            if limit := _open.pop():  # the last one
                limit.restore_original_limits()
