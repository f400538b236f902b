"""The routes of the server. It answers the ones listed here, and all others with 404.

`panel serve` adds routes of its own. One of them, `/components/<module>/...`, imports the module that a visitor names.
Undocumented in Bokeh 3.9: the patterns in `bokeh.server.urls`, of which every server is made, and the class
`bokeh.server.server.BokehTornado`, which this module replaces; in Tornado 6.6: `Application.wildcard_router`.
"""

from pathlib import Path

from bokeh.server import server, urls
from bokeh.server.tornado import BokehTornado
from bokeh.settings import settings
from panel.io.resources import DIST_DIR

from app.session.message_filter import MessageFilter
from app.web import Files, Liveness, Metrics, NotFound, Page, Root, Scripts

PAGE = [("/?", Page), ("/ws", MessageFilter), (r"/static/(.*)", Files), (r"/pages/(\w+/page\.js)", Scripts)]
# Files of Panel that a page of plain Panel widgets, tables and plots loads.
BUNDLED = "theme|bootstrap5|bootstraptemplate|datatabulator|font-awesome|reactiveesm"
PANEL = rf"/static/extensions/panel/(panel\.min\.js|css/\w+\.css|bundled/(?:{BUNDLED})/.+\.(?:js|css|woff2))"
SERVER = [
    ("/?", Root),
    ("/metrics", Metrics),
    ("/liveness", Liveness),
    (r"/static/(js/bokeh[\w.-]*\.js)", Files, {"folder": Path(settings.bokehjs_path())}),
    (PANEL, Files, {"folder": DIST_DIR}),
]


class Application(BokehTornado):
    """Bokeh's application without the routes that are not listed here; `removed` has their patterns."""

    def __init__(self, *arguments, **options):
        super().__init__(*arguments, default_handler_class=NotFound, **options)
        pages = [(url.rstrip("/") + route, handler) for url in self.applications for route, handler in PAGE]
        listed = {(f"{self.prefix}{route}$", handler) for route, handler, *_ in [*pages, *SERVER]}
        found = {(rule.matcher.regex.pattern, rule.target): rule for rule in self.wildcard_router.rules}
        self.wildcard_router.rules[:] = [rule for key, rule in found.items() if key in listed]
        self.removed = [pattern for pattern, handler in found if (pattern, handler) not in listed]

    def add_handlers(self, host_pattern, host_handlers):
        """Reject routes that are added later."""
        raise ValueError(f"The server has no routes but those in {__name__}. Add {host_handlers} there.")


def install():
    """Give these routes to all servers of this process. Call it before a server is made; it may be repeated."""
    urls.per_app_patterns[:] = PAGE
    urls.toplevel_patterns[:] = SERVER
    server.BokehTornado = Application
