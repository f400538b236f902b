"""How tractions make up the stress inside the layer: a table for each geometry, for what a browser draws of it."""

from app.service import packing, tasks
from app.service.wanted import Wanted

GEOMETRY = ("nu", "height", "width", "nodes")  # of a scene, all that the table depends on
ROWS, MODES, DEPTH = (16, 120), (16, 1024), (1.0, 1e6)  # that a browser may ask for; nm


class Layer(Wanted):
    """The table that the visitor waits for; every method runs under the lock of the document."""

    def want(self, values):
        """Send the table for the run on screen: {rows, modes, depth (nm) of the last row}."""
        run = self.session.run
        if run is None:
            return
        scene, rows = run.scene, int(min(max(values["rows"], ROWS[0]), ROWS[1]))
        modes = int(min(max(values["modes"], MODES[0]), MODES[1], run.scene.nodes // 2))
        depth = min(max(values["depth"], DEPTH[0]), DEPTH[1], scene.height * scene.width)
        head = {"asked": values, "depth": depth, "geometry": [getattr(scene, name) for name in GEOMETRY]}
        self.ask((tasks.layer_table, scene, depth, rows, modes), lambda made: self._take(made, head))

    def _take(self, made, head):
        if made is not None:  # otherwise nothing is drawn
            counts, body = made
            self.session.wire.layer = packing.headed(head | {"counts": counts}, body)
