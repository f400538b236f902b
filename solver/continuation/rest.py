"""Whether an equilibrium is stable under the damped motion; only this module decides that.

A disturbance x exp(lambda t) of an equilibrium obeys (J - K) x = mu x with lambda^2 + gamma lambda = mu. It may grow as

fold     a real mu passes zero, and with it an eigenvalue of the equilibrium's tangent dR/dv;
flutter  on its way to zero that mu meets the mu of a long wave of the layer, |mu| a few k_min: both turn complex.

Both have the mu nearest to zero. A Rayleigh-Ritz search finds it in a space of disturbances of the whole surface. Each
step adds (K - J)^-1 r to that space, where r is the residual of a Ritz pair (Davidson 1975, with inverse iteration).
The search at the next state starts from the vectors of the last one. Waves of the contact have mu far from zero. They
may flutter at a damping below the safe one of `flutter`: all mu of small problems and flats are computed, and
elsewhere a frame estimates that damping when asked.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from .inverse import Inverse, Space
from .state import TINY, Crowded

ROUND_OFF = 1e-9  # of the largest: eigenvalues and vectors with a smaller imaginary part, from round-off, count as real
UNSTABLE = 1e-6  # growth, 1/time, above which an equilibrium is unstable: round-off of flats makes 1e-8


@dataclass(frozen=True)
class RestOptions:
    """How a growing mode is searched for.

    A growth is compared with twice the decay of the layer's slowest mode, |mu| with k_min, unless the comment differs.
    """

    # vectors that a search may add; disturbances up to that size have all their mu computed. Searches take fewer than
    # 30 in the runs of tests/bench/constants.py
    most: int = 60
    dense_waves: int = 256  # size of a disturbance up to which all its mu are computed where waves may flutter: 0.1 s
    radius: float = 20.0  # |mu| below which a mode counts as near zero; pairs of flutter form at 5 to 20
    kept: int = 4  # vectors from which the next search starts: two complex pairs
    # residual of a mode near zero, over its distance from growing, up to which it counts as known. With 1 and 4, slips
    # are the same, for up to 4 % more and 3 % fewer evaluations (tests/bench/constants.py)
    sure: float = 2.0
    fine: float = 1e-8  # error of a growth where an end is located
    # growth rates below -clear count as safely stable; none is below -0.5. 0.25 was too lax: on a soft layer (E = 10)
    # flutter began between two searches
    clear: float = 0.4
    # units, times the margin: a state is accepted without a search while the growth is `clear` and no unknown has moved
    # farther since the last one. Towards a fold, margin and movement shrink as the root of the distance in load
    far: float = 0.8


OPTIONS = RestOptions()


@dataclass(frozen=True)
class Mode:
    """The disturbance x of an equilibrium that grows fastest; the next search starts from it."""

    growth: float  # 1/time
    mu: complex  # GPa/nm
    x: np.ndarray | None  # (size,)
    basis: tuple = ()  # of (x (N,), K x), disturbances near zero
    v: np.ndarray | None = None  # (size,) the state that was searched
    margin: float = 0.0  # distance from a fold, in stiffness: one minus the largest eigenvalue of K^-1 J in the basis

    @property
    def rests(self) -> bool:
        """Whether the equilibrium is stable, to UNSTABLE."""
        return self.growth <= UNSTABLE

    @property
    def kind(self) -> str:
        """The kind of end at its onset, as of `state.End`, unless that is a fold."""
        return "flutter" if abs(self.mu.imag) > ROUND_OFF * abs(self.mu) else "bifurcation"


class Judge:
    """Judges the states of a run, under a motion of that damping over critical.

    Raises Crowded where a wave grows that one node for all cannot show.
    """

    def __init__(self, damping, options: RestOptions = OPTIONS):
        self.damping, self.options = damping, options

    def accept(self, problem, v, active, last=None, smooth=None) -> Mode:
        """The Mode of an equilibrium v (size,): `last`, that of an earlier state, where no search is needed.

        smooth: a function close to the inverse of -dR/dv, if there is one.
        """
        linearised, fits, options = problem.linearised(v, active), _fits(last, v), self.options
        near = fits and np.abs(v - last.v).max() < options.far * problem.unit * min(last.margin, 1.0)
        clear = near and last.growth < -options.clear * self._scale(problem)
        if clear and (linearised.size > options.dense_waves or self.damping >= linearised.safe_damping()):
            return last
        return self._searched(problem, linearised, v, last if fits else None, smooth, fine=not fits)

    def rightmost(self, problem, v, active, last=None, smooth=None) -> Mode:
        """The same by a search in any case, to `fine`."""
        last = last if _fits(last, v) else None
        return self._searched(problem, problem.linearised(v, active), v, last, smooth, fine=True)

    def _scale(self, problem):
        """What growths are compared with: twice the decay of the layer's slowest mode, gamma up to critical damping."""
        critical = problem.motion().critical
        return -2.0 * float(rate(-0.25 * critical**2, self.damping * critical))

    def _searched(self, problem, linearised, v, last, smooth, fine):
        critical, options = problem.motion().critical, self.options
        friction = self.damping * critical
        if (waves := linearised.waves()) is not None:
            return _of_waves(linearised, *waves, friction)
        if linearised.size <= options.most:
            return _dense(linearised, friction)
        if linearised.size <= options.dense_waves and self.damping < linearised.safe_damping():
            return _dense(linearised, friction)
        # the start, noise, the search, and its last step beyond that
        space = Space(linearised, options.kept + 2 + options.most + 4)
        inverse = Inverse(linearised.tangent, problem.size, smooth)
        zero = _NearZero(friction, options.radius * 0.25 * critical**2, self._scale(problem), fine, options)
        growth, mu, x, basis, margin = _search(linearised, inverse, space, last.basis if last else (), zero)
        return Mode(growth, mu, linearised.seen(x), basis, v, margin)


def rate(mu, friction) -> np.ndarray:
    """The larger Re(lambda), 1/time, of lambda^2 + friction lambda = mu; Re(mu), GPa/nm, for infinite friction."""
    mu = np.asarray(mu, complex)
    return mu.real if np.isinf(friction) else np.sqrt(friction**2 / 4.0 + mu).real - friction / 2.0


def inside(mu, friction) -> np.ndarray:
    """Distance, to first order, of mu from the parabola Im^2 = -friction^2 Re within which modes decay, GPa/nm."""
    depth = -mu.real
    if np.isinf(friction):
        return depth
    steepness = friction * np.sqrt(friction**2 + 4.0 * np.maximum(depth, 0.0))
    return (friction**2 * depth - mu.imag**2) / steepness


def _fits(last, v):
    """Whether a search at the state v may start from the Mode `last`."""
    return last is not None and last.v is not None and last.v.shape == v.shape


def _largest_phase(x):
    """The real part of an eigenvector, turned to the phase in which it is largest."""
    return (x * np.exp(-0.5j * np.angle((x * x).sum()))).real


def _dense(linearised, friction):
    """The Mode from all eigenvalues."""
    values, vectors = np.linalg.eig(np.array([linearised.product(e) for e in np.eye(linearised.size)]).T)
    rates = rate(values, friction)
    i = int(np.argmax(rates))
    return Mode(float(rates[i]), complex(values[i]), linearised.seen(_largest_phase(vectors[:, i])))


def _of_waves(linearised, mu, shown, friction):
    """The Mode where every mode is a wave, arguments as of `Linearised.waves`."""
    rates = rate(mu, friction)
    fastest = np.unravel_index(np.argmax(rates), mu.shape)
    growth, x = float(rates[fastest]), shown(*fastest)
    if x is None:
        if growth > UNSTABLE:
            raise Crowded("one node cannot show the wave that grows")
        x = shown(int(np.argmax(rates[:, 0])), 0)
    fastest = complex(mu[fastest])
    if abs(fastest.imag) <= ROUND_OFF * np.abs(mu).max():
        fastest = complex(fastest.real)
    return Mode(growth, fastest, linearised.seen(_largest_phase(x)))


class _NearZero(NamedTuple):
    """What is searched for: the fastest mode with |mu| < radius, GPa/nm, its growth to `fine` or only its sign."""

    friction: float  # 1/time
    radius: float
    scale: float  # of growths
    fine: bool
    options: RestOptions


def _search(linearised, inverse, space, start, zero):
    """(growth, mu, x, basis from which to go on, its margin) of that mode; space: an empty Space.

    start: pairs (x, K x) to begin with.
    """
    for pair in start:
        space.add(*pair)
    other = linearised.noise  # without it, modes of another symmetry would be missed
    for _ in range(2):  # the second solve damps what does not grow
        other, layered = linearised.inverse(inverse.solve, other)
        space.add(other, layered)
    most = space.rows + zero.options.most
    while True:
        ritz = _Ritz(space, zero)
        rows = space.rows
        if ritz.settled():
            break
        for aim in ritz.aims():
            for part in _parts(ritz.residuals[aim]):
                space.add(*linearised.inverse(inverse.solve, part))
        if not rows < space.rows < most:
            break
    return ritz.growth, *ritz.carried()


class _Ritz:
    """The Ritz pairs of a Space next to zero: their rates, their distances from growing, and the errors of both."""

    def __init__(self, space, zero):
        friction = zero.friction
        self.all_vectors, self.values, self.vectors = _ritz_pairs(space, friction, zero.radius)
        self.zero, self.depth = zero, inside(self.values, friction)
        self.span, self.layered, self.matrix = space.vectors, space.layered, space.matrix
        rates = rate(self.values, friction)
        self.residuals = space.residuals(self.vectors, self.values)
        miss = np.sqrt((np.abs(self.residuals) ** 2).sum(axis=1))
        # of modes that grow alike to round-off, the one nearest to zero
        self.fastest = int(np.argmax(rates - ROUND_OFF * np.abs(self.values)))
        self.growth = float(rates[self.fastest])
        self.error = _error(miss[self.fastest], self.values[self.fastest], friction)
        doubt = miss / np.maximum(self.depth, TINY)
        self.worst = int(np.argmax(doubt))
        self.sure = doubt[self.worst] < zero.options.sure

    def settled(self):
        """Whether the growth is known well enough."""
        _, _, scale, fine, options = self.zero
        decided = self.sure or self.growth > self.error
        clear = self.sure and self.growth < -options.clear * scale
        return clear or self.error < options.fine * scale or (decided and not fine)

    def aims(self):
        """The pairs whose residuals extend the space."""
        if self.sure or self.depth[self.fastest] <= 0.0:
            return {self.fastest}
        return {self.worst, self.fastest} if self.zero.fine else {self.worst}

    def carried(self):
        """(mu and x of the fastest mode; basis and margin, as of a Mode, of those nearest to growing)."""
        kept = self.zero.options.kept
        parts = [part for vector in self.all_vectors.T[:kept] for part in _parts(vector)]
        basis = np.linalg.qr(np.array(parts[:kept]).T)[0].T
        x = _largest_phase(self.vectors[:, self.fastest] @ self.span)
        vectors, layered = basis @ self.span, basis @ self.layered
        onset = np.linalg.solve(vectors @ layered.T, basis @ self.matrix @ basis.T)
        margin = -float(np.linalg.eigvals(onset).real.max())
        return complex(self.values[self.fastest]), x, tuple(zip(vectors, layered, strict=True)), margin


def _ritz_pairs(space, friction, radius):
    """(all vectors, fastest growth first; values and vectors near zero), one of each complex pair.

    Near zero are those with |mu| < radius or Re mu > 0, and where the contact is stiff everywhere, the smallest.
    """
    values, vectors = np.linalg.eig(space.matrix)
    upper = np.flatnonzero(values.imag >= 0.0)
    upper = upper[np.argsort(inside(values[upper], friction))]
    values, vectors = values[upper], vectors[:, upper]
    near = (np.abs(values) <= max(radius, np.abs(values).min())) | (values.real > 0.0)
    return vectors, values[near], vectors[:, near]


def _error(miss, mu, friction):
    """Error of the growth at a Ritz value mu whose unit vector has a residual of length `miss`."""
    if np.isinf(friction):
        return miss
    return min(miss / max(abs(np.sqrt(friction**2 + 4.0 * complex(mu))), TINY), miss**0.5)


def _parts(x):
    """(real part, imaginary part) of x; the latter only if it is not round-off."""
    return (x.real, x.imag) if np.iscomplexobj(x) and np.abs(x.imag).max() > ROUND_OFF * np.abs(x).max() else (x.real,)
