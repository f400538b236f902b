"""The settings of a computation: one thread for linear algebra, and NumPy's own handling of errors.

On small matrices several threads wait for each other. Underflow is meant: springs far apart pull with exp(-gap).
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache, wraps
from threading import Lock
from typing import Any, ParamSpec, TypeVar

import numpy as np  # its BLAS must be loaded before the search
import scipy.linalg  # noqa: F401  so must SciPy's own
from threadpoolctl import ThreadpoolController

P = ParamSpec("P")
R = TypeVar("R")


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


def computation(function: Callable[P, R]) -> Callable[P, R]:
    """Decorates an entry point: `one_thread`, and NumPy's defaults in place of what `np.seterr` asked for."""

    @wraps(function)
    def settled(*args: P.args, **options: P.kwargs) -> R:
        with one_thread(), np.errstate(divide="warn", over="warn", under="ignore", invalid="warn"):
            return function(*args, **options)

    return settled
