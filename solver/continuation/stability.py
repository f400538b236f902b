"""Whether an equilibrium is a rest of the motion: the growth of the disturbance that grows fastest, real or complex.

A disturbance x exp(lambda t) of a rest obeys (J - K) x = mu x with lambda^2 + gamma lambda = mu. Three kinds may grow:

fold      a real mu passes zero, as does an eigenvalue of the tangent dR/dv of the equilibrium;
soft      on its way there it meets that of a long wave of the layer, |mu| a few k_min, and both become complex;
deep      waves of the contact, |mu| some E: of these `flutter` tells.

The first two are the mu nearest to zero. They are sought in a space V of whole-surface disturbances by Rayleigh-Ritz,
that grows by (K - J)^-1 r, r the residual of the candidate (Davidson 1975 with inverse iteration): a solve with the
tangent of the equilibrium. Spaces are carried from state to state, so that most of them need but the products V -> M V.
"""

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from .flutter import Wave, deep
from .inverse import Inverse, Space, leading


@dataclass(frozen=True)
class Limits:
    """Growths in units of gamma, of k_min in the overdamped limit; |mu| in units of k_min.

    unstable: 1/time, growth from which on an equilibrium is none. dense: size of a disturbance up to which all mu are
    computed; below the damping `weak`, where many modes grow at nearly one rate, up to `weakly_dense`. radius: of |mu|
    within which modes count as near zero; soft pairs form at 5 to 20. wide: the same where waves of the contact may
    flutter, whose softest lie there. kept: vectors carried on, two pairs and two more.
    fine, coarse: error of a growth, of `sure` and of `look`, and 3 times the latter of a wave. clear: a growth below
    minus that need not be known better. sure: growths are told from zero by so many errors. most, some: vectors added
    to the space by `sure` and `look`. room: for all, with those of `flutter`.
    A state is not looked at while the one looked at last is at most `patience` points and `far` units of the problem
    away, less where growths were above minus `calm`, in proportion to their square; while growths that rise as between
    the last two looks, times `steeper`, stay below zero; and while the state moves no more than `speed` times as fast
    with the load as there: towards a fold at distance d that is d^-1/2, so that looks get the denser the nearer it is.
    """

    unstable: float = 1e-6
    dense: int = 32
    weak: float = 0.4
    weakly_dense: int = 300
    radius: float = 20.0
    wide: float = 80.0
    kept: int = 6
    fine: float = 1e-8
    coarse: float = 1e-3
    clear: float = 0.25
    sure: float = 4.0
    most: int = 60
    some: int = 20
    room: int = 300
    calm: float = 0.4
    patience: int = 20
    far: float = 1.5
    speed: float = 1.15
    steeper: float = 4.0


LIMITS = Limits()


@dataclass(frozen=True)
class Stability:
    """Of an equilibrium: growth of its fastest mode, 1/time; kind: of its loss; mode (size,); modes: to go on from."""

    growth: float
    kind: str = "bifurcation"
    mode: np.ndarray | None = None
    modes: object = None

    @property
    def rests(self):
        return self.growth <= LIMITS.unstable


@dataclass(frozen=True)
class Modes:
    """What was found at the last state looked at: growth and v there, the load's speed, points since, and spaces."""

    growth: float
    v: np.ndarray
    speed: float = 0.0  # |dv| per load there
    rise: float = 0.0  # of the growth, per nm of way, since the look before
    since: int = 0
    space: np.ndarray | None = None  # (k, N), orthonormal
    wave: Wave | None = None


class Watch:
    """Looks at the stability of the states of a run with the given damping of its motion, over critical."""

    def __init__(self, damping):
        self.damping, self._scratch = damping, None

    def look(self, problem, v, active, s, state, smooth=None):
        """The Stability of a new state on the branch of `state`; smooth: as `sure`."""
        modes = state.modes
        if state.unsure or not isinstance(modes, Modes) or modes.v.size != v.size:
            return self.sure(problem, v, active, s, smooth=smooth)
        speed = np.abs(v - state.v).max() / max(abs(s - state.load), 1e-300)
        dense = problem.size <= LIMITS.dense  # all mu are to be had at no cost
        if not dense and modes.since < LIMITS.patience and speed < LIMITS.speed * modes.speed:
            way, depth = np.abs(v - modes.v).max(), max(0.0, -modes.growth)
            far = LIMITS.far * problem.unit * min(1.0, depth / (LIMITS.calm * self._scale(problem))) ** 2
            if way < far and LIMITS.steeper * modes.rise * way < depth:
                return Stability(modes.growth, modes=replace(modes, since=modes.since + 1))
        return self._judged(problem, v, active, modes, state.secants, speed, False, smooth)

    def sure(self, problem, v, active, s, modes=None, secants=None, smooth=None):
        """The Stability of an equilibrium, to `fine`; modes, secants: of one nearby, if known.

        smooth: a function close to the inverse of -dR/dv, if one is at hand.
        """
        return self._judged(problem, v, active, modes, secants, 0.0, True, smooth)

    def _scale(self, problem):
        """gamma, or, where that is infinite, k_min: what growths are measured by."""
        critical = problem.motion().critical
        return self.damping * critical if np.isfinite(self.damping) else 0.25 * critical**2

    def _judged(self, problem, v, active, modes, secants, speed, fine, smooth):
        motion = problem.motion()
        maps, friction = motion.disturbance(v, active), self.damping * motion.critical
        space = wave = None
        if maps.size <= (LIMITS.dense if self.damping >= LIMITS.weak else LIMITS.weakly_dense):
            growth, mu, x = _dense(maps, friction)
        else:
            known = modes or Modes(0.0, v)
            waves = self.damping < maps.flutter(motion.critical)
            k_min = 0.25 * motion.critical**2
            radius = (LIMITS.wide if waves else LIMITS.radius) * k_min
            start = self._start(problem, maps, v, active, known.space, secants, smooth)
            _, room, inverse = self._scratch
            scale = self._scale(problem)
            (growth, mu, x), space = near_zero(maps, inverse, friction, radius, scale, start, fine, room.emptied(maps))
            if waves:
                tolerance = (LIMITS.fine if fine else 3.0 * LIMITS.coarse) * friction
                found, wave = deep(
                    maps, room.emptied(maps), friction, rate, LIMITS.radius * k_min, known.wave, tolerance
                )
                if found[0] - 2.0 * found[1] > growth:
                    growth, mu, x = found[0] - 2.0 * found[1], *found[2:]
        kind = "flutter" if abs(mu.imag) > 1e-9 * abs(mu) else "bifurcation"
        way = np.abs(v - modes.v).max() if modes else 0.0
        rise = max(0.0, growth - modes.growth) / way if way > 0.0 else 0.0
        return Stability(growth, kind, maps.seen(_largest(x)), Modes(growth, v, speed, rise, 0, space, wave))

    def _start(self, problem, maps, v, active, space, secants, smooth):
        """The vectors to begin with; readies the memory for this equilibrium."""
        sizes = maps.size, problem.size
        if self._scratch is None or self._scratch[0] != sizes:
            self._scratch = sizes, Space(maps.size, LIMITS.room), Inverse(problem.size)
        inverse = self._scratch[2]
        inverse.of_tangent(problem.tangent(v, active), smooth or problem.smoother(v, active), secants)
        return space if space is not None else np.array([maps.spread(w) for w in leading(inverse)])


def _largest(x):
    """The real part of a mode in the phase in which it is largest: that of an eigenvector is any."""
    return (x * np.exp(-0.5j * np.angle((x * x).sum()))).real


def _dense(maps, friction):
    """(growth, mu, x) of the fastest of all modes."""
    values, vectors = np.linalg.eig(np.array([maps.product(e) for e in np.eye(maps.size)]).T)
    rates = rate(values, friction)
    i = int(np.argmax(rates))
    return float(rates[i]), complex(values[i]), vectors[:, i]


def rate(mu, friction):
    """The larger Re(lambda) of lambda^2 + gamma lambda = mu; Re(mu) for infinite gamma."""
    mu = np.asarray(mu, complex)
    return mu.real if np.isinf(friction) else np.sqrt(friction**2 / 4.0 + mu).real - friction / 2.0


def inside(mu, friction):
    """How far mu lies inside the parabola Im^2 = -friction^2 Re, where disturbances decay, to first order, GPa/nm."""
    depth = -mu.real
    if np.isinf(friction):
        return depth
    steepness = friction * np.sqrt(friction**2 + 4.0 * np.maximum(depth, 0.0))
    return (friction**2 * depth - mu.imag**2) / steepness


def near_zero(maps, inverse, friction, radius, scale, start, fine, space):
    """((growth, mu, x), vectors (k, N)) of the fastest mode with |mu| < radius, GPa/nm, from the vectors `start`.

    scale: of growths; space: an empty Space. Looked at coarsely, it may end once no mode can lie outside the parabola.
    """
    for x in start:
        space.add(x)
    first = space.rows
    space.add(inverse.of(maps, _noise(maps.size)))  # modes of another symmetry than those known come up in this
    most = LIMITS.most if fine else LIMITS.some
    while True:
        values, vectors, strange = _near(space, radius)
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
        growth -= 2.0 * error  # what is called unstable is
    parts = [part for k in np.argsort(depth) for part in _parts(vectors[:, k])]
    basis = np.linalg.qr(np.array(parts[: LIMITS.kept]).T)[0]
    return (growth, complex(values[i]), vectors[:, i] @ space.vectors), basis.T @ space.vectors


@lru_cache(maxsize=4)
def _noise(size):
    """A force at random, (size,), always the same."""
    noise = np.random.default_rng(1).normal(size=size)
    noise.flags.writeable = False
    return noise


def _near(space, radius):
    """(values, vectors, False): Ritz values with |mu| < radius or Re mu > 0, one of each pair; (.., True): none is."""
    values, vectors = np.linalg.eig(space.matrix)
    size = np.abs(values)
    near = (size < radius) | (values.real > 0.0)
    strange = not near.any()  # stiff contact all over, or a space out of date
    if strange:
        near = size <= size.min()
    near &= values.imag >= 0.0
    return values[near], vectors[:, near], strange


def _error(miss, mu, friction):
    """Of the growth at a Ritz value mu, for a residual `miss` per unit of the vector."""
    if np.isinf(friction):
        return miss
    return min(miss / max(abs(np.sqrt(friction**2 + 4.0 * complex(mu))), 1e-300), miss**0.5)


def _parts(x):
    """Real and imaginary part of x, the latter if there is one."""
    return (x.real, x.imag) if np.iscomplexobj(x) and np.abs(x.imag).max() > 1e-10 * np.abs(x).max() else (x.real,)
