"""Whether an equilibrium is a rest of the motion: the growth Re(lambda) of the disturbance that grows fastest.

A disturbance x exp(lambda t) of a rest obeys (J - K) x = mu x with lambda^2 + gamma lambda = mu. Three kinds may grow:

fold           a real mu passes zero, and with it an eigenvalue of the equilibrium's tangent dR/dv;
soft flutter   on its way to zero it meets the mu of a long wave of the layer, |mu| a few k_min: both turn complex;
deep flutter   waves of the contact, with |mu| of the order of E: found by `flutter`.

The first two have the mu nearest to zero. They are sought by Rayleigh-Ritz in a space V of whole-surface disturbances,
which is extended by (K - J)^-1 r, with r the residual of a Ritz pair (Davidson 1975, with inverse iteration): a solve
with the tangent. Spaces are carried from state to state, so that most states need only the products M V, M = J - K.
"""

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from .flutter import Wave, deep
from .inverse import Inverse, Space, leading


@dataclass(frozen=True)
class Limits:
    """Growths over gamma (over k_min in the overdamped limit), |mu| over k_min, unless said otherwise."""

    unstable: float = 1e-6  # growth, 1/time, above which an equilibrium does not rest
    dense: int = 32  # size of a disturbance up to which all its mu are computed
    dense_waves: int = 700  # the same where deep flutter is possible: many waves may grow at nearly one rate
    weak: float = 0.4  # damping, over critical, below which nearly all waves grow at one rate
    radius: float = 20.0  # |mu| below which a mode counts as near zero; pairs of soft flutter form at 5 to 20
    wide: float = 80.0  # the same where deep flutter is possible: its softest waves lie there
    kept: int = 6  # vectors carried to the next state: two complex pairs and two more
    fine: float = 1e-8  # error of a growth, by `sure`
    coarse: float = 1e-3  # error of a growth, by `look`; three times that for waves of deep flutter
    clear: float = 0.25  # a growth below minus that need not be known better
    sure: float = 4.0  # errors by which a growth must differ from zero to be told from it
    others: int = 3  # vectors of no known symmetry that `sure` begins with; with one a mode of growth gamma was missed
    most: int = 60  # vectors that `sure` may add to the space
    some: int = 20  # vectors that `look` may add
    room: int = 300  # vectors for which there is memory, those of `flutter` included
    # `look` takes a state to rest, without a look, while all of this holds, compared with the one looked at last:
    patience: int = 20  # no more states than that have been passed over
    # units of the problem, farthest; times (growth/calm)^2 where -growth is less than `calm`. At 0.5 waves on rough and
    # sinusoidal surfaces of nu 0.499 were missed: all modes but the softest decay at -gamma/2, however soft they become
    far: float = 0.2
    calm: float = 0.4  # see `far`
    # the change of the skew part of J may have raised the damping below which a wave flutters by this part of what it
    # lacked of the scene's damping; estimated for a wave as stiff as the interface
    skewer: float = 0.5
    # J may have changed by this times -mu of the softest mode; at 20 a stiffer mode overtook that one unseen
    softer: float = 10.0
    steeper: float = 4.0  # the growth is negative even if it rose so many times as steeply as between the last looks
    # states move with the load at most so many times as fast. Towards a fold at a distance d in load the speed goes as
    # d^-1/2, so that looks get the denser the nearer it is
    speed: float = 1.15


LIMITS = Limits()


@dataclass(frozen=True)
class Stability:
    """Of an equilibrium: growth of its fastest mode, 1/time, kind, unknowns (size,); Modes for the next state."""

    growth: float
    kind: str = "bifurcation"
    mode: np.ndarray | None = None
    modes: object = None

    @property
    def rests(self):
        return self.growth <= LIMITS.unstable


@dataclass(frozen=True)
class Modes:
    """What was found at the state looked at last, with v there; and what the next search starts from."""

    growth: float
    v: np.ndarray
    speed: float = 0.0  # |dv| per load there
    rise: float = 0.0  # of the growth since the look before, per nm of |dv|
    mu: float = -np.inf  # GPa/nm, real part of its mu, which tells how soft it is where its growth is -gamma/2
    since: int = 0  # states passed over since
    space: np.ndarray | None = None  # (k, N), orthonormal disturbances near zero
    wave: Wave | None = None
    flutter: float = 0.0  # damping above which no wave flutters deeply, by `disturbance.flutter`
    tangents: np.ndarray | None = None  # J on the patch, (4, m) GPa/nm


class Watch:
    """Tells whether the states of a run rest, under a motion of that damping over critical."""

    def __init__(self, damping):
        self.damping, self._scratch = damping, None

    def look(self, problem, v, active, s, state, smooth=None):
        """The Stability of a state that follows `state` on its branch, to `coarse`; smooth: as in `sure`."""
        modes = state.modes
        if state.unsure or modes is None or modes.v.size != v.size:
            return self.sure(problem, v, active, smooth=smooth)
        speed = np.abs(v - state.v).max() / max(abs(s - state.load), 1e-300)
        dense = problem.size <= LIMITS.dense  # all mu are had at no cost
        if not dense and modes.since < LIMITS.patience and speed < LIMITS.speed * modes.speed:
            way, depth = np.abs(v - modes.v).max(), max(0.0, -modes.growth)
            far = LIMITS.far * problem.unit * min(1.0, depth / (LIMITS.calm * self._scale(problem))) ** 2
            calm = way < far and LIMITS.steeper * modes.rise * way < depth
            if calm and not self._turned(problem, v, active, modes):
                return Stability(modes.growth, modes=replace(modes, since=modes.since + 1))
        return self._judged(problem, v, active, modes, state.secants, speed, False, smooth)

    def sure(self, problem, v, active, modes=None, secants=None, smooth=None):
        """The Stability of an equilibrium, to `fine`; modes, secants: of a state nearby, if known.

        smooth: a function close to the inverse of -dR/dv, if one is at hand.
        """
        return self._judged(problem, v, active, modes, secants, 0.0, True, smooth)

    def _turned(self, problem, v, active, modes):
        """Whether J has changed so much since the last look that a mode may have become unstable."""
        if modes.tangents is None:
            return False
        motion = problem.motion()
        maps = motion.disturbance(v, active)
        change = maps.tangents - modes.tangents
        if np.abs(change).max() > LIMITS.softer * max(0.0, -modes.mu):
            return True
        skew = 0.5 * np.abs(change[1] - change[2]).max()
        if modes.wave is not None or skew == 0.0:
            return False
        left = (self.damping - modes.flutter) * motion.critical
        return skew > LIMITS.skewer * left * np.sqrt(maps.interface)

    def _scale(self, problem):
        """gamma, or k_min where gamma is infinite: what growths are compared with."""
        critical = problem.motion().critical
        return self.damping * critical if np.isfinite(self.damping) else 0.25 * critical**2

    def _judged(self, problem, v, active, modes, secants, speed, fine, smooth):
        motion = problem.motion()
        maps, friction = motion.disturbance(v, active), self.damping * motion.critical
        space = wave = None
        small = maps.size <= LIMITS.dense
        flutter = 0.0 if small else maps.flutter(motion.critical)
        waves = self.damping < flutter
        if small or (waves and maps.size <= LIMITS.dense_waves and not maps.alike()):
            growth, mu, x = _dense(maps, friction)
        elif maps.alike():
            growth, mu, x = _of_waves(maps, friction)
        else:
            known = modes or Modes(0.0, v)
            k_min = 0.25 * motion.critical**2
            radius = (LIMITS.wide if waves else LIMITS.radius) * k_min
            start = self._start_vectors(problem, maps, v, active, known.space, secants, smooth)
            _, room, inverse = self._scratch
            scale = self._scale(problem)
            (growth, mu, x), space = near_zero(maps, inverse, friction, radius, scale, start, fine, room.emptied(maps))
            if waves:
                tolerance, room = (LIMITS.fine if fine else 3.0 * LIMITS.coarse) * friction, room.emptied(maps)
                weak, inner = self.damping < LIMITS.weak, LIMITS.radius * k_min
                found, wave = deep(maps, room, friction, rate, inner, known.wave, tolerance, weak)
                if found[0] - 2.0 * found[1] > growth:
                    growth, mu, x = found[0] - 2.0 * found[1], *found[2:]
        kind = "flutter" if abs(mu.imag) > 1e-9 * abs(mu) else "bifurcation"
        way = np.abs(v - modes.v).max() if modes else 0.0
        rise = max(0.0, growth - modes.growth) / way if way > 0.0 else 0.0
        tangents = None if small else maps.tangents
        found = Modes(growth, v, speed, rise, mu.real, 0, space, wave, flutter, tangents)
        return Stability(growth, kind, maps.seen(_largest_phase(x)), found)

    def _start_vectors(self, problem, maps, v, active, space, secants, smooth):
        """The vectors that the search starts from; makes the scratch ready for this equilibrium."""
        sizes = maps.size, problem.size
        if self._scratch is None or self._scratch[0] != sizes:
            self._scratch = sizes, Space(maps.size, LIMITS.room), Inverse(problem.size)
        inverse = self._scratch[2]
        inverse.of_tangent(problem.tangent(v, active), smooth or problem.smoother(v, active), secants)
        return space if space is not None else np.array([maps.spread(w) for w in leading(inverse)])


def _largest_phase(x):
    """The real part of an eigenvector, turned to the phase in which it is largest."""
    return (x * np.exp(-0.5j * np.angle((x * x).sum()))).real


def _dense(maps, friction):
    """(growth, mu, x) of the fastest of all modes."""
    values, vectors = np.linalg.eig(np.array([maps.product(e) for e in np.eye(maps.size)]).T)
    rates = rate(values, friction)
    i = int(np.argmax(rates))
    return float(rates[i]), complex(values[i]), vectors[:, i]


def _of_waves(maps, friction):
    """The same where every mode is a wave."""
    values, amplitudes = maps.waves()
    q, i = np.unravel_index(np.argmax(rate(values, friction)), values.shape)
    return float(rate(values[q, i], friction)), complex(values[q, i]), maps.wave(q, amplitudes[q, :, i])


def rate(mu, friction):
    """The larger Re(lambda) of lambda^2 + gamma lambda = mu; Re(mu) for infinite gamma."""
    mu = np.asarray(mu, complex)
    return mu.real if np.isinf(friction) else np.sqrt(friction**2 / 4.0 + mu).real - friction / 2.0


def inside(mu, friction):
    """Distance, to first order, of mu from the parabola Im^2 = -friction^2 Re within which modes decay, GPa/nm."""
    depth = -mu.real
    if np.isinf(friction):
        return depth
    steepness = friction * np.sqrt(friction**2 + 4.0 * np.maximum(depth, 0.0))
    return (friction**2 * depth - mu.imag**2) / steepness


def near_zero(maps, inverse, friction, radius, scale, start, fine, space):
    """((growth, mu, x), vectors (k, N) to go on from) of the fastest mode with |mu| < radius, GPa/nm.

    start: vectors to begin with; scale: of growths; space: an empty Space. Unless `fine`, the search ends once it is
    told whether a mode lies outside the parabola.
    """
    for x in start:
        space.add(x)
    first = space.rows
    other = _noise(maps.size)  # else modes of another symmetry than those known would be missed
    for _ in range(LIMITS.others if fine else 1):
        other = inverse.of(maps, other)
        space.add(other)
    most = LIMITS.most if fine else LIMITS.some
    while True:
        values, vectors, strange = _ritz_pairs(space, radius)
        depth, rates = inside(values, friction), rate(values, friction)
        residuals = space.residuals(vectors, values)
        miss = np.sqrt((np.abs(residuals) ** 2).sum(axis=1))
        i = int(np.argmax(rates - 1e-9 * np.abs(values)))
        growth, error = float(rates[i]), _error(miss[i], values[i], friction)
        doubt = miss / np.maximum(depth, 1e-300) * (LIMITS.sure if strange else 1.0)
        worst = int(np.argmax(doubt))
        told = doubt[worst] < 1.0 or growth > LIMITS.sure * error
        clear = doubt[worst] < 1.0 and growth < -LIMITS.clear * scale
        rows = space.rows
        if clear or error < LIMITS.fine * scale or (told and not fine) or rows - first >= most:
            break
        aims = {i} if doubt[worst] < 1.0 or depth[i] <= 0.0 else {worst, i} if fine else {worst}
        for aim in aims:
            for part in _parts(residuals[aim]):
                space.add(inverse.of(maps, part))
        if space.rows == rows:
            break
    if growth > 0.0 and error > LIMITS.coarse * scale:
        growth -= 2.0 * error  # so that what is called unstable is
    parts = [part for k in np.argsort(depth) for part in _parts(vectors[:, k])]
    basis = np.linalg.qr(np.array(parts[: LIMITS.kept]).T)[0]
    return (growth, complex(values[i]), vectors[:, i] @ space.vectors), basis.T @ space.vectors


@lru_cache(maxsize=4)
def _noise(size):
    """A force at random, (size,), always the same."""
    noise = np.random.default_rng(1).normal(size=size)
    noise.flags.writeable = False
    return noise


def _ritz_pairs(space, radius):
    """(values, vectors, strange) with |mu| < radius or Re mu > 0, one of each complex pair; strange: there is none."""
    values, vectors = np.linalg.eig(space.matrix)
    size = np.abs(values)
    near = (size < radius) | (values.real > 0.0)
    strange = not near.any()  # contact is stiff everywhere, or the space is out of date: then the smallest
    if strange:
        near = size <= size.min()
    near &= values.imag >= 0.0
    return values[near], vectors[:, near], strange


def _error(miss, mu, friction):
    """Error of the growth at a Ritz value mu whose unit vector has a residual of length `miss`."""
    if np.isinf(friction):
        return miss
    return min(miss / max(abs(np.sqrt(friction**2 + 4.0 * complex(mu))), 1e-300), miss**0.5)


def _parts(x):
    """(real part, imaginary part) of x; the latter only if it is not round-off."""
    return (x.real, x.imag) if np.iscomplexobj(x) and np.abs(x.imag).max() > 1e-10 * np.abs(x).max() else (x.real,)
