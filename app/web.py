"""Handlers of HTTP requests: the page, scripts and styles, metrics, and liveness, with their headers.

Undocumented in Bokeh 3.9: the `application_context` of an application's handlers, and the functions that make a
session's token (Panel uses both).
"""

import gzip
import html
import logging
import mimetypes
import re
import secrets
from contextlib import suppress
from pathlib import Path, PurePath
from typing import Any

from bokeh.util.token import generate_jwt_token, generate_session_id, get_session_id
from panel.io.resources import Resources
from panel.io.server import DocHandler, server_html_page_for_session
from tornado.ioloop import IOLoop
from tornado.web import RequestHandler, authenticated

from app import assets, interface
from app.assets import content, version
from app.document import current
from app.environment import FRAMES, VISITORS
from app.experiment import example
from app.page import shared
from app.service import metrics
from app.service.pool import pool
from app.session.controls import FOR_BROWSER, FOR_SERVER
from app.session.message_filter import TOKEN, is_full, no_longer_opened, opened

log = logging.getLogger("app")
STRANGE = 3  # unknown names of an address that the page reports, at most
AGAIN = 10  # s before a browser repeats the request for a page of a full class
CONNECTS = 60.0  # s within which a browser connects to the session of a feature's own page
YEAR = 31_536_000  # s
HTML = "text/html; charset=utf-8"
NOTHING = "default-src 'none'; style-src 'unsafe-inline'; frame-ancestors "
HOST = re.compile(r"[\w.-]+(:\d+)?")  # as a policy can name it: an IPv6 address cannot be named
REFUSAL = """<!DOCTYPE html><html lang="en"><head><meta charset="utf-8"><title>{title}</title>{more}
<meta name="viewport" content="width=device-width"><style>:root {{ color-scheme: light dark }}
body {{ font: 18px/1.5 system-ui; margin: 2em auto; padding: 0 1em; max-width: 36em; overflow-wrap: anywhere }}</style>
</head><body><h1>{title}</h1><p role="alert">{text}</p></body></html>"""


def policy(host: str, nonce: str, frames: str) -> str:
    """Return the Content-Security-Policy of the page.

    Bokeh compiles code of a document, and writes inline styles; Panel loads the script of a component as a blob.
    """
    sockets = f" ws://{host} wss://{host}" if HOST.fullmatch(host) else ""  # not 'self' in some browsers
    return (
        f"default-src 'none'; script-src 'self' blob: 'nonce-{nonce}' 'unsafe-eval'; style-src 'self' 'unsafe-inline';"
        f" img-src 'self' data: blob:; font-src 'self' data:; connect-src 'self'{sockets} blob:; base-uri 'none';"
        f" form-action 'none'; frame-ancestors {frames}"
    )


class Plain(RequestHandler):
    """A handler with the headers that every answer has."""

    def set_default_headers(self) -> None:
        self.set_header("X-Content-Type-Options", "nosniff")
        self.set_header("Referrer-Policy", "no-referrer")
        self.set_header("Content-Security-Policy", NOTHING + "'none'")
        self.clear_header("Server")

    def body(self, text: str | bytes, kind: str) -> None:
        """Answer with a text or bytes, compressed if the browser accepts this."""
        body = text.encode() if isinstance(text, str) else text
        self.set_header("Content-Type", kind)
        self.set_header("Vary", "Accept-Encoding")
        if "gzip" in self.request.headers.get("Accept-Encoding", ""):
            body = gzip.compress(body, 1)
            self.set_header("Content-Encoding", "gzip")
        self.finish(body)

    @property
    def frames(self) -> str:
        """Sites that may embed this page in a frame."""
        return FRAMES if self.get_argument("embed", "") == "1" else "'self'"

    def refuse(self, status: int, title: str, text: str, again: int = 0) -> None:
        """Answer with a page that reports an error; again: s before the browser repeats the request."""
        self.set_status(status)
        self.set_header("Content-Security-Policy", NOTHING + self.frames)
        more = f'<meta http-equiv="refresh" content="{again}">' if again else ""
        self.body(REFUSAL.format(title=title, text=text, more=more), HTML)


class ForeignHost(Plain):
    """403 for every request under a host name that the server does not allow."""

    def initialize(self, host: str, **_: Any) -> None:
        self.host = host

    def prepare(self) -> Any:
        option = f"--allow-websocket-origin={self.host}"
        self.event = f"a request for the host {self.host} was refused: start with {option} to allow it"
        text = f"The server does not answer under the name {html.escape(self.host)}. Use another name of it,"
        self.refuse(403, "Not under this name", f"{text} or start it with <code>{html.escape(option)}</code>.")


class NotFound(Plain):
    """404 for all addresses that are not listed in app/routes.py."""

    def prepare(self) -> Any:
        self.send_error(404)


class Root(Plain):
    """Redirects to the page, by a relative address: a proxy may have removed a prefix."""

    def get(self) -> Any:
        here, page = self.request.path.rsplit("/", 1)[1], next(iter(self.application.applications)).strip("/")
        self.redirect(f"./{here}/{page}" if here else f"./{page}")

    head = get


class Page(Plain, DocHandler):
    """The page with a token of a session, which starts when the browser connects; or a page with an error."""

    @authenticated
    async def get(self, *_: Any) -> None:
        self.set_header("Cache-Control", "no-store")  # the page has the token
        if self.request.path.endswith("/"):
            page = self.request.path.rstrip("/").rsplit("/", 1)[1]  # relative: a proxy may have removed a prefix
            return self.redirect("?".join(filter(None, [f"../{page}", self.request.query])))
        # a request without a browser may keep others from pages whose sessions cost, but not from the class
        own = interface.owner(self.request.arguments) is not None
        if is_full(self.request.remote_ip, len(opened) if own else 0):
            self.set_header("Retry-After", str(AGAIN))
            text = f"{VISITORS} visitors are here. This page tries again every {AGAIN} s, and opens when one leaves."
            return self.refuse(503, "The class is full", text, AGAIN)
        arguments = self.known_arguments(own)
        token = self.token_for(arguments)
        if len(token) > TOKEN:
            text = f"It has {len(self.request.uri)} characters, allowed: about {TOKEN // 2}. {self.without}"
            return self.refuse(414, "The address is too long", text)
        nonce = secrets.token_urlsafe(16)
        try:
            if own:
                page = await self.own_page(token, nonce)
            else:
                page = shared(example).page_for(arguments, token=token, nonce=nonce)
        except Exception:
            log.exception("the page could not be built")
            return self.refuse(500, "The experiment could not be opened", f"See the server's log. {self.without}")
        self.set_header("Content-Security-Policy", policy(self.request.host, nonce, self.frames))
        metrics.count("pages")
        self.body(page, HTML)

    async def own_page(self, token: str, nonce: str) -> str:
        """Return the page of a feature's own: its session starts now, and Panel renders its document."""
        name = get_session_id(token)
        opened[name] = None  # it costs as much as a visitor, whether its browser connects or not
        IOLoop.current().call_later(CONNECTS, no_longer_opened, name)
        opened[name] = session = await self.application_context.create_session_if_needed(name, self.request, token)
        session.block_expiration()  # a slow browser would find another session than that of its page
        doc, resources = session.document, Resources.from_bokeh(self.application.resources())
        resources.components = ["bokeh", "bokeh-widgets", "bokeh-tables"]  # needed by those of Panel
        own = {"template": doc.template, "template_variables": doc.template_variables}
        with current(doc):  # Panel then finds the theme of this visitor
            page = server_html_page_for_session(session, resources, doc.title, token, **own)
        return re.sub(r"<script(?=[ >])", f'<script nonce="{nonce}"', page)

    def known_arguments(self, own: bool) -> dict[str, list[bytes]]:
        """Return {name: [bytes]} of the address: what the server reads, and a few unknown names for a note.

        own: of the page of a feature's own, whose link back has what the browser reads.
        """
        given = self.request.arguments
        read = FOR_SERVER | (FOR_BROWSER if own else set())
        others = [name for name in given if name not in FOR_SERVER | FOR_BROWSER][:STRANGE]
        return {name: given[name] for name in given if name in read} | {name[:40]: [] for name in others}

    def token_for(self, arguments: dict[str, list[bytes]]) -> str:
        """Return the token for the connection: it has the id of a session, and the arguments of the address."""
        keys = {"secret_key": self.application.secret_key, "signed": self.application.sign_sessions}
        payload = {"headers": {}, "cookies": {}, "arguments": arguments}
        payload |= self.application_context.application.process_request(self.request)
        expires = self.application.session_token_expiration
        return generate_jwt_token(generate_session_id(**keys), expiration=expires, extra_payload=payload, **keys)

    @property
    def without(self) -> str:
        """Link to the page without parameters, for an invalid address."""
        page = html.escape(self.application_context.url.rsplit("/", 1)[1])
        return f'<a href="./{page}">Open the experiment without parameters</a>.'

    head = get


class Files(Plain):
    """Scripts and styles from memory, compressed once. A browser caches an address with the right hash for a year."""

    def initialize(self, folder: Path | None = None, **_: Any) -> None:
        """folder: of another package; else the files of app/assets.py are meant."""
        self.folder = folder and folder.resolve()

    def get(self, name: str, tree: str | None = None) -> None:
        """Answer with a file; tree: the hash of all files, see app/assets.py. `?v=` may give that of the file alone."""
        path = self.found(name)
        if path is None:
            return self.send_error(404)
        raw, packed, self.tag = content(path)
        suffix = PurePath(name).suffix
        kind = {".js": "text/javascript", ".css": "text/css"}.get(suffix) or mimetypes.guess_type(name)[0]
        self.set_header("Content-Type", f"{kind or 'application/octet-stream'}; charset=utf-8")
        self.set_header("Vary", "Accept-Encoding")
        known = tree == version() if tree else self.get_argument("v", "") == self.tag
        self.set_header("Cache-Control", f"public, max-age={YEAR}, immutable" if known else "no-cache")
        if "gzip" in self.request.headers.get("Accept-Encoding", ""):
            self.set_header("Content-Encoding", "gzip")
            raw = packed
        self.finish(raw)

    head = get

    def found(self, name: str) -> str | Path | None:
        """Return the name of a file of app/assets.py or the path of a file in the folder, or None."""
        if self.folder is None:
            return name if name in assets.files() or name in assets.MADE else None
        with suppress(ValueError, OSError):  # a name with a null byte, or one that is too long
            path = (self.folder / name).resolve()
            return path if path.is_relative_to(self.folder) and path.is_file() else None
        return None

    def compute_etag(self) -> str | None:
        return getattr(self, "tag", None) and f'"{self.tag}"'


class Metrics(Plain):
    """Metrics in the text format of Prometheus."""

    def get(self) -> Any:
        self.body(metrics.text(), "text/plain; version=0.0.4; charset=utf-8")

    head = get


class Liveness(Plain):
    """200 while workers answer, otherwise 503."""

    def get(self) -> Any:
        alive, why = pool.alive()
        self.set_status(200 if alive else 503)
        self.set_header("Cache-Control", "no-store")
        self.finish({"alive": alive, "why": why, "workers": pool.status})

    head = get
