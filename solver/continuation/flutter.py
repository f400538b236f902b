"""Deep flutter: waves of the contact that grow as oscillations, their eigenvalues mu far from zero.

As NP1 has no potential, T_x(u_z) and T_z(u_x) can feed a wave more than friction takes. Such waves hardly leave the
patch: where damping is weak, those of the patch alone, all of which are computed, are close to them. Otherwise, and
where the patch is too large, a random disturbance, moved by the linearised motion from state to state, turns into the
wave that grows fastest. Rayleigh-Ritz on these, extended by residuals times 1/(|K + Re mu| + sigma), gives its growth
and the error of that.
"""

from dataclasses import dataclass

import numpy as np

from .motion import of_blocks


@dataclass(frozen=True)
class Limits:
    """Of the search for the wave that grows fastest."""

    dense: int = 700  # unknowns of a patch up to which all modes of the patch alone are computed to begin with
    shifts: int = 4  # waves of the patch alone, near which those of the whole surface are sought
    apart: float = 0.02  # of their mu, at least, over its magnitude
    off: float = 1e-4  # imaginary part, at least, over the magnitude: on the real axis K + mu is singular
    calm: float = 0.35  # gamma; one shift will do where all waves of the patch decay faster: they were 0.15 off at most
    again: int = 3  # the same where J has hardly changed since, near waves of the whole surface found before
    same: float = 0.01  # change of J up to which that will do, over its largest: two waves may change places
    solves: int = 8  # steps of inverse iteration for each
    steps: int = 60  # else: of the linearised motion from one state to the next
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
    """What the search at the next state starts from: a basis (k, N), and the moving disturbance, (N,) each, or None."""

    u: np.ndarray | None  # displacement
    v: np.ndarray | None  # velocity
    basis: np.ndarray
    values: np.ndarray  # mu of the fastest, these first
    tangents: np.ndarray | None = None  # J (4, m) at which waves of the patch alone were computed last


def deep(maps, space, friction, rate, radius, wave, tolerance, weak):
    """((growth, its error, mu, x), Wave) of the disturbance that grows fastest; wave: of a state nearby, or None.

    tolerance: error to which a growth near zero is sought, but for |mu| < radius, where `stability.near_zero` knows
    better. space: an empty `inverse.Space`; rate: `stability.rate`; weak: whether damping is.
    """
    u = v = tangents = None
    if weak and maps.patch_size <= LIMITS.dense:
        tangents, shifts = _shifts(maps, friction, rate, wave)
        start = _near_shifts(maps, shifts)
    else:
        u, v, start = _carried_along(maps, friction, wave)
    for x in (*start, *(wave.basis if wave is not None else ())):
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
    basis = np.linalg.qr(_parts(vectors)[: LIMITS.kept].T)[0].T @ space.vectors
    return (growth, error, complex(values[0]), vectors[:, 0] @ space.vectors), Wave(u, v, basis, values, tangents)


def _parts(vectors):
    """Real and imaginary parts of vectors (N, k), one after the other, those that are not zero; (.., N)."""
    return np.array([p for x in vectors.T for p in (x.real, x.imag) if np.abs(p).max() > 1e-10])


def _shifts(maps, friction, rate, wave):
    """(J, [(mu, start)]): of the fastest waves of the patch alone, some distance apart, and the J for which that is.

    Close to the J of a search before: of the waves that it found.
    """
    tangents, before = maps.tangents, wave and wave.tangents
    if before is not None and np.abs(tangents - before).max() <= LIMITS.same * maps.interface:
        tangents, values, most = before, wave.values, LIMITS.again
        starts = [wave.basis[0]] * values.size
    else:
        values, modes = maps.of_patch()
        order = np.argsort(-rate(values, friction))
        values, starts, most = values[order], (maps.embedded(modes[:, i]) for i in order), LIMITS.shifts
        if rate(values[0], friction) < -LIMITS.calm * friction:
            most = 1
    found = []
    for mu, start in zip(values, starts, strict=True):
        if mu.imag >= 0.0 and all(abs(mu - other) > LIMITS.apart * abs(other) for other, _ in found):
            found.append((complex(mu.real, max(mu.imag, LIMITS.off * abs(mu))), start))
        if len(found) == most:
            break
    return tangents, found


def _near_shifts(maps, shifts):
    """Disturbances (k, N) that hold the waves of the whole surface with mu next to the shifts: inverse iteration."""
    found = []
    for mu, x in shifts:
        solve = maps.shifted(mu)
        for _ in range(LIMITS.solves):
            x = solve(x)
            x = x / np.linalg.norm(x)
            found += [x.real, x.imag]
    return found


def _carried_along(maps, friction, wave):
    """(u, v, last displacements and v): the wave, or a random disturbance, after some steps of the linearised motion.

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
    return u * scale, v * scale, [*seen, v]
