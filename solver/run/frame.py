"""The report of an increment: displacements and tractions of the patch, forces, contact area."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..continuation.compiled import kernel
from ..continuation.rest import DENSE_WAVES
from ..mechanics.flutter import safe_damping
from ..scene import Scene

STAGES = {  # {kind of a stage: what changes along it, and which way}
    "approach": ("delta", 1.0),
    "shear": ("U_x", 1.0),
    "back": ("U_x", -1.0),
    "forth": ("U_x", 1.0),
    "unload": ("delta", -1.0),
    "reload": ("delta", 1.0),
    "move": ("U_x", 1.0),  # with delta, along an oblique line
}

# A node is in contact if T_z over phi_n/delta_n exceeds this. On a curved surface that separates zero from round-off.
# On a flat at dn = 0 all nodes share one error of dn, up to the largest tolerance allowed, so the bound is higher.
CONTACT, CONTACT_OF_FLATS = 1e-8, 1e-3

SAMPLE = 8  # frames, in which the safe damping changes by less than 0.05 along a branch; computing one takes 0.2 ms


class Stage(str):
    """A stage of the load path, as text: "shear", or "2 shear" with its number on path "points"."""

    def __new__(cls, kind: str, number: int = 0) -> "Stage":
        """kind: a key of STAGES; number: of a stage of path "points", 0 for another path."""
        return super().__new__(cls, f"{number} {kind}" if number else kind)

    @property
    def kind(self) -> str:
        """The stage without its number."""
        return self.split(" ")[-1]

    @property
    def moves(self) -> str:
        """What changes along the stage, "U_x" or "delta": the load of its SlipEvents."""
        return STAGES[self.kind][0]


@dataclass(frozen=True)
class SlipEvent:
    """The end of a branch: load U_x (or delta, in approach and retraction) in nm, and F_bar, L_bar, A_bar just before.

    kind: as of `continuation.state.End`. located: whether the load is that of the end itself, to 1e-6 nm, or only that
    of the increment in which it lies. Where a symmetric contact tilts, it is so to 1e-3 nm: there the residual hardly
    tells the states of both branches apart. sensitive: motions with other time steps, or from another start, came to
    rest elsewhere, or a symmetric contact may leave the branch either way: then it moves along x.

    Example: `[event.load for frame in simulate(Scene()).frames for event in frame.slips]`
    """

    load: float
    F_bar: float
    L_bar: float
    A_bar: float
    stage: str = ""
    kind: str = "fold"
    located: bool = True
    sensitive: bool = False


@dataclass(frozen=True, eq=False, repr=False)
class Frame:
    """One converged increment (paper Eq. 6 for the forces). Frames are equal only if they are the same object.

    Example: `simulate(Scene()).frames[-1].F`

    u, T: (2, m) displacement (nm) and traction on the layer (GPa) of the patch, whose first node is `first`; read-only.
    F_bar, L_bar: forces over w E; A_bar: length in contact over w.
    """

    scene: Scene
    stage: Stage
    index: int  # of the increment within its stage
    U_x: float  # nm, of the stage
    delta: float  # nm, of the stage
    first: int
    u: NDArray[np.float64]
    T: NDArray[np.float64]
    F_bar: float
    L_bar: float
    A_bar: float
    residual: float  # max |U + C T(u) - u|, nm
    evaluations: int  # force evaluations of this increment
    slips: tuple[SlipEvent, ...] = ()  # in this increment
    repeated: bool = False  # a state of an earlier lattice period, moved on and verified

    def __repr__(self) -> str:
        here = f"U_x = {self.U_x:.6g} nm, delta = {self.delta:.6g} nm, F = {self.F:.4g} N/m, L = {self.L:.4g} N/m"
        return f"Frame({self.stage} {self.index}: {here}, A = {self.A:.4g} nm)"

    @cached_property
    def safe_damping(self) -> float:
        """The damping over critical above which no wave of the contact can flutter; 0.0 where all modes were judged."""
        if 2 * self.scene.nodes <= DENSE_WAVES:
            return 0.0
        return safe_damping(self.scene, self.u, self.first)

    @property
    def may_flutter(self) -> bool:
        """Whether a short mode may grow unnoticed: the scene's damping is below the safe damping of this state."""
        return self.scene.damping < self.safe_damping

    @property
    def unit(self) -> float:
        """N/m of force per unit of F_bar and L_bar, those of `slips` too."""
        return self.scene.width * self.scene.E

    @property
    def gap(self) -> NDArray[np.float64]:
        """Distance of the surfaces at the nodes of the patch, (m,) nm; negative where they overlap."""
        return self.scene.profile[self.first :][: self.u.shape[1]] + self.u[1]

    @property
    def F(self) -> float:
        """Friction force, N/m."""
        return self.F_bar * self.unit

    @property
    def L(self) -> float:
        """Normal load, N/m."""
        return self.L_bar * self.unit

    @property
    def A(self) -> float:
        """Contact area, nm."""
        return self.A_bar * self.scene.width

    @property
    def U_x_top(self) -> float:
        """U_x of the top of the layer, nm: U_x - F/(w k_t), that of the stage if the drive is rigid."""
        return self.U_x - self.F_bar * self.scene.E * self.scene.drive_compliance[0]

    @property
    def delta_top(self) -> float:
        """delta of the top of the layer, nm: delta - L/(w k_n), that of the stage if the drive is rigid."""
        return self.delta - self.L_bar * self.scene.E * self.scene.drive_compliance[1]

    @property
    def sensitive(self) -> bool:
        """Whether which equilibrium a slip of this increment reaches depends on details of the motion."""
        return any(event.sensitive for event in self.slips)

    @property
    def slip(self) -> bool:
        """Whether the branch ended within this increment."""
        return bool(self.slips)


def largest_safe_damping(frames: Sequence[Frame]) -> float:
    """The largest `safe_damping` of a run: of every SAMPLE-th computed Frame, and of those just before slips.

    Towards the end of a branch it rises most.
    """
    computed = [frame for frame in frames if not frame.repeated]
    before = [frame for frame, after in pairwise(computed) if after.slips]
    return max((frame.safe_damping for frame in [*computed[::-SAMPLE], *before]), default=0.0)


def largest_overlap(frames: Sequence[Frame]) -> float:
    """The largest depth over delta_n by which the surfaces of a Frame overlap; 0.0 where they do not."""
    return max([0.0, *(-float(frame.gap.min()) / frame.scene.delta_n for frame in frames)])


def slips_in(run) -> list[SlipEvent]:
    """The SlipEvents of a Frame or Skeleton without the jump where a held load takes over ("control")."""
    return [event for event in run.slips if event.kind != "control"]


def slides_in(frame) -> list[SlipEvent]:
    """The SlipEvents of a Frame of a stage that moves U_x, without the "control" jump; none where delta alone moves."""
    return slips_in(frame) if frame.stage.moves == "U_x" else []


def forces(scene, T) -> tuple[Any, Any]:
    """(F_bar, L_bar): tangential and normal force over w E, of T (..., 2, m), GPa; attraction is negative."""
    unit = scene.nodes * scene.E
    return -T[..., 0, :].sum(axis=-1) / unit, T[..., 1, :].sum(axis=-1) / unit


def contact_area(scene, T) -> float:
    """A_bar: the length under repulsion over w, from sign changes of T_z, interpolated between nodes; T (2, m), GPa."""
    return _repelled(T[1], T.shape[1] == scene.nodes, least_repulsion(scene)) / scene.nodes


def forces_and_area(scene, T) -> tuple[float, float, float]:
    """(F_bar, L_bar, A_bar) of T (2, m), GPa."""
    F_bar, L_bar = forces(scene, T)
    return float(F_bar), float(L_bar), contact_area(scene, T)


def least_repulsion(scene) -> float:
    """T_z (GPa) from which a node counts as in contact, so that a flat at dn = 0 does not flicker by round-off."""
    share = CONTACT_OF_FLATS if scene.surface == "flat" else CONTACT
    return share * scene.phi_n / scene.delta_n


@kernel
def _repelled(T_z, closed, least):
    """The length under repulsion, in node spacings; closed: the last node is next to the first, else nothing is."""
    length, here = 0.0, (T_z[-1] if closed else 0.0) - least
    for i in range(T_z.size if closed else T_z.size + 1):
        after = (T_z[i] if i < T_z.size else 0.0) - least
        repelled = max(here, 0.0) + max(after, 0.0)
        if repelled > 0.0:  # that share of a spacing over which T_z is linear
            length += repelled / (abs(here) + abs(after))
        here = after
    return length


def frame_of(scene, problem, state, stage, index, residual, evaluations=0, slips=(), repeated=False) -> Frame:
    """The Frame of a State of an Equilibrium; residual, nm."""
    U_x, U_z = problem.top(state.v, state.load)
    T = problem.traction(state.v)
    u, numbers = problem.surface(state.v).copy(), forces_and_area(scene, T)
    for field in (u, T):
        field.flags.writeable = False
    position = scene, Stage(stage), index, float(U_x), 0.0 - float(U_z), problem.contact.first
    return Frame(*position, u, T, *numbers, residual, evaluations, slips, repeated)
