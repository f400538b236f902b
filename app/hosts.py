"""The host names that this server accepts: those of --allow-websocket-origin, and the loopback names.

Tornado 6.6 accepts a websocket of the page's own origin without asking Bokeh to check it. Without this module, any name
that resolves to this machine would be accepted (DNS rebinding). Undocumented in Bokeh 3.9: `check_allowlist`.
"""

import re
from typing import Any
from urllib.parse import urlsplit

from bokeh.server.util import check_allowlist
from bokeh.settings import settings

OWN = re.compile(r"(localhost|127\.0\.0\.1|\[::1\])(:\d+)?")  # these names reach no other machine


def refused_host(request: Any, origins: Any) -> str | None:
    """Return the host name of a request if it is not allowed, else None; origins: of --allow-websocket-origin."""
    allowed = settings.allowed_ws_origin() or origins
    origin = request.headers.get("Origin")
    for host in [request.host, *([urlsplit(origin).netloc] if origin else [])]:
        if not OWN.fullmatch(host.lower()) and not check_allowlist(host.lower(), allowed):
            return host
    return None
