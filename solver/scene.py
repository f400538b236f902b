"""The experiment: every parameter of the paper, validated, and the lengths and moduli derived from them."""

from dataclasses import dataclass, fields, replace
from math import ceil, floor, isfinite

import numpy as np

SURFACES = ("circular", "flat")

# name: (lowest, highest, unit, meaning). One place for validation, `--set`, the app's labels and its error messages.
LIMITS = {
    "delta_bar": (-1.0, 3.0, "10 δₙ", "indentation depth δ over δ₀ = 10 δₙ"),
    "phi_n": (1e-3, 1e3, "N/m", "normal work of separation of one spring"),
    "phi_ratio": (0.0, 100.0, "", "tangential over normal work of separation"),
    "E": (1e-2, 1e6, "GPa", "Young's modulus of the layer"),
    "nu": (0.0, 0.4999, "", "Poisson's ratio of the layer"),
    "delta_n": (1e-2, 1e2, "nm", "normal characteristic length of the interface"),
    "delta_t": (1e-2, 1e2, "nm", "tangential characteristic length of the interface"),
    "width": (1.0, 1e6, "nm", "width w of the periodic cell"),
    "nodes": (4, 16384, "", "surface nodes over the width; the node spacing is the lattice period"),
    "height": (1e-2, 1e2, "w", "height h of the layer over the width w"),
    "radius": (0.1, 1e3, "w", "radius R of the protrusion over the width w"),
    "window_n": (4.0, 40.0, "δₙ", "normal extent of the interaction window"),
    "window_t": (4.0, 20.0, "δₜ", "tangential half-width of the interaction window"),
    "du_z": (1e-3, 1.0, "δₙ", "normal increment of the approach"),
    "du_x": (1e-3, 1.0, "δₜ", "tangential increment of the shear"),
    "u_x_max": (0.0, 1e4, "nm", "largest tangential displacement of the top"),
    "tolerance": (1e-12, 1e-3, "nm", "largest residual max |U + C T(u) - u| of a converged frame"),
}
EPSILON = 2.2e-16  # round-off of double precision
LARGEST_RUN = 200_000  # increments; beyond this a run is a mistake, not an experiment
SPACING = (0.05, 20.0)  # a/delta_t: finer lattices carry no friction, coarser ones no lattice sum


class SceneError(ValueError):
    """A parameter out of its range; the message names it, its value, the range and the remedy."""

    def __init__(self, name, value, allowed, remedy):
        self.name = name
        super().__init__(f"{name} = {value!r}: {allowed}; {remedy}")


@dataclass(frozen=True)
class Scene:
    """Parameters of one experiment, in nm, GPa and N/m (paper section 2.3; defaults where it is silent are ours).

    Raises SceneError when built with a value outside LIMITS, of the wrong type, or with an impossible combination.
    """

    surface: str = "circular"  # undeformed profile: 'circular' protrusion or 'flat'
    delta_bar: float = 0.0  # indentation over delta_0 = 10 delta_n
    phi_n: float = 2.0  # N/m
    phi_ratio: float = 1.0  # phi_t / phi_n
    E: float = 70.0  # GPa
    nu: float = 0.45
    delta_n: float = 1.0  # nm
    delta_t: float = 1.0  # nm
    width: float = 2500.0  # nm
    nodes: int = 1024
    height: float = 1.0  # h / w
    radius: float = 2.5  # R / w
    window_n: float = 10.0  # in delta_n
    window_t: float = 5.0  # in delta_t, half-width
    du_z: float = 0.1  # in delta_n
    du_x: float = 0.1  # in delta_t
    u_x_max: float = 40.0  # nm
    tolerance: float = 1e-8  # nm

    def __post_init__(self):
        if self.surface not in SURFACES:
            raise SceneError("surface", self.surface, f"allowed: {', '.join(SURFACES)}", "choose one of them")
        for name, (low, high, _, _) in LIMITS.items():
            object.__setattr__(self, name, _number(name, getattr(self, name), low, high))
        if self.tolerance < self.attainable:
            raise SceneError(
                "tolerance",
                self.tolerance,
                f"allowed: {self.attainable:.1g} .. {LIMITS['tolerance'][1]:g} for so compliant a layer, by round-off",
                "enlarge it, or E",
            )
        ratio = self.spacing / self.delta_t
        if not SPACING[0] <= ratio <= SPACING[1]:
            raise SceneError(
                "nodes",
                self.nodes,
                f"node spacing width/nodes = {self.spacing:.4g} nm must lie within"
                f" {SPACING[0] * self.delta_t:g} .. {SPACING[1] * self.delta_t:g} nm",
                "change nodes, width or delta_t",
            )
        for name, steps in (("du_x", self.shear_increments), ("du_z", self.approach_increments)):
            if steps > LARGEST_RUN:
                raise SceneError(
                    name,
                    getattr(self, name),
                    f"the run would take {steps} increments, at most {LARGEST_RUN} are allowed",
                    f"enlarge {name} or shorten the run",
                )

    @property
    def attainable(self):
        """Smallest residual that double precision can tell from none, nm: round-off of u, seen through the interface.

        A displacement u known to eps u makes a traction error of the interface's stiffness times that, and the layer as
        a whole answers with h/G times the traction; a tenth of it, as never all of the surface is in contact.
        """
        stiffness = max(self.phi_n / self.delta_n**2, 2.0 * self.phi_t / self.delta_t**2)
        largest = self.u_x_max + self.delta_0 + abs(self.delta)
        return 0.1 * EPSILON * largest * stiffness * self.height * self.width / self.shear_modulus

    @property
    def spacing(self):
        """Node spacing a, nm: the period of both lattices."""
        return self.width / self.nodes

    @property
    def phi_t(self):
        """Tangential work of separation, N/m."""
        return self.phi_ratio * self.phi_n

    @property
    def shear_modulus(self):
        """G = E / (2 (1 + nu)), GPa."""
        return self.E / (2.0 * (1.0 + self.nu))

    @property
    def delta_0(self):
        """Initial distance of the surfaces, 10 delta_n, nm."""
        return 10.0 * self.delta_n

    @property
    def delta(self):
        """Indentation depth aimed at, nm."""
        return self.delta_bar * self.delta_0

    @property
    def approach_increments(self):
        return ceil((self.delta + self.delta_0) / (self.du_z * self.delta_n) - 1e-9)

    @property
    def shear_increments(self):
        return floor(self.u_x_max / (self.du_x * self.delta_t) + 1e-9)

    def approach_at(self, k):
        """Indentation of approach increment k, nm; the last one is exactly `delta`."""
        return min(self.delta, k * self.du_z * self.delta_n - self.delta_0)

    def shear_at(self, k):
        """U_x of shear increment k, nm."""
        return k * self.du_x * self.delta_t

    @property
    def x(self):
        """Undeformed node positions, nm, shape (nodes,)."""
        return np.arange(self.nodes) * self.spacing

    @property
    def profile(self):
        """Undeformed gap at delta = 0, nm, shape (nodes,)."""
        if self.surface == "flat":
            return np.zeros(self.nodes)
        from_middle = (np.arange(self.nodes) - self.nodes / 2) * self.spacing  # even to the last bit
        return from_middle**2 / (2.0 * self.radius * self.width)

    def changed(self, **values):
        """The same scene with other values."""
        return replace(self, **values)


def _number(name, value, low, high):
    whole = name == "nodes"
    allowed = f"allowed: {low:g} .. {high:g}"
    kind = "a whole number" if whole else "a number"
    if isinstance(value, (bool, str, bytes)):
        raise SceneError(name, value, allowed, f"give {kind} in that range")
    try:
        number = float(value)
    except (TypeError, ValueError, OverflowError):
        raise SceneError(name, value, allowed, f"give {kind} in that range") from None
    if not isfinite(number) or not low <= number <= high or (whole and number != int(number)):
        raise SceneError(name, value, allowed, f"give {kind} in that range")
    return int(number) if whole else number


def scene_from_text(pairs):
    """A Scene from {'name': 'text'}, as the command line and the page's address give it; raises SceneError."""
    names = [f.name for f in fields(Scene)]
    values = {}
    for name, text in pairs.items():
        if name not in names:
            raise SceneError("name", name, f"allowed: {', '.join(names)}", "use one of these names")
        values[name] = text if name == "surface" else _parsed(name, text)
    return Scene(**values)


def _parsed(name, text):
    try:
        return float(text)
    except ValueError:
        low, high = LIMITS[name][:2]
        raise SceneError(name, text, f"allowed: {low:g} .. {high:g}", "give a number in that range") from None
