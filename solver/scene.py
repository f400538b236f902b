"""The experiment: every parameter of the paper, validated, and the lengths and moduli derived from them."""

import reprlib
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from math import ceil, e, floor, hypot, inf, pi, sqrt
from sys import float_info
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .schema import Choice, Points, Range, SceneError, number, parameters, path_points, unknown_name, word
from .surfaces import SURFACES, Profile, undeformed_gap

LARGEST_RUN = 200_000  # increments; a longer run is a mistake: the finest step allowed over 200 nm
SPACING = (0.05, 20.0)  # a/delta_t; finer lattices carry no friction, on coarser ones a node feels one site at most

LOADING, SURFACE, INTERFACE, LAYER = "Load path", "Surface", "Interface", "Layer"  # groups of parameters
SHAPES = {name: shape.meaning for name, shape in SURFACES.items()}
PATHS = {
    "shear": "approach, then shear",
    "unload": "approach, retraction and approach again at U_x = 0",
    "loop": "approach, then shear to u_x_max, back to -u_x_max, and forth again",
    "points": "straight lines between the points of the parameter `points`",
}
DAMPING = "damping of the motion through a slip; 1 is critical for the slowest mode, inf overdamped"
UNDERDAMPED = "with less, waves of the contact flutter and never come to rest"
# MPa/nm; the default layer has some 10 along x and 100 along z. A normal drive at the low end is a held load to 1e-5
STIFFNESS = 1e-6, 1e6, "MPa/nm"
LAWS = {
    "np1": "the paper's, whose resistance to shear grows with overclosure",
    "xu-needleman": "with a potential for phi_ratio 1; its resistance to shear falls with overclosure",
}
DEPTHS = -1.0, 100.0, "δ₀"  # of delta_bar; the surfaces are apart at -1
FAR = 1e4  # nm
POINTS = Points(
    (Range(-FAR, FAR, "nm", "", LOADING), Range(*DEPTHS, "", LOADING)),
    20,
    "points of the path; U_x (nm) and delta_bar of each, with semicolons between them",
    LOADING,
)
SET_BY_POINTS = "delta_bar", "u_x_max"  # parameters without effect on path 'points'
HOLDS = {"delta": "the indentation", "load": "the normal load reached by the approach; the indentation follows"}


class Leg(NamedTuple):
    """A straight line of the stage from one (U_x, delta) to another, nm, with the steps du_x and du_z, nm."""

    begin: tuple[float, float]
    end: tuple[float, float]
    du_x: float
    du_z: float

    @property
    def across(self) -> float:
        """Change of U_x, nm."""
        return self.end[0] - self.begin[0]

    @property
    def down(self) -> float:
        """Change of delta, nm."""
        return self.end[1] - self.begin[1]

    @property
    def increments(self) -> int:
        """Number of increments; the last one may be shorter."""
        return ceil(max(abs(self.across) / self.du_x, abs(self.down) / self.du_z) - 1e-9)


@dataclass(frozen=True)
class Scene:
    """Parameters of one experiment, in nm, GPa and N/m (paper section 2.3; our own defaults where it gives none).

    A number is declared by its default, lowest and highest value, unit, meaning and group; a word by its default,
    choices, meaning and group.

    Parameters: those that `python -m solver parameters` lists, each with a default.
    Raises SceneError for a value of the wrong type or outside its range, and for an impossible combination.

    Example: `Scene(delta_bar=0.2, surface="wave")`
    """

    delta_bar: float = number(0.0, *DEPTHS, "indentation depth δ over δ₀ = 10 δₙ", LOADING)
    path: str = word("shear", PATHS, "stages of the load path", LOADING)
    points: str = path_points("0,-1; 0,0.2; 8,0.2; 8,-1", POINTS)
    hold: str = word("delta", HOLDS, "what is held during shear", LOADING)
    u_x_max: float = number(40.0, 0.0, FAR, "nm", "largest tangential displacement of the stage", LOADING)
    drive_t: float = number(
        inf, *STIFFNESS, "stiffness of the drive along x, between stage and top", LOADING, unbounded=True
    )
    drive_n: float = number(
        inf, *STIFFNESS, "stiffness of the drive along z, between stage and top", LOADING, unbounded=True
    )
    damping: float = number(1.0, 0.2, 4.0, "", DAMPING, LOADING, unbounded=True, beyond=UNDERDAMPED)
    du_x: float = number(0.1, 1e-3, 1.0, "δₜ", "tangential increment of the shear", LOADING)
    du_z: float = number(0.1, 1e-3, 1.0, "δₙ", "normal increment of the approach", LOADING)
    tolerance: float = number(
        1e-8, 1e-12, 1e-3, "nm", "largest residual max |U + C T(u) - u| of a converged frame", LOADING
    )

    surface: str = word("circular", SHAPES, "undeformed profile of the surface", SURFACE)
    radius: float = number(2.5, 0.1, 1e3, "w", "radius R of the protrusion over the width w", SURFACE)
    amplitude: float = number(5.0, 1e-3, 1e4, "nm", "amplitude of the wave, half of crest to trough", SURFACE)
    waves: int = number(2, 1, 2048, "", "wavelengths of the wave over the width w, a whole number", SURFACE, whole=True)
    rms_slope: float = number(0.03, 1e-5, 0.1, "", "root mean square slope of the rough profile", SURFACE)
    hurst: float = number(0.8, 0.0, 1.0, "", "Hurst exponent H of the rough spectrum q^(-1-2H)", SURFACE)
    roll_off: float = number(0.5, 1e-4, 1.0, "w", "wavelength over w above which the rough spectrum is flat", SURFACE)
    cut_off: float = number(0.05, 1e-4, 1.0, "w", "shortest wavelength of the rough profile over w", SURFACE)
    seed: int = number(1, 0, 999999, "", "seed of the rough profile's phases, a whole number", SURFACE, whole=True)
    measured: Profile | None = None  # of surface 'measured'

    law: str = word("np1", LAWS, "cohesive law of a spring", INTERFACE)
    phi_n: float = number(2.0, 1e-3, 1e3, "N/m", "normal work of separation of one spring", INTERFACE)
    phi_ratio: float = number(1.0, 0.0, 100.0, "", "tangential over normal work of separation", INTERFACE)
    delta_n: float = number(1.0, 1e-2, 1e2, "nm", "normal characteristic length of the interface", INTERFACE)
    delta_t: float = number(1.0, 1e-2, 1e2, "nm", "tangential characteristic length of the interface", INTERFACE)
    window_t: float = number(5.0, 4.0, 20.0, "δₜ", "tangential half-width of the interaction window", INTERFACE)

    E: float = number(70.0, 1e-2, 1e6, "GPa", "Young's modulus of the layer", LAYER)
    nu: float = number(0.45, 0.0, 0.4999, "", "Poisson's ratio of the layer", LAYER)
    height: float = number(1.0, 1e-2, 1e2, "w", "height h of the layer over the width w", LAYER)
    width: float = number(2500.0, 1.0, 1e6, "nm", "width w of the periodic cell", LAYER)
    nodes: int = number(
        1024, 4, 16384, "", "surface nodes over the width; w / nodes is the lattice period", LAYER, True
    )

    def __new__(cls, *_: Any, **values: Any) -> "Scene":
        """Rejects a name that is no parameter with SceneError, where the generated __init__ has a bare TypeError."""
        for name in values.keys() - PARAMETERS.keys() - {"measured"}:
            raise unknown_name(name, (*PARAMETERS, "measured"))
        return super().__new__(cls)

    def __post_init__(self) -> None:
        for name, parameter in PARAMETERS.items():
            object.__setattr__(self, name, parameter.checked(name, getattr(self, name)))
        if not isinstance(self.measured, Profile | None):
            raise SceneError("measured", self.measured, "allowed: a Profile or None", "use solver.read_profile")
        if self.legs:
            depth = POINTS.read("points", self.points)[1][1]
            if self.delta_bar not in (depth, Scene.delta_bar):
                allowed = f"allowed with these points: {depth:g}, which they set"
                raise SceneError("delta_bar", self.delta_bar, allowed, "leave it out, or change points")
            object.__setattr__(self, "delta_bar", depth)
        for name, allowed, remedy in self._refusals():
            raise SceneError(name, getattr(self, name), allowed, remedy)

    def _refusals(self):
        """(parameter, what is allowed, remedy) of each impossible combination."""
        if refused := SURFACES[self.surface].refused(self):
            yield refused
        if self.path in ("unload", "points") and self.hold == "load":
            yield "hold", f"allowed with path {self.path!r}: delta", "choose path 'shear' or 'loop'"
        if self.path == "points" and not self._approaches():
            above = "two points or more, the first at delta_bar -1, the second at the same U_x: the approach"
            above += "; none the same as the one before"
            yield "points", f"allowed with path 'points': {above}", "write them as 0,-1; 0,0.2; 8,0.2"
        if self.hold == "load" and self.drive_n != inf:
            yield "drive_n", "allowed with hold 'load', where no spring acts: inf", "use drive_n=inf or hold=delta"
        thick = self.height * self.width
        if self.deepest >= thick:
            most = thick / self.delta_0
            shown = next(text for share in (1.0, 0.995) if float(text := f"{share * most:.3g}") <= most)  # rounded down
            through = f"where the top of a layer {thick:.3g} nm thick would be pressed through its bottom"
            yield (
                "delta_bar",
                f"allowed: below {shown}, {through}",
                "lower it, or enlarge height or width",
            )
        low, high = (limit * self.delta_t for limit in SPACING)
        if not low <= self.spacing <= high:
            remedy = "change nodes, width or delta_t"
            if self.surface == "measured":
                remedy = "give x and z of the profile in nm, or change nodes"
            spacing = f"node spacing width/nodes = {self.spacing:.4g} nm must lie within"
            yield "nodes", f"{spacing} {low:g} .. {high:g} nm", remedy
        yield from self._beyond_round_off()
        steps_of = ("du_x", self.shear_increments), ("du_z", self.approach_increments)
        if self.path == "points":
            steps_of = (("du_x", sum(leg.increments for leg in self.legs)),)
        for name, steps in steps_of:
            if steps > LARGEST_RUN:
                allowed = f"the run would take {steps} increments, at most {LARGEST_RUN} are allowed"
                yield name, allowed, f"enlarge {name} or shorten the run"

    def _beyond_round_off(self):
        """The refusal, as of `_refusals`, of residuals smaller than round-off, if these are asked for."""
        least, most = self.attainable, LIMITS["tolerance"].high
        soft = "drive_t, drive_n or E" if any(self.drive_compliance) else "E"
        if least > most:
            compliant = f"too compliant a layer: by round-off alone the residual is {least:.1g} nm"
            yield "E", f"{compliant}, more than any tolerance allowed", f"enlarge {soft}, or lower height"
        if self.tolerance < least:
            # rounded up, so that the value named is allowed
            allowed = f"allowed: {1.05 * least:.2g} .. {most:g} for so compliant a layer, by round-off"
            yield "tolerance", allowed, f"enlarge it, or {soft}"

    @property
    def attainable(self) -> float:
        """Smallest residual that double precision resolves, nm: round-off of u, amplified by the interface.

        A displacement u has the error eps u, its traction eps u times the interface's stiffness. These errors are
        independent from node to node. The layer multiplies them by the root mean square of its compliance over all
        modes, ((c^2 + 4 k (h/G)^2)/nodes)^1/2, with k the number of waves longer than h and c the compliance of layer
        and drive to a uniform traction. Flat on flat, all nodes share one error, but at a gap where the interface has a
        tenth of its largest stiffness.
        """
        stiffness = max(self.phi_n / self.delta_n**2, 2.0 * self.phi_t / self.delta_t**2)
        h, nu = self.height * self.width, self.nu
        long_waves = (3.0 - 4.0 * nu) / (8.0 * pi * (1.0 - nu)) / self.height
        layer, driven = h / self.shear_modulus, h / self.shear_modulus + max(self.drive_compliance)
        amplified = min(driven, hypot(driven, 2.0 * sqrt(long_waves) * layer) / sqrt(self.nodes))
        if self.surface == "flat":
            amplified = 0.1 * driven
        # how far adhesion can draw the surface down: the layer as a whole and a wave as long as the cell
        compliance = (1.0 - 2.0 * nu) / (2.0 * (1.0 - nu)) * h + min(h, long_waves * h)
        drawn = (compliance / self.shear_modulus + self.drive_compliance[1]) * self.phi_n / (e * self.delta_n)
        largest = self.farthest + self.delta_0 + abs(self.deepest) + min(drawn, 0.5 * float(self.profile.max()))
        # on soft scenes, the largest measured round-off of a residual is twice the estimate
        return 2.0 * float_info.epsilon * largest * stiffness * amplified

    def _approaches(self):
        """Whether the points begin with an approach, and none repeats the one before."""
        legs = self.legs
        return (
            bool(legs)
            and legs[0].begin[1] == -self.delta_0
            and not legs[0].across
            and all(leg.increments for leg in legs)
        )

    @cached_property
    def legs(self) -> tuple[Leg, ...]:
        """The straight lines of path 'points'; empty on another path."""
        if self.path != "points":
            return ()
        pairs = POINTS.read("points", self.points)
        corners = [(U_x, delta_bar * self.delta_0) for U_x, delta_bar in pairs]
        return tuple(Leg(begin, end, *self.steps) for begin, end in pairwise(corners))

    @property
    def steps(self) -> tuple[float, float]:
        """Increments of U_x and of delta, nm."""
        return self.du_x * self.delta_t, self.du_z * self.delta_n

    @property
    def spacing(self) -> float:
        """Node spacing a, nm: the period of both lattices."""
        return self.width / self.nodes

    @property
    def phi_t(self) -> float:
        """Tangential work of separation, N/m."""
        return self.phi_ratio * self.phi_n

    @property
    def shear_modulus(self) -> float:
        """G = E / (2 (1 + nu)), GPa."""
        return self.E / (2.0 * (1.0 + self.nu))

    @property
    def drive_compliance(self) -> tuple[float, float]:
        """Compliance of the drive along x and z, nm/GPa; 0 where it is rigid."""
        return 1e3 / self.drive_t, 1e3 / self.drive_n

    @property
    def shear_compliance(self) -> float:
        """h/G + 1/k_t, nm/GPa: of layer and drive to a uniform shear traction."""
        return self.height * self.width / self.shear_modulus + self.drive_compliance[0]

    @property
    def delta_0(self) -> float:
        """Initial distance of the surfaces, 10 delta_n, nm."""
        return 10.0 * self.delta_n

    @property
    def delta(self) -> float:
        """Indentation depth at the end of the approach, nm."""
        return self.delta_bar * self.delta_0

    @property
    def deepest(self) -> float:
        """Largest indentation depth of the path, nm."""
        return max((leg.end[1] for leg in self.legs), default=self.delta)

    @property
    def farthest(self) -> float:
        """Largest displacement of the stage along x, either way, nm."""
        return max((abs(leg.end[0]) for leg in self.legs), default=0.0 if self.path == "unload" else self.u_x_max)

    @property
    def approach_increments(self) -> int:
        """Increments from delta = -delta_0 to `delta`; the last one may be shorter."""
        return ceil((self.delta + self.delta_0) / (self.du_z * self.delta_n) - 1e-9)

    @property
    def shear_increments(self) -> int:
        """Whole increments from U_x = 0 to at most `farthest`, which is u_x_max where the stage is sheared."""
        return floor(self.farthest / (self.du_x * self.delta_t) + 1e-9)

    def shear_at(self, k: int) -> float:
        """U_x of shear increment k, nm."""
        return k * (self.du_x * self.delta_t)

    @property
    def x(self) -> NDArray[np.float64]:
        """Undeformed node positions, nm, shape (nodes,)."""
        return np.arange(self.nodes, dtype=float) * self.spacing

    @property
    def profile(self) -> NDArray[np.float64]:
        """Undeformed gap at delta = 0, nm, shape (nodes,); a new array."""
        return undeformed_gap(self).copy()

    def __repr__(self) -> str:
        values = self.differences() | ({"measured": self.measured} if self.measured else {})
        return f"Scene({', '.join(f'{name}={value!r}' for name, value in values.items())})"

    def changed(self, **values: Any) -> "Scene":
        """The same scene with other values; points set delta_bar anew, where they are given or were the path before."""
        if values.get("path", self.path) == "points" and ("points" in values or self.legs):
            values = {"delta_bar": Scene.delta_bar} | values
        return replace(self, **values)

    def differences(self, other: "Scene | None" = None) -> dict[str, Any]:
        """{parameter: value} where this scene differs from another, by default from Scene(); without `measured`."""
        other = other or Scene()
        return {name: getattr(self, name) for name in PARAMETERS if getattr(self, name) != getattr(other, name)}


def checked_scene(scene: object) -> Scene:
    """The scene itself; raises TypeError, which names what to pass, for what is none."""
    if isinstance(scene, Scene):
        return scene
    values = ", ".join(f"{name}={value!r}" for name, value in scene.items()) if isinstance(scene, dict) else ""
    raise TypeError(f"scene = {reprlib.repr(scene)}: allowed: a Scene; write Scene({values})")


def refuse_other(scene: Scene, of: Scene | None, what: str) -> None:
    """Raises SceneError where `of`, the scene that `what` belongs to, is another one; None belongs to any scene."""
    if of is None or of is scene or of == scene:
        return
    name = next(iter(scene.differences(of)), "measured")
    allowed = f"allowed with this {what}: {reprlib.repr(getattr(of, name))}"
    raise SceneError(name, getattr(scene, name), allowed, f"give the scene that the {what} belongs to")


PARAMETERS = parameters(Scene)  # {name: Range, Choice or Points}
LIMITS = {name: parameter for name, parameter in PARAMETERS.items() if isinstance(parameter, Range)}
CHOICES = {name: parameter.choices for name, parameter in PARAMETERS.items() if isinstance(parameter, Choice)}
