"""A cache bounded by the memory of its values."""

from contextlib import suppress
from typing import Any

import numpy as np
from cachetools import LRUCache

OBJECT = 100  # bytes of an object without its contents, about


class Cache(LRUCache):
    """The values used last, up to `capacity` bytes in all."""

    def __init__(self, capacity: float) -> None:
        super().__init__(capacity, size_of)

    def put(self, key: Any, value: Any) -> None:
        """Keep a value, unless it is larger than the cache."""
        with suppress(ValueError):
            self[key] = value


def size_of(value: Any) -> int:
    """Return the memory of a value that consists of records, containers, arrays and bytes, about; bytes."""
    if isinstance(value, (bytes, str)):
        return OBJECT + len(value)
    if isinstance(value, np.ndarray):
        return OBJECT + value.nbytes
    if not isinstance(value, (tuple, list)):
        value = (value if isinstance(value, dict) else getattr(value, "__dict__", {})).values()
    return OBJECT + sum(map(size_of, value))
