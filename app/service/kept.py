"""Values that were used last, up to a size in all."""

from collections import OrderedDict
from threading import Lock


class Kept:
    """Values by key, in any thread: those used last whose sizes together are at most `capacity`."""

    def __init__(self, capacity, size_of=lambda value: 1):
        self.capacity, self.size, self._size_of = capacity, 0, size_of
        self._values, self._lock = OrderedDict(), Lock()

    def __contains__(self, key):
        return key in self._values

    def __len__(self):
        return len(self._values)

    def get(self, key):
        """The value of `key`, which counts as used now, or None."""
        with self._lock:
            if key in self._values:
                self._values.move_to_end(key)
            return self._values.get(key, (None,))[0]

    def put(self, key, value):
        """Keep a value that is not None, unless there is one or it is too large; drop those not used for longest."""
        size = self._size_of(value)
        with self._lock:
            if key in self._values or size > self.capacity:
                return
            self._values[key] = value, size
            self.size += size
            while self.size > self.capacity:
                self.size -= self._values.popitem(last=False)[1][1]

    def clear(self):
        """Keep none."""
        with self._lock:
            self._values.clear()
            self.size = 0
