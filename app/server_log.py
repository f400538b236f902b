"""The server's log: one line of key=value pairs per event, and the addresses of the page for visitors."""

import json
import logging
import os
import re
import shlex
import socket
import sys
from contextlib import suppress
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple
from urllib.parse import urlsplit

from tornado.websocket import WebSocketClosedError

log = logging.getLogger("app")
USUAL = {*vars(logging.makeLogRecord({})), "message", "asctime", "taskName"}
HERE = Path(__file__).parent
OWN = re.compile(r"(localhost|127\.0\.0\.1|\[::1\])(:\d+)?")  # these names reach no other machine
BARE = re.compile(r"[\w.:/+-]+")
_bound = dict[str, str]()  # {"port": of this process}, once a server listens
ANYWHERE = ("192.0.2.1", 9)  # reserved for documentation; used to find the own address, nothing is sent


class Lines(logging.Formatter):
    """Formats records as time=... level=... event="..." with all `extra` fields; an exception is on the same line."""

    default_time_format, default_msec_format = "%Y-%m-%dT%H:%M:%S", "%s.%03d"

    def format(self, record: logging.LogRecord) -> str:
        """Return one line of text."""
        fields = {"time": self.formatTime(record), "level": record.levelname.lower()}
        if record.name != "app":
            fields["from"] = record.name
        fields["event"] = record.getMessage()
        fields |= {name: value for name, value in vars(record).items() if name not in USUAL}
        if record.exc_info:
            fields["traceback"] = self.formatException(record.exc_info)
        return " ".join(f"{name}={_quoted(value)}" for name, value in fields.items())


def _matters(record: logging.LogRecord) -> bool:
    """Whether a record is none of asyncio about a visitor who left while Panel wrote to a research page."""
    return not (record.exc_info and isinstance(record.exc_info[1], WebSocketClosedError))


def _quoted(value):
    text = f"{value:.6g}" if isinstance(value, float) else str(value)
    return text if BARE.fullmatch(text) else json.dumps(text, ensure_ascii=False)


def configure() -> None:
    """Make all loggers of this process write such lines to standard error."""
    root = logging.getLogger()
    if not root.handlers:
        root.addHandler(logging.StreamHandler())
    for handler in root.handlers:
        handler.setFormatter(Lines())
    logging.getLogger("asyncio").addFilter(_matters)
    for name in ("app", "tornado.general"):  # Tornado logs there which address sent a malformed request
        logging.getLogger(name).setLevel(logging.INFO)


def addresses() -> list[str]:
    """Return this machine's IPv4 addresses without the loopback, the most likely first."""
    found = []
    with suppress(OSError), socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.connect(ANYWHERE)
        found.append(probe.getsockname()[0])
    with suppress(OSError):
        found += [entry[4][0] for entry in socket.getaddrinfo(socket.gethostname(), None, socket.AF_INET)]
    return [address for address in dict.fromkeys(found) if not address.startswith(("127.", "0."))]


class Reach(NamedTuple):
    """How other machines reach the server: the origins that it accepts, or the commands that make it reachable."""

    origins: list[str]
    page: str  # the path of the page
    commands: list[tuple[str, str]]  # (origin, command), for each address of this machine


def bound(url: str | None) -> None:
    """Remember the port that the server of this process listens at: with --port 0 the system chooses it."""
    port = urlsplit(url or "").port
    if port:
        _bound["port"] = str(port)


def reach(arguments: Any = None) -> Reach:
    """Return the Reach of a server with these command line arguments; None: those of this process, at its bound port.

    A server that accepts every host name is reached by the address of the machine.
    """
    given = sys.orig_argv if arguments is None else arguments  # Bokeh replaces sys.argv while it loads the app
    port = (_option(given, "--port") or ["5006"])[-1]
    if arguments is None:
        port = _bound.get("port", port)
    known = [*_option(given, "--allow-websocket-origin"), *os.environ.get("BOKEH_ALLOW_WS_ORIGIN", "").split(",")]
    own = [f"{address}:{port}" for address in addresses()]
    hosts = [host for host in known if host and "*" not in host and not OWN.fullmatch(host.lower())]
    if any(host.startswith("*") for host in known):
        hosts += own
    scheme = "https" if "--use-xheaders" in given else "http"  # set behind a proxy, usually with TLS
    prefix = "".join(_option(given, "--prefix")[-1:]).strip("/")
    commands = [] if hosts else [(f"http://{host}", _command(host, port, prefix)) for host in own]
    return Reach([f"{scheme}://{host}" for host in hosts], f"/{prefix}/app" if prefix else "/app", commands)


def _command(host, port, prefix):
    """Return the command that serves the page under a host name: that of the folder of a clone, or for any folder."""
    serve = ["panel", "serve", HERE.name] if HERE.parent == Path.cwd() else ["mixed-mode-contact", "serve"]
    command = [*serve, "--address", "0.0.0.0", "--port", port, "--allow-websocket-origin", host]
    return shlex.join([*command, *(["--prefix", prefix] if prefix else [])])


def log_addresses(arguments: Any = None) -> None:
    """Log the address of the page for a class, or the command that makes the page reachable."""
    origins, page, commands = reach(arguments)
    for origin in origins:
        log.info("visitors open %s%s", origin, page)
    for origin, command in commands:
        log.info("for a class at %s%s start it by: %s", origin, page, command)


def _option(given, name):
    """Return the values of an option, written with a space or with =."""
    words = [word for text in given for word in text.split("=", 1)]
    return [value for before, value in pairwise(words) if before == name]
