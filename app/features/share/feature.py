"""Share: a run as a link, a QR code, Python lines, pictures, a table, and the files that the command line writes."""

from functools import partial
from math import inf
from typing import Any

from app import interface
from app.features.share import tasks
from app.service import worker
from app.service.job import HEAVY
from app.service.requests import Requests
from app.session import orders
from app.session.orders import order
from solver import Scene

FORMATS = "npz", "json"
SCANNED = 1200  # characters of a link; with more, a QR code is too fine for a phone at the back of a classroom
LARGEST = 20e6  # bytes of a file
LARGE = "it would be larger than 20 MB: use python -m solver run"
SLOW = "it takes too long here: use python -m solver run"


class Feature(interface.Feature):
    """The exports of one visitor."""

    PAGE = True
    ORDER = 70
    PARAMS = {
        "share": "asks for the Python lines and the QR code of a link: link",
        "shared": "what is shared: link, python, qr",
        "export": "asks for the run as a file: kind (npz or json)",
        "file": "a run in full precision: ending, body (bytes), why",
    }

    def __init__(self, session: Any) -> None:
        super().__init__(session)
        self.code = Requests(session)

    def close(self) -> None:
        super().close()
        self.code.cancel()

    @order("share", link=orders.is_link)
    def sheet(self, link: str) -> None:
        """Send the Python lines of the run on screen, then the QR code of a link, which a worker draws."""
        send = partial(self.session.send, "shared", link=link, python=python_lines(self.session.pursuit.scene))
        send(qr="")
        if len(link) <= SCANNED:
            self.code.ask((tasks.qr_code, link), lambda drawn: send(qr=drawn or ""), private=True)

    @order("export", kind=FORMATS.__contains__)
    def export(self, kind: str) -> None:
        """Let a worker write the file of the run: `kind` is npz or json, one of each at a time."""
        call = tasks.file_of_run, self.session.pursuit.scene, kind
        if all(written != kind for *_, written in self.waiting):
            seconds = tasks.LONGEST_FILE + worker.SLOW
            self.add_one(call, partial(self._made, kind), rank=HEAVY, seconds=seconds, private=True)

    def _made(self, kind, made):
        body = b"" if isinstance(made, Exception) else made or b""
        why = LARGE if len(body) > LARGEST else "" if body else SLOW
        self.session.send("file", ending=kind, why=why, body=b"" if why else body)


def python_lines(scene: Scene) -> str:
    """Return the lines of Python that compute a run. For a measured surface they read the profile from its JSON."""
    usual = scene.differences(Scene())
    made = [f"{name}=" + ('float("inf")' if value == inf else repr(value)) for name, value in usual.items()]
    lines = ["from solver import Scene, load_path"]
    if scene.surface == "measured":
        made.append('measured=Profile(known["length"], known["heights"])')
        lines = ["import json; from solver import Profile, Scene, load_path"]
        lines += ['known = json.load(open("mixed-mode-contact.json"))["scene"]["measured"]']
    lines += [f"frames = list(load_path(Scene({', '.join(made)})))"]
    return "\n".join([*lines, 'print(len(frames), "increments, largest F", max(frame.F for frame in frames), "N/m")'])
