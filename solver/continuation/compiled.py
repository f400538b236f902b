"""The decorator of compiled functions: their machine code is kept on disk where a folder can be written to."""

import logging
from collections.abc import Callable
from functools import cache, partial
from typing import Any

from numba import njit

NO_CACHE = (
    "No folder for compiled code can be written to, so each start compiles it again and takes longer:"
    " set NUMBA_CACHE_DIR to a folder that can be written to"
)


def kernel(function: Callable | None = None, **options: Any) -> Any:
    """Compiles a function by Numba without Python objects and without the lock of the interpreter.

    options: further ones of `numba.njit`. Without a writable folder the code is compiled at each start, and one
    sentence is logged.
    """
    if function is None:
        return partial(kernel, **options)
    try:
        return njit(function, cache=True, nogil=True, **options)
    except RuntimeError as error:  # Numba gives no other sign of it
        if "no locator available" not in str(error):
            raise
        _report()
        return njit(function, nogil=True, **options)


@cache
def _report():
    logging.getLogger("solver").warning(NO_CACHE)
