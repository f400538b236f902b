"""Plans of FFTW that compiled code can execute, by addresses.

This is a private interface: pyFFTW documents neither that its wheels for Linux bring the library in `pyfftw.libs`, nor
its name. Where it is not found (macOS, Windows, other builds), or if the environment has SOLVER_LOOPS=python or
NUMBA_DISABLE_JIT=1, `plans` returns None. Then transforms are executed by pyFFTW's own objects, and Python makes the
loops.
"""

import ctypes
import os
import weakref
from functools import cache
from pathlib import Path
from threading import RLock

import pyfftw
from numba import config

from .kernels import respond

ESTIMATE, DESTROY_INPUT = 1 << 6, 1 << 0  # flags of fftw3.h
# FFTW's planner is not thread-safe. A plan may be dropped while its thread makes another one
planning = RLock()


@cache
def _library():
    """The library with the types of what is called, or None."""
    try:
        (path,) = (Path(pyfftw.__file__).parents[1] / "pyfftw.libs").glob("libfftw3-*.so*")
        library = ctypes.CDLL(str(path))
        for name in ("fftw_plan_many_dft_r2c", "fftw_plan_many_dft_c2r"):
            getattr(library, name).restype = ctypes.c_void_p
        for name in ("fftw_execute", "fftw_destroy_plan"):
            getattr(library, name).argtypes, getattr(library, name).restype = [ctypes.c_void_p], None
        return library if library.fftw_execute_dft_r2c and library.fftw_execute_dft_c2r else None
    except (OSError, ValueError, AttributeError):
        return None


class Plans:
    """Transforms of the real rows `field` (2, n) to `spectrum` and of that to `product`, planned by FFTW's estimate.

    Attributes: addresses, of the plans and of the functions that execute them, by their names in `kernels.CONTEXT`.
    """

    def __init__(self, library, field, spectrum, product):
        n, modes = field.shape[1], spectrum.shape[1]
        self._library, length = library, (ctypes.c_int * 1)(n)
        to, back = library.fftw_plan_many_dft_r2c, library.fftw_plan_many_dft_c2r
        one, two = ctypes.c_int(1), ctypes.c_int(2)
        real, complex_, flags = ctypes.c_int(n), ctypes.c_int(modes), ctypes.c_uint(ESTIMATE)
        f, s, p = (ctypes.c_void_p(array.ctypes.data) for array in (field, spectrum, product))
        self._forward = to(one, length, two, f, None, one, real, s, None, one, complex_, flags)
        flags = ctypes.c_uint(ESTIMATE | DESTROY_INPUT)
        self._backward = back(one, length, two, s, None, one, complex_, p, None, one, real, flags)
        weakref.finalize(self, _destroy, library, self._forward, self._backward).atexit = False
        self.addresses = {"forward": self._forward, "backward": self._backward}
        for name, function in ("transform", "fftw_execute_dft_r2c"), ("transform_back", "fftw_execute_dft_c2r"):
            self.addresses[name] = ctypes.cast(getattr(library, function), ctypes.c_void_p).value
        self._field = self.addresses["transform"], self._forward, field.ctypes.data
        self._product = self.addresses["transform_back"], self._backward, product.ctypes.data

    def respond(self, spectrum, blocks) -> None:
        """Fill product from field, with its spectrum times blocks, as of `kernels.multiply`."""
        respond(*self._field, spectrum, blocks, *self._product)

    def forward(self) -> None:
        """Fill spectrum from field."""
        self._library.fftw_execute(self._forward)

    def backward(self) -> None:
        """Fill product from spectrum, which it destroys."""
        self._library.fftw_execute(self._backward)


def _destroy(library, *made):
    with planning:
        for plan in made:
            library.fftw_destroy_plan(plan)


def plans(field, spectrum, product) -> Plans | None:
    """The Plans of these arrays, which stay where they are; None where the library is not found."""
    off = config.DISABLE_JIT or os.environ.get("SOLVER_LOOPS") == "python"  # type: ignore[attr-defined]
    library = None if off else _library()
    return library and Plans(library, field, spectrum, product)
