"""One thread for linear algebra while something is computed: for small matrices more only wait for each other."""

from contextlib import contextmanager
from functools import cache

import numpy as np  # noqa: F401  its library must be loaded before it is looked for
from threadpoolctl import ThreadpoolController


@cache
def _libraries():
    """What controls each BLAS of this process; found once, as that takes milliseconds."""
    return ThreadpoolController().select(user_api="blas").lib_controllers


@contextmanager
def one_thread():
    """Within it BLAS has one thread, and afterwards as many as before; also a decorator."""
    limited = [(library, count) for library in _libraries() if (count := library.num_threads) != 1]
    for library, _ in limited:
        library.set_num_threads(1)
    try:
        yield
    finally:
        for library, count in limited:
            library.set_num_threads(count)
            if hasattr(library, "clear_controlling_thread"):  # of OpenBLAS: or no other thread could set a limit
                library.clear_controlling_thread()
