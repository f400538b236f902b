"""The page "Inside the solid": the stress in the layer above the contact, for the increment on screen.

A worker makes the picture from the tractions that were sent to the browser, at the resolution of the picture; at most
one is in the making, and the latest increment asked for wins. Stress is sent as int16 of its own scale.
"""

import json
import struct
from concurrent.futures import CancelledError

import holoviews as hv
import numpy as np
from bokeh.palettes import cividis

from app.schema import STRESSES
from app.service import tasks
from app.views.pages import Sheet
from app.views.plots import rendered
from solver.isolated import Lost

SIZE = (400, 150)  # columns, rows
DEPTH = 1.0  # of half the width shown
NODE = hv.Dimension("x", label="x in the punch, undeformed", unit="nm")  # where it was in the undeformed layer
PER_FRINGE = (0.01, 1.0)  # GPa


def compose():
    """The picture, and over it the mesh of lines that deforms with the layer."""
    z = hv.Dimension("z", label="height z in the layer", unit="nm")
    blank = np.zeros((2, 2), dtype=np.float32)
    image = hv.Image(blank, [NODE, z], "stress", bounds=(0, 0, 1, 1), label="field")
    tip = [("x", "$x{0} nm"), ("z", "$y{0} nm"), ("", "@image{0.000}")]
    image.opts(default_tools=[], tools=["hover"], hover_tooltips=tip)
    lines = hv.Curve(([], []), NODE, z, label="mesh").opts(default_tools=[], line_width=1, alpha=0.7)
    return [rendered("solid_field", [image, lines], {"mesh": "--text"}, x=(-250, 250), y=(0, 250))]


class Page(Sheet):
    """See pages.py."""

    def __init__(self, *given):
        super().__init__(*given)
        self.task, self.waiting, self.about = None, None, None

    def start(self):
        """The browser asks for the first picture as soon as it has a frame."""
        self.publish(palette=list(cividis(256)), stresses={name: vars(stress) for name, stress in STRESSES.items()})

    def order(self, values):
        """Show a frame: {run, frame, half (nm), quantity, per_fringe (GPa), mesh}."""
        if values.keys() >= {"run", "frame", "half", "quantity", "per_fringe", "mesh"}:
            self.waiting = values
            self._submit()

    def close(self):
        """Ask for nothing any longer."""
        self.waiting = None
        if self.task is not None:
            self.session.pool.abandon(self.task)
            self.task = None

    def _submit(self):
        if self.task is not None or self.waiting is None:
            return
        values, self.waiting = self.waiting, None
        run = self.session.run
        if run is None or int(values.get("run", -1)) != run.number:
            return
        found = run.tractions(int(values["frame"]), self.session.shelf)
        if found is None:
            return
        scene, (first, traction) = run.scene, found
        half = float(np.clip(float(values["half"]), scene.spacing, 0.5 * scene.width))
        thickness = scene.height * scene.width
        window = (0.5 * scene.width - half, 0.5 * scene.width + half, min(DEPTH * half, thickness))
        quantity = values["quantity"] if values["quantity"] in STRESSES else next(iter(STRESSES))
        per_fringe = float(np.clip(float(values["per_fringe"]), *PER_FRINGE))
        self.about = {"run": values["run"], "frame": values["frame"], "quantity": quantity}
        call = (tasks.stress_picture, scene, first, traction, quantity, window, SIZE, per_fringe, bool(values["mesh"]))
        self.task = self.session.pool.submit(*call, near=self.session.computing.last, owner=id(self.session))
        self.session.when_done(self.task, self._take)

    def _take(self, task):
        """A picture is back: show it, and ask for the one wanted since."""
        if task is not self.task:
            return
        self.task = None
        try:
            head, body = task.result()
        except (Lost, CancelledError):  # the next frame brings another
            return
        packed = json.dumps(head | self.about).encode()
        packed += b" " * (-len(packed) % 4)
        self.session.wire.picture = struct.pack("<I", len(packed)) + packed + body
        self._submit()
