"""Under which host names this server answers: those of --allow-websocket-origin, and names of the machine itself.

Tornado 6.6 accepts a websocket of the page's own origin before Bokeh's check of origins: a page under any name that
leads to this machine would do, chosen by a stranger too (DNS rebinding).
"""

import logging
import re
from urllib.parse import urlsplit

from bokeh.server.util import check_allowlist
from bokeh.settings import settings

log = logging.getLogger("app")
OWN = re.compile(r"(localhost|127\.0\.0\.1|\[::1\])(:\d+)?")  # no other machine can be reached by these


def refused_host(handler):
    """The host name of a request for which this server was not started, or None."""
    allowed = settings.allowed_ws_origin() or handler.application.websocket_origins
    origin = handler.request.headers.get("Origin")
    for host in [handler.request.host, *([urlsplit(origin).netloc] if origin else [])]:
        if not OWN.fullmatch(host.lower()) and not check_allowlist(host.lower(), allowed):
            return host
    return None


class NamedHost:
    """A handler of requests that answers only those for an allowed host."""

    async def prepare(self):
        """Refuse a request for another host before anything else."""
        host = refused_host(self)
        if host is None:
            return await super().prepare()
        host = host[:80]
        log.warning("refused a request for the host %s: start with --allow-websocket-origin=%s to allow it", host, host)
        self.refuse_host(host)

    def refuse_host(self, host):
        """Answer that this host is not allowed."""
        self.set_status(403)
        self.finish(f"This server was not started for the host {host}.")
