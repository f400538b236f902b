"""A progress bar of one line, on a terminal only."""

import sys
from time import monotonic

WIDTH = 40  # characters of the bar
PERIOD = 0.1  # s between two pictures of it


class Progress:
    """Draws `done` of `total` on a terminal and wipes itself when left; silent in files and pipes."""

    def __init__(self, total, stream=None, unit="increments"):
        self.total = max(total, 1)
        self.stream, self.unit = stream or sys.stderr, unit
        self.visible = self.stream.isatty()
        self.due = 0.0

    def __enter__(self):
        return self

    def __call__(self, done):
        if self.visible and monotonic() >= self.due:
            self.due = monotonic() + PERIOD
            full = min(WIDTH, WIDTH * done // self.total)
            self._write(f"\r[{'#' * full}{'.' * (WIDTH - full)}] {done} of {self.total} {self.unit}")

    def __exit__(self, *_):
        if self.visible:
            self._write("\r\033[K")

    def _write(self, text):
        self.stream.write(text)
        self.stream.flush()
