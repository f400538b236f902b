"""One thread for linear algebra during a computation: on small matrices several threads wait for each other."""

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache

import numpy as np  # noqa: F401  its BLAS must be loaded before the search
import scipy.linalg  # noqa: F401  so must SciPy's own
from threadpoolctl import ThreadpoolController


@cache
def _blas() -> ThreadpoolController:
    """Controls each BLAS of this process; kept, as the search takes milliseconds."""
    return ThreadpoolController().select(user_api="blas")


@contextmanager
def one_thread() -> Iterator[None]:
    """BLAS has one thread within this context and its former number afterwards; also a decorator."""
    with _blas().limit(limits=1):
        yield
