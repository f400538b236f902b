"""How much of the server's loop one visitor's messages may take: what is spent beyond it is waited for."""

from time import monotonic

PURSE = 0.5  # s that may be spent at once: to open a page, or to drag for a while
ALL = 0.6  # of the loop's time, for messages of all visitors
MOST, LEAST = 0.5, 0.02  # of it for one
LATELY = 2.0  # s since a message, for which a visitor counts among those who share
LONGEST = 5.0  # s
active = {}  # {Allowance: when it was last used}


class Allowance:
    """Seconds of the loop that one visitor may still spend, growing with time up to PURSE."""

    def __init__(self):
        self.left, self.at = PURSE, monotonic()

    def spend(self, seconds):
        """Seconds to wait before the next message is read."""
        now = monotonic()
        active[self] = now
        for other in [other for other, at in active.items() if at < now - LATELY]:
            del active[other]
        share = max(LEAST, min(MOST, ALL / len(active)))
        self.left = min(PURSE, self.left + share * (now - self.at)) - seconds
        self.at = now
        return min(LONGEST, max(0.0, -self.left / share))
