"""The model through which server and browser of one visitor exchange data."""

from bokeh.core.properties import Bytes, Either, Nullable, String
from bokeh.model import DataModel

from app.service import packing


class Wire(DataModel):
    """The data between server and browser: `order` goes to the server, all else to the browser."""

    message = Nullable(Bytes)  # a JSON header with its kind, then numbers: see `packing.headed`
    status = String(default="{}")
    page = String(default="{}")  # JSON about the open page beside the experiment
    order = Either(String, Bytes, default="")  # read by `session.orders`

    def send(self, kind, body=b"", **head):
        """Send a message of this kind, with `head` in its header."""
        self.deliver(packing.headed({"kind": kind} | head, body))

    def deliver(self, message):
        """Send a message with its header. The property is cleared, so that an equal message can follow."""
        self.message = message
        self.message = None
