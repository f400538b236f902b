"""The routes of the server. It answers the ones listed here, under the host names it accepts, and all others with 404.

`panel serve` adds routes of its own. One of them, `/components/<module>/...`, imports the module that a visitor names.
The host names are those of --allow-websocket-origin, and the loopback names. Tornado 6.6 accepts a websocket of the
page's own origin without asking Bokeh to check it: any name that resolves to this machine would do (DNS rebinding).
Undocumented in Bokeh 3.9: the patterns in `bokeh.server.urls`, which every server answers, the class
`bokeh.server.server.BokehTornado`, which this module replaces, and `check_allowlist`; in Tornado 6.6:
`Application.wildcard_router`, and the `params` of a connection.
"""

import logging
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from bokeh.server import server, urls
from bokeh.server.tornado import BokehTornado
from bokeh.server.util import check_allowlist
from bokeh.settings import settings
from panel.io.resources import DIST_DIR

from app import server_log
from app.session.message_filter import MessageFilter
from app.web import Files, ForeignHost, Liveness, Metrics, NotFound, Page, Root

log = logging.getLogger("app")
MESSAGE = 5_000_000  # bytes of a message on a websocket; no order is longer
LESSON = 3600  # s, at least, during which an opened page may still connect
BODY = 65_536  # bytes of a request's body; no page sends one
BODY_TIME = 10.0  # s for a body
IDLE = 30.0  # s for the headers of a request, and between two requests of a connection
TREE = r"/(?:(?P<tree>[0-9a-f]{16})/)?"  # the hash of all files, see app/assets.py
FILES = [(rf"{TREE}(?P<name>(?:static|features)/.*)", Files)]
PAGE = [("/?", Page), ("/ws", MessageFilter), *FILES]
# Files of Panel that a page of plain Panel widgets and plots loads.
BUNDLED = "theme|reactiveesm"
PANEL = rf"/static/extensions/panel/(panel\.min\.js|css/\w+\.css|bundled/(?:{BUNDLED})/.+\.(?:js|css|woff2))"
SERVER = [
    ("/?", Root),
    ("/metrics", Metrics),
    ("/liveness", Liveness),
    (r"/static/(js/bokeh[\w.-]*\.js)", Files, {"folder": Path(settings.bokehjs_path())}),
    (PANEL, Files, {"folder": DIST_DIR}),
]


class Application(BokehTornado):
    """Bokeh's application with bounds, and without the routes that are not listed; `removed` has their patterns."""

    def __init__(self, *arguments: Any, **options: Any) -> None:
        options |= {"default_handler_class": NotFound, "websocket_max_message_size_bytes": MESSAGE}
        options["session_token_expiration"] = max(LESSON, options.get("session_token_expiration", LESSON))
        super().__init__(*arguments, **options)
        server_log.bound(options.get("absolute_url"))
        pages = [(url.rstrip("/") + route, handler) for url in self.applications for route, handler in PAGE]
        listed = {(f"{self.prefix}{route}$", handler) for route, handler, *_ in [*pages, *SERVER]}
        found = {(rule.matcher.regex.pattern, rule.target): rule for rule in self.wildcard_router.rules}
        self.wildcard_router.rules[:] = [rule for key, rule in found.items() if key in listed]
        self.removed = [pattern for pattern, handler in found if (pattern, handler) not in listed]

    def start_request(self, server_conn: Any, request_conn: Any) -> Any:
        """Bound the size and the time of each request on a connection."""
        request_conn.set_max_body_size(BODY)
        request_conn.set_body_timeout(BODY_TIME)
        request_conn.params.header_timeout = IDLE
        return super().start_request(server_conn, request_conn)

    def find_handler(self, request: Any, **options: Any) -> Any:
        """Return the handler of a request; one for a foreign host gets no other answer."""
        host = refused_host(request, self.websocket_origins)
        if host is None:
            return super().find_handler(request, **options)
        return self.get_handler_delegate(request, ForeignHost, {"host": host[:80]})

    def log_request(self, handler: Any) -> None:
        """Log a request that was not answered as asked, in one line."""
        request, status = handler.request, handler.get_status()
        if status < 400:
            return
        event = getattr(handler, "event", None) or "a request was refused"
        fields = {"status": status, "method": request.method, "path": request.path[:200], "peer": request.remote_ip}
        log.log(logging.ERROR if status == 500 else logging.INFO, event, extra=fields)


def refused_host(request: Any, origins: Any) -> str | None:
    """Return the host name of a request if it is not allowed, else None; origins: of --allow-websocket-origin."""
    allowed = settings.allowed_ws_origin() or origins
    origin = request.headers.get("Origin")
    for host in [request.host, *([urlsplit(origin).netloc] if origin else [])]:
        if not server_log.OWN.fullmatch(host.lower()) and not check_allowlist(host.lower(), allowed):
            return host
    return None


def require() -> None:
    """End a server that was not made by these routes: its own ones import modules that a visitor names."""
    if server.BokehTornado is not Application:
        raise SystemExit(
            "The server was started with a file, without the hooks that close its routes. Serve the folder:"
            " panel serve app"
        )


def install() -> None:
    """Give these routes to all servers of this process. Call it before a server is made; it may be repeated."""
    urls.per_app_patterns[:] = PAGE
    urls.toplevel_patterns[:] = SERVER
    server.BokehTornado = Application
