"""The host names that this server accepts: those of --allow-websocket-origin, and the loopback names.

Tornado 6.6 accepts a websocket of the page's own origin before Bokeh checks origins. Without this module, any name that
resolves to this machine would be accepted (DNS rebinding).
"""

import logging
import re
from urllib.parse import urlsplit

from bokeh.server.util import check_allowlist
from bokeh.settings import settings

log = logging.getLogger("app")
OWN = re.compile(r"(localhost|127\.0\.0\.1|\[::1\])(:\d+)?")  # these names reach no other machine


def refused_host(handler):
    """Return the host name of a request if it is not allowed, else None."""
    allowed = settings.allowed_ws_origin() or handler.application.websocket_origins
    origin = handler.request.headers.get("Origin")
    for host in [handler.request.host, *([urlsplit(origin).netloc] if origin else [])]:
        if not OWN.fullmatch(host.lower()) and not check_allowlist(host.lower(), allowed):
            return host
    return None


class NamedHost:
    """A request handler that answers only requests for an allowed host."""

    async def prepare(self):
        """Reject a request for another host first."""
        host = refused_host(self)
        if host is None:
            return await super().prepare()
        host = host[:80]
        log.warning("refused a request for the host %s: start with --allow-websocket-origin=%s to allow it", host, host)
        self.refuse_host(host)

    def refuse_host(self, host):
        """Answer that the server does not allow this host."""
        self.set_status(403)
        self.finish(f"This server was not started for the host {host}.")
