"""What passes between server and browser of one visitor."""

import struct
from math import nan

from bokeh.core.properties import Bytes, Either, Nullable, String
from bokeh.model import DataModel

from app.service import packing


class Wire(DataModel):
    """What passes between server and browser: packed frames and status to the browser, orders (JSON) from it."""

    chunk = Nullable(Bytes)
    status = String(default="{}")
    page = String(default="{}")  # JSON, about the page beside the experiment that is open
    layer = Nullable(Bytes)  # JSON header and a table for the stress inside the layer, by `session.aside`
    hand = Nullable(Bytes)  # a picture that follows the hand on a slider: what `service.following` makes, and a number
    taken = Nullable(Bytes)  # JSON header and a file, when something is taken away
    order = Either(String, Bytes, default="")  # what `session.orders` reads

    def send(self, run, blocks):
        """Packed blocks, as those of the visitor's run of that number."""
        for block in blocks:
            self.chunk = packing.numbered(run, block)

    def follow(self, picture, number):
        """A picture that follows a held slider; number: of the order that it answers."""
        self.hand = struct.pack("<d", nan if number is None else number) + picture
