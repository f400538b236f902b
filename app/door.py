"""How many may come in: those who are here, and those whose page is on its way to them."""

import logging
from time import monotonic

from app.service import metrics
from app.session.session import VISITORS, visitors

COMING = 20.0  # s that a page may take until its browser is here


log = logging.getLogger("app")


class Door:
    """Lets in `most` visitors; every method runs in the server's loop."""

    def __init__(self, most=VISITORS):
        self.most, self.coming = most, {}  # {session id: until when a place is kept}

    def invites(self, name):
        """Keep a place for somebody who is sent the page; False if there is none."""
        now = monotonic()
        self.coming = {name: until for name, until in self.coming.items() if until > now}
        if len(visitors) + len(self.coming) >= self.most:
            return False
        self.coming[name] = now + COMING
        return True

    def lets_in(self, name):
        """Whether somebody may come in who is at the door."""
        return self.coming.pop(name, None) is not None or len(visitors) + len(self.coming) < self.most


def turned_away():
    """Say that somebody was, as there was no room."""
    metrics.count("turned_away")
    log.info("class full: a visitor was turned away")


door = Door()
