"""Whether an equilibrium is stable under the damped motion; only this module decides that.

A disturbance x exp(lambda t) of an equilibrium obeys (J - K) x = mu x with lambda^2 + gamma lambda = mu. It may grow as

fold     a real mu passes zero, and with it an eigenvalue of the equilibrium's tangent dR/dv;
flutter  on its way to zero that mu meets the mu of a long wave of the layer, |mu| a few k_min: both turn complex.

Both have the mu nearest to zero. A Rayleigh-Ritz search finds it in a space of disturbances of the whole surface, which
each step extends by (K - J)^-1 r, with r the residual of a Ritz pair (Davidson 1975, with inverse iteration). The next
state's search starts from the vectors of the last one. Waves of the contact, with mu far from zero, may flutter where
damping is below the safe one of `flutter`. Small problems and flats are judged by all their mu; elsewhere a frame
estimates that damping when asked.
"""

from dataclasses import dataclass

import numpy as np

from .inverse import Inverse, Space

ROUND_OFF = 1e-9  # of the largest eigenvalue: with a smaller imaginary part, from round-off, one counts as real


@dataclass(frozen=True)
class Limits:
    """Growth rates over twice the decay of the layer's slowest mode, |mu| over k_min, unless the comment differs."""

    unstable: float = 1e-6  # growth, 1/time, above which an equilibrium is unstable: round-off of flats makes 1e-8
    dense_waves: int = 256  # size of a disturbance up to which all its mu are computed where waves may flutter: 0.1 s
    radius: float = 20.0  # |mu| below which a mode counts as near zero; pairs of flutter form at 5 to 20
    kept: int = 4  # vectors from which the next search starts: two complex pairs
    sure: float = 2.0  # residual of a mode near zero, over its distance from growing, up to which it counts as known
    fine: float = 1e-8  # error of a growth where an end is located
    # growth rates below -clear count as safely stable; none is below -0.5. 0.25 was too lax: on a soft layer (E = 10)
    # flutter began between two searches
    clear: float = 0.4
    most: int = 60  # vectors that a search may add; disturbances up to that size have all their mu computed
    # units, times the margin: a state is accepted without a search while the growth is `clear` and no unknown has moved
    # farther since the last one. Towards a fold, margin and movement shrink as the root of the distance in load
    far: float = 0.8


LIMITS = Limits()


@dataclass(frozen=True)
class Mode:
    """The disturbance of an equilibrium that grows fastest, with unknowns x (size,); the next search starts from it.

    growth, 1/time; mu, GPa/nm. hidden: a wave grows that one node for all cannot show; x is then the uniform mode.
    """

    growth: float
    mu: complex
    x: np.ndarray | None
    hidden: bool = False
    basis: tuple = ()  # of (x (N,), K x), disturbances near zero
    v: np.ndarray | None = None  # (size,) the state that was searched
    margin: float = 0.0  # distance from a fold, in stiffness: one minus the largest eigenvalue of K^-1 J in the basis

    @property
    def rests(self) -> bool:
        """Whether the equilibrium is stable, to `LIMITS.unstable`."""
        return self.growth <= LIMITS.unstable

    @property
    def kind(self) -> str:
        """The kind of end at its onset, as of `state.LimitPoint`, unless that is a fold."""
        return "flutter" if abs(self.mu.imag) > ROUND_OFF * abs(self.mu) else "bifurcation"


class Judge:
    """Judges the states of a run, under a motion of that damping over critical; keeps only scratch."""

    def __init__(self, damping):
        self.damping, self._scratch = damping, None

    def accept(self, problem, v, active, known=None, smooth=None) -> Mode:
        """The Mode of an equilibrium v (size,): the one `known` of an earlier state where no search is needed.

        smooth: a function close to the inverse of -dR/dv, if one is at hand.
        """
        here, fits = problem.linearised(v, active), _fits(known, v)
        near = fits and np.abs(v - known.v).max() < LIMITS.far * problem.unit * min(known.margin, 1.0)
        clear = near and known.growth < -LIMITS.clear * self._scale(problem)
        if clear and (here.size > LIMITS.dense_waves or self.damping >= here.safe_damping()):
            return known
        return self._looked(problem, here, v, active, known, smooth, fine=not fits)

    def rightmost(self, problem, v, active, known=None, smooth=None) -> Mode:
        """The same by a search in any case, to `fine`."""
        return self._looked(problem, problem.linearised(v, active), v, active, known, smooth, fine=True)

    def _scale(self, problem):
        """What growths are compared with: twice the decay of the layer's slowest mode, gamma up to critical damping."""
        critical = problem.motion().critical
        return -2.0 * float(rate(-0.25 * critical**2, self.damping * critical))

    def _looked(self, problem, here, v, active, known, smooth, fine):
        critical, fits = problem.motion().critical, _fits(known, v)
        friction = self.damping * critical
        if (waves := here.waves()) is not None:
            return _of_waves(here, *waves, friction)
        if here.size <= LIMITS.most:
            return _dense(here, friction)
        if here.size <= LIMITS.dense_waves and self.damping < here.safe_damping():
            return _dense(here, friction)
        space, inverse = self._emptied(problem, here, smooth)
        radius, start = LIMITS.radius * 0.25 * critical**2, known.basis if fits else ()
        found = _near_zero(here, inverse, friction, radius, self._scale(problem), start, fine, space)
        growth, mu, x, basis, margin = found
        return Mode(growth, mu, here.seen(x), False, basis, v, margin)

    def _emptied(self, problem, here, smooth):
        """An empty Space and Inverse for this equilibrium, in memory used again."""
        sizes = here.size, problem.size
        if self._scratch is None or self._scratch[0] != sizes:
            room = LIMITS.kept + LIMITS.most + 8
            self._scratch = sizes, Space(here.size, room), Inverse(problem.size)
        _, space, inverse = self._scratch
        return space.emptied(here), inverse.of_tangent(here.tangent, smooth)


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


def _fits(known, v):
    """Whether a Mode holds what a look at the state v may start from."""
    return known is not None and known.v is not None and known.v.shape == v.shape


def _largest_phase(x):
    """The real part of an eigenvector, turned to the phase in which it is largest."""
    return (x * np.exp(-0.5j * np.angle((x * x).sum()))).real


def _dense(here, friction):
    """The Mode among all of them."""
    values, vectors = np.linalg.eig(np.array([here.product(e) for e in np.eye(here.size)]).T)
    rates = rate(values, friction)
    i = int(np.argmax(rates))
    return Mode(float(rates[i]), complex(values[i]), here.seen(_largest_phase(vectors[:, i])))


def _of_waves(here, mu, shown, friction):
    """The Mode where every mode is a wave, arguments as of `Linearised.waves`."""
    rates = rate(mu, friction)
    fastest = np.unravel_index(np.argmax(rates), mu.shape)
    growth, x = float(rates[fastest]), shown(*fastest)
    hidden = x is None and growth > LIMITS.unstable
    if x is None:
        x = shown(int(np.argmax(rates[:, 0])), 0)
    fastest = complex(mu[fastest])
    if abs(fastest.imag) <= ROUND_OFF * np.abs(mu).max():
        fastest = complex(fastest.real)
    return Mode(growth, fastest, here.seen(_largest_phase(x)), hidden)


def _near_zero(here, inverse, friction, radius, scale, start, fine, space):
    """(growth, mu, x, basis to go on from, its margin) of the fastest mode with |mu| < radius, GPa/nm.

    start: vectors to begin with; scale: of growths; space: an empty Space. Unless `fine`, the search ends once it is
    told whether a mode lies outside the parabola.
    """
    for pair in start:
        space.add(*pair)
    other = here.noise  # else modes of another symmetry would be missed
    for _ in range(2):  # the second time rids it of what does not grow
        other, layered = here.inverse(inverse.solve, other)
        space.add(other, layered)
    most = space.rows + LIMITS.most
    while True:
        found = _Ritz(space, friction, radius, scale)
        rows = space.rows
        if found.settled(fine):
            break
        for aim in found.aims(fine):
            for part in _parts(found.residuals[aim]):
                space.add(*here.inverse(inverse.solve, part))
        if not rows < space.rows < most:
            break
    return found.growth, *found.carried()


class _Ritz:
    """The Ritz pairs of a Space next to zero: their rates, how far they are from growing, and how sure that is."""

    def __init__(self, space, friction, radius, scale):
        self.every, self.values, self.vectors = _ritz_pairs(space, friction, radius)
        self.scale, self.known, self.layered, self.matrix = scale, space.vectors, space.layered, space.matrix
        self.depth, rates = inside(self.values, friction), rate(self.values, friction)
        self.residuals = space.residuals(self.vectors, self.values)
        miss = np.sqrt((np.abs(self.residuals) ** 2).sum(axis=1))
        self.fastest = int(np.argmax(rates - 1e-9 * np.abs(self.values)))
        self.growth = float(rates[self.fastest])
        self.error = _error(miss[self.fastest], self.values[self.fastest], friction)
        doubt = miss / np.maximum(self.depth, 1e-300)
        self.worst = int(np.argmax(doubt))
        self.sure = doubt[self.worst] < LIMITS.sure

    def settled(self, fine):
        """Whether the growth is known well enough."""
        told = self.sure or self.growth > self.error
        clear = self.sure and self.growth < -LIMITS.clear * self.scale
        return clear or self.error < LIMITS.fine * self.scale or (told and not fine)

    def aims(self, fine):
        """The pairs whose residuals extend the space."""
        if self.sure or self.depth[self.fastest] <= 0.0:
            return {self.fastest}
        return {self.worst, self.fastest} if fine else {self.worst}

    def carried(self):
        """(mu and x of the fastest mode; basis and margin, as of a Mode, of those nearest to growing)."""
        parts = [part for vector in self.every.T[: LIMITS.kept] for part in _parts(vector)]
        basis = np.linalg.qr(np.array(parts[: LIMITS.kept]).T)[0].T
        x = _largest_phase(self.vectors[:, self.fastest] @ self.known)
        vectors, layered = basis @ self.known, basis @ self.layered
        onset = np.linalg.solve(vectors @ layered.T, basis @ self.matrix @ basis.T)
        margin = -float(np.linalg.eigvals(onset).real.max())
        return complex(self.values[self.fastest]), x, tuple(zip(vectors, layered, strict=True)), margin


def _ritz_pairs(space, friction, radius):
    """(all vectors, in the order in which they grow; values and vectors near zero), one of each complex pair.

    Near zero are those with |mu| < radius or Re mu > 0, and where the contact is stiff everywhere, the smallest.
    """
    values, vectors = np.linalg.eig(space.matrix)
    one = np.flatnonzero(values.imag >= 0.0)
    one = one[np.argsort(inside(values[one], friction))]
    values, vectors = values[one], vectors[:, one]
    near = (np.abs(values) < max(radius, 1.001 * np.abs(values).min())) | (values.real > 0.0)
    return vectors, values[near], vectors[:, near]


def _error(miss, mu, friction):
    """Error of the growth at a Ritz value mu whose unit vector has a residual of length `miss`."""
    if np.isinf(friction):
        return miss
    return min(miss / max(abs(np.sqrt(friction**2 + 4.0 * complex(mu))), 1e-300), miss**0.5)


def _parts(x):
    """(real part, imaginary part) of x; the latter only if it is not round-off."""
    return (x.real, x.imag) if np.iscomplexobj(x) and np.abs(x.imag).max() > 1e-10 * np.abs(x).max() else (x.real,)
