"""What passes between server and browser of one visitor."""

from bokeh.core.properties import Bytes, Either, Nullable, String
from bokeh.model import DataModel

from app.service import packing


class Wire(DataModel):
    """What passes between server and browser of one visitor: orders (JSON) to the server, all else to the browser."""

    message = Nullable(Bytes)  # a JSON header with its kind, then numbers, as of `packing.headed`
    status = String(default="{}")
    page = String(default="{}")  # JSON, about the page beside the experiment that is open
    order = Either(String, Bytes, default="")  # what `session.orders` reads

    def send(self, kind, body=b"", **head):
        """Send a message of that kind, with more in its header."""
        self.deliver(packing.headed({"kind": kind} | head, body))

    def deliver(self, message):
        """Send a message with its header; it does not stay here, so that the same may be sent again."""
        self.message = message
        self.message = None
