"""The decorator of compiled functions, and calls of functions by their address.

Machine code is kept on disk where a folder can be written to. Functions as arguments would keep Numba from that, so
compiled loops call functions by address.
"""

import logging
from collections.abc import Callable
from functools import cache, partial
from typing import Any

from llvmlite import ir
from numba import cfunc, njit, types
from numba.extending import intrinsic

NO_CACHE = (
    "No folder for compiled code can be written to, so each start compiles it again and takes longer:"
    " set NUMBA_CACHE_DIR to a folder that can be written to"
)


def kernel(function: Callable | None = None, **options: Any) -> Any:
    """Compiles a function by Numba without Python objects and without the lock of the interpreter.

    options: further ones of `numba.njit`. Without a writable folder the code is compiled at each start, and one
    sentence is logged.

    What it calls becomes part of it: of the copies that callers would share, the one loaded first would serve all, and
    copies round in different ways. So the same run gives the same digits in each process.
    """
    if function is None:
        return partial(kernel, **options)
    return _kept(njit, function, nogil=True, forceinline=True, **options)


@cache
def address_of(function: Callable) -> int:
    """The address of a Python function of three addresses, compiled for `call`; it must not raise."""
    callback = _kept(_callback, function)
    _callbacks.append(callback)  # which owns the machine code
    return callback.address


_callbacks = list[Any]()


def _callback(function, **options):
    return cfunc(types.void(types.uintp, types.uintp, types.uintp), **options)(function)


def _kept(compiler, function, **options):
    """The function compiled with its code kept on disk, if possible."""
    try:
        return compiler(function, cache=True, **options)
    except RuntimeError as error:  # Numba gives no other sign of it
        if "no locator available" not in str(error):
            raise
        _report()
        return compiler(function, **options)


@intrinsic
def _call(typing, function, a, b, c):
    """Call a C function at the address `function` with three addresses, in compiled code."""

    def generate(context, builder, signature, arguments):
        kind = ir.FunctionType(ir.VoidType(), [ir.IntType(types.uintp.bitwidth)] * 3)
        builder.call(builder.inttoptr(arguments[0], kind.as_pointer()), arguments[1:])
        return context.get_dummy_value()

    return types.void(types.uintp, types.uintp, types.uintp, types.uintp), generate


@intrinsic
def _pointer(typing, address):
    """An address as the pointer that `numba.carray` needs, in compiled code."""

    def generate(context, builder, signature, arguments):
        return builder.inttoptr(arguments[0], ir.IntType(8).as_pointer())

    return types.voidptr(types.uintp), generate


# mypy takes the first argument for one of the caller's
call: Any = _call
pointer: Any = _pointer


@cache
def _report():
    logging.getLogger("solver").warning(NO_CACHE)
