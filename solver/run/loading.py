"""The path of the rigid top under a load parameter."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Loading:
    """A straight path of the rigid top: (U_x, U_z) = base + load * direction, nm; the load only ever increases."""

    name: str  # of the load parameter, for messages: "delta" or "U_x", with a minus where that falls
    base: tuple
    direction: tuple

    def at(self, load):
        """(U_x, U_z) at that load, nm."""
        return self.base[0] + load * self.direction[0], self.base[1] + load * self.direction[1]

    def coordinate(self, load):
        """U_x or delta, whichever changes along the path, at that load, nm."""
        U_x, U_z = self.at(load)
        return U_x if self.direction[0] else -U_z


def approach():
    """Lowering the top: the load is delta."""
    return Loading("delta", (0.0, 0.0), (0.0, -1.0))


def shear(scene):
    """Pulling the top sideways at the scene's indentation: the load is U_x."""
    return Loading("U_x", (0.0, -scene.delta), (1.0, 0.0))
