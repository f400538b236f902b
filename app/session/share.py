"""Exports of a run: a link as a QR code, Python lines, and the files that the command line writes."""

from functools import partial
from math import inf

from app.service import tasks
from app.service.pool import LATER
from app.service.requests import Requests
from app.session import orders
from app.session.orders import order
from solver import Scene

SCANNED = 1200  # characters of a link; with more, a QR code is too fine for a phone at the back of a classroom
LONG = 60.0  # s, time limit for a file
LARGEST = 20e6  # bytes of a file
LARGE = "it would be larger than 20 MB: use python -m solver run"
SLOW = "it takes too long here: use python -m solver run"


class Share(Requests):
    """The exports of one visitor. Every method runs under the lock of the document."""

    def __init__(self, session):
        super().__init__(session)
        self.code = Requests(session)

    @order("share", link=orders.is_link)
    def sheet(self, link):
        """Send the Python lines of the run on screen, then the QR code of a link, which a worker draws."""
        send = partial(self.session.send, "sheet", link=link, python=python_lines(self.session.pursuit.legs))
        send(qr="")
        if len(link) <= SCANNED:
            self.code.ask((tasks.qr_code, link), lambda drawn: send(qr=drawn or ""))

    @order("export", kind=orders.FORMATS.__contains__)
    def export(self, kind):
        """Let a worker write the file of the run: `kind` is npz or json."""
        call = (tasks.file_of_run, self.session.pursuit.legs, kind)
        self.add_one(call, lambda made: self._made(made, kind), rank=LATER, seconds=LONG)

    def _made(self, made, kind):
        body = b"" if isinstance(made, Exception) else made
        why = LARGE if len(body) > LARGEST else "" if body else SLOW
        self.session.send("file", ending=kind, why=why, body=b"" if why else body)


def python_lines(legs):
    """Return the lines of Python that compute a run, given by its legs as in `solver.carried_path`.

    For a measured surface they read the profile from the run's JSON.
    """
    first, path = legs[0][0], "load_path" if len(legs) == 1 else "carried_path"
    made = _arguments(first, Scene())
    lines = [f"from solver import Scene, {path}"]
    if first.surface == "measured":
        made.append('measured=Profile(known["length"], known["heights"])')
        lines = [f"import json; from solver import Profile, Scene, {path}"]
        lines += ['known = json.load(open("mixed-mode-contact.json"))["scene"]["measured"]']
    what = f"Scene({', '.join(made)})"
    if len(legs) > 1:
        parts = [f"(scene, {legs[0][1]})"]
        parts += [f"(scene.changed({', '.join(_arguments(scene, first))}), {count})" for scene, count in legs[1:]]
        lines += [f"scene = {what}", f"legs = [{', '.join(parts)}]"]
        what = "legs"
    last = 'print(len(frames), "increments, largest F", max(frame.F for frame in frames), "N/m")'
    return "\n".join([*lines, f"frames = list({path}({what}))", last])


def _arguments(scene, usual):
    """Return ["name=value", ...] of the differences between two scenes, without the profile of a measured surface."""
    values = scene.differences(usual)
    return [f"{name}=" + ('float("inf")' if value == inf else repr(value)) for name, value in values.items()]
