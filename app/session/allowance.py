"""How much of the server's loop one visitor's messages may take: what is spent beyond it is waited for."""

from time import monotonic

from app.session.session import visitors

PURSE = 1.0  # s that may be spent at once: a page that is opened takes a fifth of it
ALL = 0.6  # of the loop's time, for messages of all visitors
MOST, LEAST = 0.3, 0.02  # of it for one
LONGEST = 5.0  # s


class Allowance:
    """Seconds of the loop that one visitor may still spend, growing with time up to PURSE."""

    def __init__(self):
        self.left, self.at = PURSE, monotonic()

    def spend(self, seconds):
        """Seconds to wait before the next message is read."""
        share, now = max(LEAST, min(MOST, ALL / max(1, len(visitors)))), monotonic()
        self.left = min(PURSE, self.left + share * (now - self.at)) - seconds
        self.at = now
        return min(LONGEST, max(0.0, -self.left / share))
