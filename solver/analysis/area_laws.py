"""The laws by which the contact area shrinks, fitted to runs (paper Eq. 8, 9)."""

from dataclasses import dataclass
from math import sqrt

import numpy as np


@dataclass(frozen=True)
class QuadraticLaw:
    """A fit of A_bar = A_0 - zeta F_bar^2 (Eq. 8), and measures of its misfit."""

    A_0: float
    zeta: float
    zeta_error: float  # standard error
    r2: float  # of A_bar about its mean
    worst: float  # largest |deviation| over A_0
    last: float  # deviation at the last point over A_0; negative: less area than by the law
    rise: float  # -dA/d(F^2) in the last tenth of F^2 over that in the first half; 1 where the law holds
    points: int


def quadratic_law(F, A) -> QuadraticLaw:
    """The QuadraticLaw of a branch from U_x = 0 on, by least squares: forces F (k,), areas A (k,), A[0] = A_0.

    Uses the points in contact (A > 0). Raises ValueError for fewer than five of them, without contact at the first
    point, for constant F or A, and for values that are not finite.
    """
    F, A, first = _in_contact("F", F, "A", A)
    if A.size < 5 or not np.ptp(F) > 0.0:
        raise ValueError(f"{A.size} points in contact: at least 5, at forces that differ; press deeper or shorten du_x")
    if first:
        raise ValueError(f"A[0] = 0: no contact before point {first}; needed: A_0 at the first point; press deeper")
    if not np.ptp(A) > 0.0:
        raise ValueError(f"all areas A = {A[0]:g}: the law needs areas that differ; shear farther")
    x = F**2
    zeta = float(x @ (A[0] - A) / (x @ x))
    deviation = A - (A[0] - zeta * x)
    squares = float(deviation @ deviation)
    spread = A - A.mean()
    return QuadraticLaw(
        A_0=float(A[0]),
        zeta=zeta,
        zeta_error=sqrt(squares / (A.size - 1) / float(x @ x)),
        r2=1.0 - squares / float(spread @ spread),
        worst=float(np.abs(deviation).max() / A[0]),
        last=float(deviation[-1] / A[0]),
        rise=_rise(x, A),
        points=A.size,
    )


def _rise(x, A):
    """The late over the early rate -dA/dx, up to the largest x."""
    top = int(np.argmax(x)) + 1  # under tension the force passes a flat maximum before the slip
    x, A = x[:top], A[:top]
    half, late = (float(np.interp(part * x[-1], x, A)) for part in (0.5, 0.9))
    if half == A[0]:
        raise ValueError(f"A = {half:g} up to half the largest F^2: no early rate; give a branch along which A changes")
    return float((late - A[-1]) / 0.1 * 0.5 / (A[0] - half))


def _in_contact(x_name, x, A_name, A):
    """(x, A, index of the first) of the points with A > 0; raises ValueError unless all values are finite."""
    x, A = np.asarray(x, float), np.asarray(A, float)
    if x.shape != A.shape:
        raise ValueError(f"{x_name} {x.shape} and {A_name} {A.shape}: give two arrays of one length")
    for name, values in ((x_name, x), (A_name, A)):
        bad = np.flatnonzero(~np.isfinite(values))
        if bad.size:
            raise ValueError(f"{name}[{bad[0]}] = {values[bad[0]]}: give finite numbers; leave out runs that failed")
    touching = np.flatnonzero(A > 0.0)
    return x[touching], A[touching], int(touching[0]) if touching.size else 0


@dataclass(frozen=True)
class ThresholdLaw:
    """F_s = tau_c A_s + F_nc (extended threshold law, Eq. 9; F_nc is the paper's F_s,nc) with standard errors."""

    tau_c: float
    tau_c_error: float
    F_nc: float
    F_nc_error: float
    r2: float
    points: int


def threshold_law(A_s, F_s) -> ThresholdLaw:
    """The ThresholdLaw by least squares through the points (A_s, F_s) with A_s > 0.

    Raises ValueError for fewer than three of them, for constant A_s or F_s, and for values that are not finite.
    """
    F, A, _ = _in_contact("F_s", F_s, "A_s", A_s)
    if A.size < 3 or not np.ptp(A) > 0.0:
        raise ValueError(f"{A.size} points in contact at the onset: at least 3, of different area; press deeper")
    if not np.ptp(F) > 0.0:
        raise ValueError(f"all forces F_s = {F[0]:g}: a line needs onsets at forces that differ; vary delta_bar")
    (tau_c, F_nc), covariance = np.polyfit(A, F, 1, cov=True)
    errors = np.sqrt(np.diag(covariance))
    r2 = np.corrcoef(A, F)[0, 1] ** 2
    return ThresholdLaw(float(tau_c), float(errors[0]), float(F_nc), float(errors[1]), float(r2), A.size)
