"""Deep flutter: waves of the contact that grow as oscillations, their eigenvalues mu far from zero.

As NP1 has no potential, T_x(u_z) and T_z(u_x) can feed a wave more than friction takes. A random disturbance, moved by
the linearised motion from state to state, turns into the wave that grows fastest. Rayleigh-Ritz on the displacements it
passes through, extended by residuals times 1/(|K + Re mu| + sigma), gives its growth and the error of that.
"""

from dataclasses import dataclass

import numpy as np

from .motion import of_blocks


@dataclass(frozen=True)
class Limits:
    """Of the search for the wave that grows fastest."""

    steps: int = 60  # of the linearised motion from one state to the next
    first: int = 600  # the same at the first state, from a random disturbance
    stride: float = 0.6  # of a step, over the inverse of the largest frequency; longer ones make fast waves grow
    seen: int = 8  # last displacements of that motion, with which Rayleigh-Ritz begins
    kept: int = 12  # vectors carried to the next state
    block: int = 2  # fastest waves by whose residuals a round extends the space
    rounds: int = 2  # so many of them
    most: int = 12  # rounds at most where the growth is not told from zero: within twice its error plus `near` gamma
    near: float = 0.05  # see `most`
    noise: float = 1e-3  # random part added to the wave at every state, relative, so that others can come up


LIMITS = Limits()


@dataclass(frozen=True)
class Wave:
    """What the search at the next state starts from: the moving disturbance, (N,) each, and a basis (k, N)."""

    u: np.ndarray  # displacement
    v: np.ndarray  # velocity
    basis: np.ndarray


def deep(maps, space, friction, rate, radius, wave, tolerance):
    """((growth, its error, mu, x), Wave) of the disturbance that grows fastest; wave: of a state nearby, or None.

    tolerance: error to which a growth near zero is sought, but for |mu| < radius, where `stability.near_zero` knows
    better. space: an empty `inverse.Space`; rate: `stability.rate`.
    """
    u, v, seen = _carried_along(maps, friction, wave)
    for x in (*seen, v, *(wave.basis if wave is not None else ())):
        space.add(x)
    sigma, rounds = maps.interface, 0
    while True:
        values, vectors = np.linalg.eig(space.matrix)
        upper = np.flatnonzero(values.imag >= 0.0)
        rates = rate(values[upper], friction)
        best = upper[np.argsort(-rates)][: LIMITS.kept]
        values, vectors = values[best], vectors[:, best]
        residuals = space.residuals(vectors[:, : LIMITS.block], values[: LIMITS.block])
        growth = float(rate(values[0], friction))
        error = float(np.linalg.norm(residuals[0]) / abs(np.sqrt(friction**2 + 4.0 * complex(values[0]))))
        unsure = error > tolerance and abs(values[0]) > radius and abs(growth) < 2.0 * error + LIMITS.near * friction
        if rounds >= (LIMITS.most if unsure else LIMITS.rounds):
            break
        rounds += 1
        for value, residual in zip(values, residuals, strict=False):
            inverse = of_blocks(maps.stiffness, lambda k, shift=value.real: 1.0 / (np.abs(k + shift) + sigma))
            for part in (residual.real, residual.imag) if value.imag else (residual.real,):
                space.add(maps.filtered(part, inverse))
    parts = [p for k in range(best.size) for p in (vectors[:, k].real, vectors[:, k].imag) if np.abs(p).max() > 1e-10]
    basis = np.linalg.qr(np.array(parts[: LIMITS.kept]).T)[0].T @ space.vectors
    return (growth, error, complex(values[0]), vectors[:, 0] @ space.vectors), Wave(u, v, basis)


def _carried_along(maps, friction, wave):
    """(u, v, last displacements): the wave, or a random disturbance, after some steps of the linearised motion.

    u and v are scaled to a largest u of one. Steps are Newmark's, as in `motion`: central differences, with a mass that
    makes modes of the layer stable.
    """
    rng = np.random.default_rng(0)
    if wave is None:
        u, v, steps = rng.normal(size=maps.size), np.zeros(maps.size), LIMITS.first
    else:
        u, v, steps = wave.u + LIMITS.noise * rng.normal(size=maps.size), wave.v, LIMITS.steps
    # faster waves cannot grow: for them the asymmetry of J is too small against friction
    fastest = min((maps.asymmetry / friction) ** 2, maps.stiffest) + maps.interface
    dt = LIMITS.stride / np.sqrt(fastest)
    inverse = of_blocks(maps.stiffness, lambda k: 1.0 / (1.0 + 0.25 * dt * dt * (k + maps.interface)))
    seen, drag = [], 0.5 * friction * dt
    for left in range(steps, 0, -1):
        v = ((1.0 - drag) * v + dt * maps.filtered(maps.product(u), inverse)) / (1.0 + drag)
        u = u + dt * v
        if left <= LIMITS.seen:
            seen.append(u)
    scale = 1.0 / np.abs(u).max()
    return u * scale, v * scale, seen
