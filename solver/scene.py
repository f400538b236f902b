"""The experiment: every parameter of the paper, validated, and the lengths and moduli derived from them."""

from dataclasses import dataclass, fields, replace
from math import ceil, e, floor, inf, isfinite, pi, sqrt

import numpy as np

from .surfaces import SURFACES, Profile, refusal, undeformed_gap

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
    "amplitude": (1e-3, 1e4, "nm", "amplitude of the wave, half its height from crest to trough"),
    "waves": (1, 2048, "", "wavelengths of the wave over the width w, a whole number"),
    "rms_slope": (1e-5, 0.1, "", "root mean square slope of the rough profile"),
    "hurst": (0.0, 1.0, "", "Hurst exponent H of the rough profile, its spectrum falls as q^(-1-2H)"),
    "roll_off": (1e-4, 1.0, "w", "wavelength over w from which on, upwards, the rough spectrum is flat"),
    "cut_off": (1e-4, 1.0, "w", "shortest wavelength of the rough profile over w"),
    "seed": (0, 999999, "", "which of all rough profiles of that spectrum, a whole number"),
    "window_n": (4.0, 40.0, "δₙ", "normal extent of the interaction window"),
    "window_t": (4.0, 20.0, "δₜ", "tangential half-width of the interaction window"),
    "du_z": (1e-3, 1.0, "δₙ", "normal increment of the approach"),
    "du_x": (1e-3, 1.0, "δₜ", "tangential increment of the shear"),
    "u_x_max": (0.0, 1e4, "nm", "largest tangential displacement of the top"),
    "damping": (
        0.05,
        4.0,
        "",
        "damping of the motion through a slip; 1 is critical for the slowest mode, inf overdamped",
    ),
    "tolerance": (1e-12, 1e-3, "nm", "largest residual max |U + C T(u) - u| of a converged frame"),
}
PATHS = {
    "shear": "approach, then shear",
    "unload": "approach, retraction and approach again at U_x = 0",
    "loop": "approach, then shear to u_x_max, back to -u_x_max, and forth again",
}
HOLDS = {"delta": "the indentation", "load": "the normal load reached by the approach; the indentation follows"}
# name: {choice: meaning}, of the parameters that are words
CHOICES = {"surface": SURFACES, "path": PATHS, "hold": HOLDS}
EPSILON = 2.2e-16  # round-off of double precision
ROUNDINGS = 2.0  # that add up in a residual, over what `Scene.attainable` estimates; measured on soft scenes
LARGEST_RUN = 200_000  # increments; beyond this a run is a mistake, not an experiment
WHOLE = ("nodes", "waves", "seed")
UNBOUNDED = ("damping",)  # may be infinite as well
SPACING = (0.05, 20.0)  # a/delta_t: finer lattices carry no friction, coarser ones no lattice sum


class SceneError(ValueError):
    """A parameter out of its range; the message names it, its value, the range and the remedy."""

    def __init__(self, name, value, allowed, remedy):
        self.name = name
        self._given = name, value, allowed, remedy
        super().__init__(f"{name} = {value!r}: {allowed}; {remedy}")

    def __reduce__(self):  # by default it would be made from its message alone, and a worker that raises it be lost
        return SceneError, self._given


@dataclass(frozen=True)
class Scene:
    """Parameters of one experiment, in nm, GPa and N/m (paper section 2.3; defaults where it is silent are ours).

    Raises SceneError when built with a value outside LIMITS, of the wrong type, or with an impossible combination.
    """

    surface: str = "circular"  # undeformed profile, one of SURFACES
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
    amplitude: float = 5.0  # nm
    waves: int = 2
    rms_slope: float = 0.03
    hurst: float = 0.8
    roll_off: float = 0.5  # in w
    cut_off: float = 0.05  # in w
    seed: int = 1
    measured: Profile | None = None  # what surface 'measured' shows
    window_n: float = 10.0  # in delta_n
    window_t: float = 5.0  # in delta_t, half-width
    du_z: float = 0.1  # in delta_n
    du_x: float = 0.1  # in delta_t
    u_x_max: float = 40.0  # nm
    path: str = "shear"  # one of PATHS
    hold: str = "delta"  # during shear, one of HOLDS
    damping: float = 1.0  # of slips, in units of critical for the slowest mode
    tolerance: float = 1e-8  # nm

    def __post_init__(self):
        for name, choices in CHOICES.items():
            if getattr(self, name) not in tuple(choices):
                raise SceneError(name, getattr(self, name), f"allowed: {', '.join(choices)}", "choose one of them")
        for name, (low, high, _, _) in LIMITS.items():
            object.__setattr__(self, name, _number(name, getattr(self, name), low, high))
        if not isinstance(self.measured, Profile | None):
            raise SceneError("measured", self.measured, "allowed: a Profile or None", "use solver.read_profile")
        if refused := refusal(self):
            raise SceneError(refused[0], getattr(self, refused[0]), *refused[1:])
        if self.path == "unload" and self.hold == "load":
            raise SceneError("hold", self.hold, "allowed with path 'unload': delta", "choose path 'shear' or 'loop'")
        if self.delta >= self.height * self.width:
            raise SceneError(
                "delta_bar",
                self.delta_bar,
                f"allowed: below {self.height * self.width / self.delta_0:.3g}, where the top of a layer"
                f" {self.height * self.width:.3g} nm thick would be pressed through its bottom",
                "lower it, or enlarge height or width",
            )
        if self.attainable > LIMITS["tolerance"][1]:
            raise SceneError(
                "E",
                self.E,
                f"too compliant a layer: by round-off alone the residual is {self.attainable:.1g} nm, more than any"
                " tolerance allowed",
                "enlarge it, or lower height",
            )
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

        A displacement u known to eps u makes a traction error of the interface's stiffness times that; errors of the
        nodes are independent, so the layer answers to all of them with the root mean square of its compliance over the
        modes, (h/G) ((1 + 4 k)/nodes)^1/2 with k the number of waves longer than h. Flat on flat they are all alike,
        but only one unknown is to be rounded, at a gap where the interface is a tenth as stiff as it can be.
        """
        stiffness = max(self.phi_n / self.delta_n**2, 2.0 * self.phi_t / self.delta_t**2)
        h, nu = self.height * self.width, self.nu
        long_waves = (3.0 - 4.0 * nu) / (8.0 * pi * (1.0 - nu)) / self.height
        share = 0.1 if self.surface == "flat" else min(1.0, sqrt((1.0 + 4.0 * long_waves) / self.nodes))
        # adhesion draws the surface towards the other one: the layer as a whole, or a wave as long as the cell
        compliance = (1.0 - 2.0 * nu) / (2.0 * (1.0 - nu)) * h + min(h, long_waves * h)
        drawn = compliance / self.shear_modulus * self.phi_n / (e * self.delta_n)
        largest = self.u_x_max + self.delta_0 + abs(self.delta) + min(drawn, 0.5 * float(self.profile.max()))
        return ROUNDINGS * EPSILON * largest * stiffness * h / self.shear_modulus * share

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
        """Undeformed gap at delta = 0, nm, shape (nodes,); a new array."""
        return undeformed_gap(self)

    def changed(self, **values):
        """The same scene with other values."""
        return replace(self, **values)


def _number(name, value, low, high):
    whole = name in WHOLE
    allowed = f"allowed: {low:g} .. {high:g}" + (" or inf" if name in UNBOUNDED else "")
    kind = "a whole number" if whole else "a number"
    if isinstance(value, (bool, str, bytes)):
        raise SceneError(name, value, allowed, f"give {kind} in that range")
    try:
        number = float(value)
    except (TypeError, ValueError, OverflowError):
        raise SceneError(name, value, allowed, f"give {kind} in that range") from None
    if name in UNBOUNDED and number == inf:
        return number
    if not isfinite(number) or not low <= number <= high or (whole and number != int(number)):
        raise SceneError(name, value, allowed, f"give {kind} in that range")
    return int(number) if whole else number


def changes(scene):
    """'name=value ...' of what differs from the default, as `--set` takes it; a measured profile as profile=FILE."""
    own, usual = vars(scene), vars(Scene())
    changed = {name: value for name, value in own.items() if value != usual[name]}
    if changed.pop("measured", None):
        changed["profile"] = "FILE"
    return " ".join(f"{name}={value}" for name, value in changed.items())


def scene_from_text(pairs, profile=None):
    """A Scene from {'name': 'text'}, as the command line and the page's address give it; raises SceneError.

    profile: a measured Profile; the scene then shows it, over its own length, unless `pairs` say otherwise.
    """
    names = [f.name for f in fields(Scene) if f.name != "measured"]
    values = {"surface": "measured", "width": profile.length, "measured": profile} if profile else {}
    for name, text in pairs.items():
        if name not in names:
            raise SceneError("name", name, f"allowed: {', '.join(names)}", "use one of these names")
        values[name] = text if name in CHOICES else number_from_text(name, text)
    return Scene(**values)


def number_from_text(name, text):
    """The number that `text` gives for parameter `name`; raises SceneError where it is none."""
    try:
        return float(text)
    except ValueError:
        low, high = LIMITS[name][:2]
        raise SceneError(name, text, f"allowed: {low:g} .. {high:g}", "give a number in that range") from None
