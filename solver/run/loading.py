"""The path of the rigid top under a load parameter."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Loading:
    """A straight path of the rigid top: (U_x, U_z) = base + load * direction, nm; the load only ever increases."""

    name: str  # of the load parameter, for messages: "delta" or "U_x", with a minus where these decrease
    base: tuple[float, float]
    direction: tuple[float, float]

    def at(self, load) -> tuple[float, float]:
        """(U_x, U_z) at that load, nm."""
        return self.base[0] + load * self.direction[0], self.base[1] + load * self.direction[1]

    def load_of(self, frame) -> float:
        """The load of a Frame on this path, nm."""
        (x, z), (along_x, along_z) = self.base, self.direction
        return along_x * (frame.U_x - x) + along_z * (-frame.delta - z)

    def coordinate(self, load) -> float:
        """U_x or delta, whichever changes along the path, at that load, nm."""
        U_x, U_z = self.at(load)
        return U_x if self.direction[0] else -U_z


def vertical(sign, U_x=0.0) -> Loading:
    """Lowering (sign 1) or raising (-1) the top at fixed U_x, nm: the load is sign delta."""
    return Loading("delta" if sign > 0.0 else "-delta", (U_x, 0.0), (0.0, -sign))


def sideways(sign, U_z) -> Loading:
    """Pulling the top along x (sign 1) or back (-1) at fixed U_z, nm: the load is sign U_x."""
    return Loading("U_x" if sign > 0.0 else "-U_x", (0.0, U_z), (sign, 0.0))
