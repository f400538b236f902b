"""How tough the interface is under a mix of opening and shear, and what drives the two edges of a contact.

The edge of an adhesive contact is a crack tip. Under a far field of stress intensity K and mode angle psi, that is of
opening K cos(psi) and shear K sin(psi), it advances at the energy release rate Gamma = K^2/(2 E*), E* = E/(1 - nu^2):
the toughness of the interface. Each node has one spring here, and nu is 1/2: other values of nu change psi a little.

Sources: Rice (1968) for the J-integral, Barenblatt (1962) for the balance at the tip.
"""

from contextlib import suppress
from functools import lru_cache
from math import floor, isclose, pi, radians
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import erfcx

from ..mechanics.cohesive_law import OPENING, tangent
from ..run.frame import Frame
from ..scene import Scene
from ..threads import computation
from .peeling import edges

LARGEST_ANGLE = radians(80.0)  # of psi: towards pure shear the cohesive zone grows without bound
CELLS = 120  # of the interface at the tip; Gamma is 1e-3 phi_n beside that of very many, 1e-2 at phi_ratio 0.01, 20
BEHIND, OPEN = 40.0, 120.0  # lengths E* delta_n^2/phi_n bonded before the tip and open behind it: as CELLS
NARROW = 6.0  # cells at the tip are exp(NARROW) times as narrow as those at the ends, or narrower still: see `_cells`


EDGE_UNITS = ("x", "nm"), ("J", "N/m"), ("psi", "rad")  # of an Edge


class Edge(NamedTuple):
    """An edge of a contact as a crack tip."""

    x: float  # nm from the middle of the cell, undeformed, where the normal traction changes its sign
    J: float  # N/m, energy release rate
    psi: float  # rad, mode angle of the far field: 0 opening, towards pi/2 shear


@computation
def toughness(scene: Scene, psi: ArrayLike) -> NDArray[np.float64]:
    """The energy release rate at which an edge of the contact advances, over its mode angle.

    The law of Xu & Needleman with phi_t = phi_n has a potential: it is phi_n. NP1 with c = 1 opens at a constant ratio
    of shear to opening, where c = 2 (phi_t/phi_n) (delta_n/delta_t)^2; it is a closed form. Otherwise the field at the
    crack tip is computed.

    Parameters: scene: its interface; psi: mode angles, rad, a number or an array.
    Returns the toughness, N/m, in the shape of psi; a computed one has an error of some 1e-3 phi_n. For phi_ratio above
    10 or below 0.01 (delta_t/delta_n)^2 it is up to 1e-2 phi_n.
    Raises ValueError for angles beyond 80 degrees, and for phi_ratio = 0.

    Example: `toughness(Scene(), [0.0, 0.5])`
    """
    angles = np.abs(np.asarray(psi, float))
    if not (angles <= LARGEST_ANGLE).all():
        most = floor(1e3 * LARGEST_ANGLE) / 1e3  # rounded down, so that the angle named is allowed
        raise ValueError(f"psi = {angles.max():.6g} rad; allowed: up to {most:g} either way; use a smaller angle")
    if scene.phi_ratio == 0.0:
        raise ValueError("phi_ratio = 0: such an interface carries no shear; use a phi_ratio above 0")
    delta_t, opening = scene.delta_t / scene.delta_n, OPENING[scene.law]
    if opening and scene.phi_ratio == 1.0:
        return np.full(angles.shape, scene.phi_n)
    if not opening and isclose(2.0 * scene.phi_ratio, delta_t**2, rel_tol=1e-9):
        return scene.phi_n * _along_ray(np.tan(angles), delta_t)
    values = [_tip(float(angle), scene.phi_ratio, delta_t, opening) for angle in angles.flat]
    return scene.phi_n * np.reshape(values, angles.shape)


def _along_ray(t, delta_t):
    """Gamma/phi_n of NP1 with c = 1: the work along an opening at the ratio t of shear to opening."""
    B = np.maximum((t / delta_t) ** 2, 1e-9)
    z = 0.5 / np.sqrt(B)
    series = 1.0 - 3.0 * B  # of the closed form, which loses its digits
    return (1.0 + t**2) * np.where(B > 1e-5, (1.0 - np.sqrt(pi) * z * erfcx(z)) / (2.0 * B), series)


@lru_cache(maxsize=1024)
def _tip(psi, ratio, delta_t, opening):
    """Gamma/phi_n of a semi-infinite crack; delta_t over delta_n, lengths along it over E* delta_n^2/phi_n.

    The faces y > 0 open by n = K cos(psi) B - M T_n and slide by t = K sin(psi) B - M T_t, with B = 4 sqrt(y/(2 pi))
    and M f = (2/pi) int ln|(sqrt y + sqrt s)/(sqrt y - sqrt s)| f(s) ds. K is the one that holds the tip in its place.
    What the springs leave of it at y = 0, where a rigid bond begins, is no part of Gamma.
    """
    ends, M = _cells(max(1.0, 0.5 * delta_t**2 / ratio))
    middle = 0.5 * (ends[1:] + ends[:-1])
    m, far, here = middle.size, 4.0 * np.sqrt(middle / (2.0 * pi)), middle.size // 2
    way = np.array([np.cos(psi), np.sin(psi)])
    x = np.append(np.outer(way, 4.0 * np.sqrt(np.maximum(middle - middle[here], 0.0) / pi + 0.01)), np.sqrt(2.0))
    for _ in range(200):
        n, t = x[:m], x[m:-1]
        T, J = _spring(n, t, ratio, delta_t, opening)
        place = n[here] ** 2 + (t[here] / delta_t) ** 2 - 1.0
        r = np.concatenate((n - x[-1] * way[0] * far + M @ T[0], t - x[-1] * way[1] * far + M @ T[1], [place]))
        A = np.block([[np.eye(m) + M * J[0, 0], M * J[0, 1]], [M * J[1, 0], np.eye(m) + M * J[1, 1]]])
        A = np.block([[A, -np.outer(way, far).reshape(-1, 1)], [np.zeros((1, 2 * m + 1))]])
        A[-1, here], A[-1, m + here] = 2.0 * n[here], 2.0 * t[here] / delta_t**2
        step = np.linalg.solve(A, -r)
        largest = float(np.abs(step).max())
        # 8 delta_n fails for phi_ratio = 20
        x += min(1.0, 4.0 / largest) * step
        if largest < 1e-9:
            way, T = np.pad((n, t), ((0, 0), (1, 0))), np.pad(T, ((0, 0), (1, 0)))  # from the closed spring on
            between = _spring(*(0.5 * (way[:, 1:] + way[:, :-1])), ratio, delta_t, opening)[0]
            return float((np.diff(way) * (T[:, 1:] + 4.0 * between + T[:, :-1])).sum()) / 6.0  # Simpson's rule
    raise ValueError(f"psi = {psi:.3g} rad: no crack tip found; use an angle nearer to 0")


@lru_cache(maxsize=16)
def _cells(longer):
    """(the ends (m + 1,) of the cells, M (m, m) for a traction constant in each); the tip is in the middle one."""
    narrow = NARROW + np.log(longer)  # weak shear lengthens the zone of shear, not that of opening
    graded = np.sinh(narrow * np.linspace(0.0, 1.0, CELLS // 2)) / np.sinh(narrow)
    ends = longer * BEHIND + longer * np.concatenate((-BEHIND * graded[:0:-1], OPEN * graded))
    ends[0] = 0.0
    y, s = np.sqrt(0.5 * (ends[1:] + ends[:-1]))[:, None], np.sqrt(ends)
    integral = (s**2 - y**2) * np.log(np.abs((y + s) / (y - s))) + 2.0 * y * s
    return ends, (2.0 / pi) * np.diff(integral, axis=1)


def _spring(n, t, ratio, delta_t, opening):
    """((T_n, T_t), their derivatives [[nn, nt], [tn, tt]]) of a spring, over phi_n/delta_n and phi_n/delta_n^2."""
    q = t / delta_t
    e = np.exp(-np.maximum(n, -3.0) - q**2)  # an iterate may be closed deeply
    shear, factor = 2.0 * ratio / delta_t**2, 1.0 + opening * n
    T = np.array([n * e, shear * t * factor * e])
    across = [(1.0 - n) * e, -2.0 * q / delta_t * n * e]
    return T, np.array([across, [shear * t * (opening - factor) * e, shear * factor * (1.0 - 2.0 * q**2) * e]])


def release_rates(frame: Frame) -> tuple[Edge, Edge]:
    """The trailing and the leading edge of a contact as crack tips: places, energy release rates, mode angles.

    From the middle of the contact outwards each mode has its own J: -int T_z d(gap) for opening, -int T_x du_x for
    shear, and what the springs in the middle store. Their sum is J, and psi = atan sqrt(J_shear/J_opening), which is
    exact for nu = 1/2. The trapezoid over nodes needs four and more in a cohesive zone e^2 E* delta_n^2/phi_n.

    Parameters: frame: one with a single part in contact.
    Returns two Edges (x (nm), J (N/m), psi (rad)).
    Raises ValueError unless one part of the surface is in contact, or where one of its nodes passed to another site.

    Example: `release_rates(simulate(Scene(u_x_max=0.0)).frames[-1])`
    """
    scene = frame.scene
    where = edges(frame)
    if len(where) != 1 or not np.isfinite(where).all():
        raise ValueError("release rates need one part in contact, with two edges; choose another frame")
    n, middle = frame.u.shape[1], round(where.mean() / scene.spacing)
    # the contact may lie across the ends of the cell: then once round, from opposite to it
    node = np.arange(n) + (middle - n // 2 if n == scene.nodes else frame.first)
    u, T, gap = (field[..., (node - frame.first) % n] for field in (frame.u, frame.T, frame.gap))
    x, middle = node * scene.spacing, middle - node[0]
    inside = (x >= where[0, 0]) & (x <= where[0, 1])
    if (np.abs(u[0, inside]) > 0.5 * scene.spacing).any():
        raise ValueError("a node in contact passed to another site; choose a frame before the first slip")
    apart = np.stack((u[0], gap))
    stiffness = -tangent(scene, apart[0, middle], apart[1, middle])[[0, 3]]
    stored = 0.5 * T[:, middle] ** 2 / np.maximum(stiffness, np.finfo(float).tiny)
    left, right = slice(middle, None, -1), slice(middle, None)
    return (
        _edge(where[0, 0] - 0.5 * scene.width, stored, T[:, left], apart[:, left]),
        _edge(where[0, 1] - 0.5 * scene.width, stored, T[:, right], apart[:, right]),
    )


def _edge(at, stored, T, apart):
    shear, opening = (
        float(part - np.trapezoid(traction, way)) for part, traction, way in zip(stored, T, apart, strict=True)
    )
    return Edge(float(at), shear + opening, float(np.arctan2(np.sqrt(max(shear, 0.0)), np.sqrt(max(opening, 0.0)))))


def edges_over(frames) -> list[dict[str, float]]:
    """Both edges of every Frame after the approach that has them: U_x (nm), x (nm), J (N/m) and psi (rad) of each."""
    rows = []
    for frame in frames:
        with suppress(ValueError):
            row = {"U_x (nm)": frame.U_x}
            for side, edge in zip(("trailing", "leading"), release_rates(frame), strict=True):
                row |= {f"{name}_{side} ({unit})": value for (name, unit), value in zip(EDGE_UNITS, edge, strict=True)}
            rows.append(row)
    return rows
