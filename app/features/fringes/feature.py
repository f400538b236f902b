"""Fringes: the stress inside the punch, as photoelastic fringes or as one component with its sign."""

from dataclasses import asdict, dataclass
from typing import Any

from app import interface
from app.features.fringes import tasks
from app.session import orders
from app.session.orders import order

GEOMETRY = ("nu", "height", "width", "nodes")  # the parameters that the table of a layer depends on
TABLES = 2  # tables that a visitor may wait for
ROWS, MODES, DEPTH = (16, 120), (16, 1024), (1.0, 1e6)  # ranges that a browser may request; DEPTH in nm


@dataclass(frozen=True)
class Stress:
    """A stress in the punch: its choice, its symbol, and the words and colours of its negative and positive values."""

    choice: str
    symbol: str
    below: str
    above: str
    below_colour: str = "--push-1"
    above_colour: str = "--pull-1"


STRESSES = {  # in the punch, beside the fringes; its shear at the surface is the traction that holds back
    "zz": Stress("vertical stress σ_zz", "σ_zz", "squeezed", "stretched"),
    "xx": Stress("sideways stress σ_xx", "σ_xx", "squeezed", "stretched"),
    "xz": Stress("shear stress τ", "τ", "pulls on", "holds back", "--slip", "--shear"),
}


class Feature(interface.Feature):
    """Tables that turn tractions into stress inside the layer, one per geometry; the browser draws with them."""

    ORDER = 10
    PARAMS = {
        "layer": "asks for a table of the layer: rows, modes, depth (nm)",
        "table": "a table from tractions to stress in the layer: asked, geometry, depth, counts, scale, body",
    }

    @classmethod
    def declared(cls, root: str) -> dict[str, Any]:
        return {"stresses": {name: asdict(stress) for name, stress in STRESSES.items()}}

    @order("layer", rows=orders.is_number, modes=orders.is_number, depth=orders.is_number)
    def request(self, rows: Any, modes: int, depth: float) -> None:
        """Send the table for the run on screen: {rows, modes, depth (nm) of the last row}.

        A browser repeats its request while it waits. That must not start the work again.
        """
        run = self.session.run
        if run is None:
            return
        scene = run.scene
        asked = {"rows": rows, "modes": modes, "depth": depth}
        rows = int(min(max(rows, ROWS[0]), ROWS[1]))
        modes = int(min(max(modes, MODES[0]), MODES[1], scene.nodes // 2))
        depth = min(max(depth, DEPTH[0]), DEPTH[1], scene.height * scene.width)
        head = {"asked": asked, "depth": depth, "geometry": [getattr(scene, name) for name in GEOMETRY]}
        call = tasks.layer_table, scene, depth, rows, modes
        if len(self.waiting) >= TABLES and call not in self.waiting:
            self.cancel()
        self.add_one(call, lambda made: self._made(made, head))

    def _made(self, made, head):
        if not isinstance(made, Exception):  # without a table the browser draws nothing
            counts, scale, body = made
            self.session.send("table", counts=counts, scale=scale, body=body, **head)
