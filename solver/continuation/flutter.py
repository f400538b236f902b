"""Flutter deep in the spectrum: waves of the contact that grow as oscillations, with no mode near zero to tell.

NP1 has no potential, so T_x(u_z) and T_z(u_x) can feed a wave that friction does not calm. A disturbance at random,
taken along by the linearised motion itself from state to state, turns into the wave that grows most; Rayleigh-Ritz on
what it passes through, and on residuals times 1/(|K + Re mu| + sigma), tells its growth and the error of that.
"""

from dataclasses import dataclass

import numpy as np

from .motion import _blocks


@dataclass(frozen=True)
class Limits:
    """steps: of the motion from one state to the next, `first` at the first. stride: over the largest frequency;
    Verlet's scheme makes fast waves grow at longer ones. seen: displacements among which the wave is sought. kept:
    vectors carried on. rounds: of expansion by the residuals of the `block` fastest; `most` where the growth is near
    zero: within twice its error and `near` gamma. noise: of a wave at random, relative, added from state to state, so
    that others can come up.
    """

    steps: int = 60
    first: int = 600
    stride: float = 0.6
    seen: int = 8
    kept: int = 12
    rounds: int = 2
    most: int = 12
    block: int = 2
    noise: float = 1e-3
    near: float = 0.05


LIMITS = Limits()


@dataclass(frozen=True)
class Wave:
    """What goes on to the next state: displacement and velocity of the disturbance, (N,) each, and a basis (k, N)."""

    u: np.ndarray
    v: np.ndarray
    basis: np.ndarray


def deep(maps, space, friction, rate, radius, wave, tolerance):
    """((growth, its error, mu, x), Wave) of the fastest disturbance that is found; wave: of a state nearby, or None.

    tolerance: of the error, for a growth near zero, but of modes with |mu| < radius, which are known better by other
    means. space: an empty `inverse.Space`.
    """
    u, v, seen = _moved(maps, friction, wave)
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
            inverse = _blocks(maps.stiffness, lambda k, shift=value.real: 1.0 / (np.abs(k + shift) + sigma))
            for part in (residual.real, residual.imag) if value.imag else (residual.real,):
                space.add(maps.filtered(part, inverse))
    parts = [p for k in range(best.size) for p in (vectors[:, k].real, vectors[:, k].imag) if np.abs(p).max() > 1e-10]
    basis = np.linalg.qr(np.array(parts[: LIMITS.kept]).T)[0].T @ space.vectors
    return (growth, error, complex(values[0]), vectors[:, 0] @ space.vectors), Wave(u, v, basis)


def _moved(maps, friction, wave):
    """(u, v, displacements passed through), scaled to a largest u of one."""
    rng = np.random.default_rng(0)
    if wave is None:
        u, v, steps = rng.normal(size=maps.size), np.zeros(maps.size), LIMITS.first
    else:
        u, v, steps = wave.u + LIMITS.noise * rng.normal(size=maps.size), wave.v, LIMITS.steps
    # no wave faster than this can grow: its 2 x 2 blocks differ from symmetric ones by too little
    fastest = min((maps.asymmetry / friction) ** 2, maps.stiffest) + maps.interface
    dt = LIMITS.stride / np.sqrt(fastest)
    inverse = _blocks(maps.stiffness, lambda k: 1.0 / (1.0 + 0.25 * dt * dt * (k + maps.interface)))
    seen, drag = [], 0.5 * friction * dt
    for left in range(steps, 0, -1):
        v = ((1.0 - drag) * v + dt * maps.filtered(maps.product(u), inverse)) / (1.0 + drag)
        u = u + dt * v
        if left <= LIMITS.seen:
            seen.append(u)
    scale = 1.0 / np.abs(u).max()
    return u * scale, v * scale, seen
