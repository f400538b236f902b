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

from typing import NamedTuple

import numpy as np

from .inverse import Inverse
from .state import ROUND_OFF, TINY, Mode
from .vectors import orthonormalise

# A growth is compared with twice the decay of the layer's slowest mode, |mu| with k_min, unless the comment differs.
# Most vectors that a search adds. Of smaller disturbances all mu are computed. Searches of tests/bench/constants.py add
# fewer than 30
MOST = 60
DENSE_WAVES = 256  # size of a disturbance up to which all its mu are computed where waves may flutter: 0.1 s
KEPT = 4  # vectors from which the next search starts: two complex pairs
FINE = 1e-8  # error of a growth where an end is located
# growth rates below -CLEAR count as safely stable; none is below -0.5. 0.25 was too lax: on a soft layer (E = 10)
# flutter began between two searches
CLEAR = 0.4
# units: no search while the last growth rate is clearly negative and no unknown has moved more than FAR times the
# margin since then: springs change their stiffness by up to twice itself in a unit. With 0.8 one state in 400 of small
# cells was unstable (tests/bench/rests.py). Towards a fold, margin and movement shrink as the root of the distance in
# load
FAR = 0.5


class Judge:
    """Judges the states of a run, under a motion of that damping over critical; far: in place of FAR."""

    def __init__(self, damping, far: float | None = None):
        self.damping, self.far = damping, FAR if far is None else far

    def accept(self, problem, v, last=None) -> Mode:
        """The Mode of an equilibrium v (size,): `last`, that of an earlier state, where no search is needed."""
        fits = _fits(last, v)
        near = fits and np.abs(v - last.v).max() < self.far * problem.unit * min(last.margin, 1.0)
        if near and last.growth < -CLEAR * self._scale(problem) and self._calm(problem, v, last):
            return last
        return self._searched(problem, problem.linearised(v), v, last if fits else None, fine=not fits)

    def _calm(self, problem, v, last):
        """Whether no wave can flutter in v, or the size of its disturbances leaves waves to the estimate of a frame."""
        return last.basis[0][0].size > DENSE_WAVES or self.damping >= problem.linearised(v).safe_damping()

    def rightmost(self, problem, v, last=None) -> Mode:
        """The same by a search in any case, to `fine`."""
        last = last if _fits(last, v) else None
        return self._searched(problem, problem.linearised(v), v, last, fine=True)

    def _scale(self, problem):
        """What growths are compared with: twice the decay of the layer's slowest mode, gamma up to critical damping."""
        critical = problem.motion().critical
        return -2.0 * float(rate(-0.25 * critical**2, self.damping * critical))

    def _searched(self, problem, linearised, v, last, fine):
        critical = problem.motion().critical
        friction = self.damping * critical
        if (waves := linearised.waves()) is not None:
            return _of_waves(linearised, *waves, friction)
        small = linearised.size <= MOST
        if small or (linearised.size <= DENSE_WAVES and self.damping < linearised.safe_damping()):
            return _dense(linearised, friction)
        inverse = Inverse(linearised.tangent, problem.size)
        radius = 5.0 * critical**2  # 20 k_min: pairs of flutter form at 5 to 20 of it
        search = _Search(linearised, inverse, friction, radius, self._scale(problem), fine)
        return search.mode(v, last.basis if last else ())


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
    fastest = complex(mu[fastest])
    if abs(fastest.imag) <= ROUND_OFF * np.abs(mu).max():
        fastest = complex(fastest.real)
    return Mode(growth, fastest, linearised.seen(_largest_phase(x)))


class _Pairs(NamedTuple):
    """Ritz pairs (mu, vector) near zero, one of each complex pair."""

    mu: np.ndarray  # (pairs,) GPa/nm
    vectors: np.ndarray  # (rows, pairs)
    residuals: np.ndarray  # (pairs, size)
    depth: np.ndarray  # (pairs,) distance of mu from growing, GPa/nm
    doubt: np.ndarray  # (pairs,) length of the residual over that distance
    fastest: int  # index of the pair that grows fastest
    growth: float  # 1/time, of that pair
    error: float  # of this growth
    nearest: np.ndarray  # (rows, kept) vectors nearest to growing, near zero or not


class _Search:
    """A search for the fastest mode with |mu| < radius, GPa/nm: for its growth to `fine`, or only for its sign.

    It keeps orthonormal disturbances V, their images K V and M V under M = J - K, and V^T M V, GPa/nm.
    """

    def __init__(self, linearised, inverse, friction, radius, scale, fine):
        """friction: 1/time; scale: of growths."""
        self.linearised, self.inverse = linearised, inverse
        self.friction, self.radius, self.scale, self.fine = friction, radius, scale, fine
        room = KEPT + 2 + MOST + 4  # the start, noise, the search, and its last step beyond that
        self.v, self.k, self.w = np.empty((3, room, linearised.size))
        self.rows, self.matrix = 0, np.empty((room, room))

    def mode(self, v, start) -> Mode:
        """The Mode of the state v; start: pairs (x, K x) to begin with."""
        for pair in start:
            self._add(*pair)
        other = self.linearised.noise  # without it, modes of another symmetry would be missed
        for _ in range(2):  # the second solve damps what does not grow
            other = self._respond(other)
        most, pairs = self.rows + MOST, self._pairs()
        while not self._known(pairs):
            rows = self.rows
            for aim in self._aims(pairs):
                for part in _parts(pairs.residuals[aim]):
                    self._respond(part)
            if not rows < self.rows < most:
                break
            pairs = self._pairs()
        x = _largest_phase(pairs.vectors[:, pairs.fastest] @ self.v[: len(pairs.vectors)])
        basis, margin = self._carried(pairs.nearest)
        return Mode(pairs.growth, complex(pairs.mu[pairs.fastest]), self.linearised.seen(x), basis, v, margin)

    def _respond(self, force):
        """Add the response x to a force, (K - J)^-1 of it, and return it."""
        x, layered = self.linearised.inverse(self.inverse.solve, force)
        self._add(x, layered)
        return x

    def _add(self, x, layered):
        """Add the part of x (size,) that is orthogonal to V, if there is room; layered: K x."""
        k = self.rows
        *shares, rest = orthonormalise(self.v, k, x.astype(float))
        if rest:
            self.k[k] = (layered - shares @ self.k[:k]) / rest
            self.w[k] = self.linearised.product(self.v[k], self.k[k])
            self.matrix[: k + 1, k] = self.v[: k + 1] @ self.w[k]
            self.matrix[k, :k] = self.w[:k] @ self.v[k]
            self.rows += 1

    def _pairs(self):
        """The Ritz pairs with |mu| < radius or Re mu > 0 and, where the contact is stiff everywhere, the smallest."""
        n, friction = self.rows, self.friction
        mu, vectors = np.linalg.eig(self.matrix[:n, :n])
        upper = np.flatnonzero(mu.imag >= 0.0)
        upper = upper[np.argsort(inside(mu[upper], friction))]
        mu, vectors = mu[upper], vectors[:, upper]
        nearest, near = vectors[:, :KEPT], np.abs(mu) <= max(self.radius, np.abs(mu).min())
        near |= mu.real > 0.0
        mu, vectors = mu[near], vectors[:, near]
        residuals = vectors.T @ self.w[:n] - (vectors * mu).T @ self.v[:n]
        miss = np.sqrt((np.abs(residuals) ** 2).sum(axis=1))
        rates, depth = rate(mu, friction), inside(mu, friction)
        with np.errstate(over="ignore"):  # none is deep where a pair is as good as growing
            doubt = miss / np.maximum(depth, TINY)
        fastest = int(np.argmax(rates - ROUND_OFF * np.abs(mu)))  # of equal ones, to round-off, the nearest to zero
        error = _error(miss[fastest], mu[fastest], friction)
        return _Pairs(mu, vectors, residuals, depth, doubt, fastest, float(rates[fastest]), error, nearest)

    def _known(self, pairs):
        """Whether the growth is known well enough."""
        sure = pairs.doubt.max() < 1.0  # a residual larger than the distance from growing proves nothing
        clear = sure and pairs.growth < -CLEAR * self.scale
        decided = not self.fine and (sure or pairs.growth > pairs.error)
        return clear or decided or pairs.error < FINE * self.scale

    def _aims(self, pairs):
        """The pairs whose residuals extend the space."""
        worst = int(np.argmax(pairs.doubt))
        if pairs.doubt[worst] < 1.0 or pairs.depth[pairs.fastest] <= 0.0:
            return {pairs.fastest}
        return {worst, pairs.fastest} if self.fine else {worst}

    def _carried(self, nearest):
        """(basis, margin), as of a Mode, from the vectors nearest to growing."""
        n = len(nearest)
        parts = [part for vector in nearest.T for part in _parts(vector)]
        basis = np.linalg.qr(np.array(parts[:KEPT]).T)[0].T
        vectors, layered = basis @ self.v[:n], basis @ self.k[:n]
        onset = np.linalg.solve(vectors @ layered.T, basis @ self.matrix[:n, :n] @ basis.T)
        return tuple(zip(vectors, layered, strict=True)), -float(np.linalg.eigvals(onset).real.max())


def _error(miss, mu, friction):
    """Error of the growth at a Ritz value mu whose unit vector has a residual of length `miss`."""
    if np.isinf(friction):
        return miss
    return min(miss / max(abs(np.sqrt(friction**2 + 4.0 * complex(mu))), TINY), miss**0.5)


def _parts(x):
    """(real part, imaginary part) of x; the latter only if it is not round-off."""
    return (x.real, x.imag) if np.iscomplexobj(x) and np.abs(x.imag).max() > ROUND_OFF * np.abs(x).max() else (x.real,)
