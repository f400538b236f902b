"""The contracts of `solver.continuation`: of a problem, held by every problem, and of a stepper, by every method."""

import numpy as np
import pytest
import toys
from transients import Fire, Halving, MassWeighted

from solver import Scene
from solver.continuation.gfmd import Gfmd
from solver.continuation.problem import Dynamics, Linearised, Problem, Stepper
from solver.continuation.quasistatic import QuasiStatic
from solver.continuation.rest import MOST
from solver.continuation.state import NotConverged, State
from solver.mechanics.contact import Contact, patch
from solver.mechanics.equilibrium import Equilibrium
from solver.mechanics.surface import closed_stiffness
from solver.run.load_steps import sideways

PUNCH = Scene(nodes=128, width=312.5, radius=1.0, E=20.0, delta_bar=0.2)  # of so small a radius that a patch is less


def on_patch():
    return Equilibrium(Contact(PUNCH, *patch(PUNCH)), sideways(1.0, -PUNCH.delta))


def on_all_nodes():
    return Equilibrium(Contact(PUNCH, 0, PUNCH.nodes), sideways(1.0, -PUNCH.delta))


def flat():
    scene = PUNCH.changed(surface="flat", nodes=24, width=58.6)
    return Equilibrium(Contact(scene, 0, 24), sideways(-1.0, -scene.delta))


def held(problem, pressure):
    return Equilibrium(problem.contact, problem.loading, pressure)


PROBLEMS = {
    "patch": on_patch,
    "all nodes": on_all_nodes,
    "flat": flat,
    "held load": lambda: held(on_patch(), -1e-3),
    "held load, flat": lambda: held(flat(), 2e-3),
    "cubic": toys.cubic,
    "lattice": lambda: toys.lattice((1.0, 0.0)),
    "spiral": toys.spiral,
}
S = 0.7  # nm, a load


@pytest.fixture(params=PROBLEMS)
def problem(request):
    return PROBLEMS[request.param]()


def state(problem):
    """(v) near an equilibrium, off the symmetry of the surface."""
    v = problem.undeformed(S)
    v = v + 0.1 * np.random.default_rng(0).uniform(-1.0, 1.0, v.size)
    return v


def residual(problem, v, s=S):
    out = np.empty(problem.size)
    worst = problem.residual(v, s, out)
    assert worst == np.abs(out).max()
    return out


def members(protocol):
    return [name for name in {**protocol.__annotations__, **vars(protocol)} if not name.startswith("_")]


def test_every_problem_has_all_members_of_the_protocol(problem):
    v = state(problem)
    few = {"noise"} if problem.linearised(v).size <= MOST else set()
    for part, protocol in (
        (problem, Problem),
        (problem.motion(), Dynamics),
        (problem.linearised(v), Linearised),
    ):
        assert [name for name in members(protocol) if name not in few and not hasattr(part, name)] == []


def test_the_residual_is_linear_in_the_load(problem):
    v = state(problem)
    change = residual(problem, v, S + 0.3) - residual(problem, v)
    assert change == pytest.approx(0.3 * problem.direction, abs=1e-12)


def test_the_tangent_is_the_slope_of_the_residual(problem):
    """Central differences over 2e-5 nm: their error is 1e-10 of the third derivative, and 1e-16/1e-5 by round-off."""
    v = state(problem)
    w = np.random.default_rng(1).normal(size=problem.size)
    slope = (residual(problem, v + 1e-5 * w) - residual(problem, v - 1e-5 * w)) / 2e-5
    assert problem.linearised(v).tangent(w) == pytest.approx(slope, abs=1e-7 * np.abs(slope).max())


def test_the_dense_tangent_and_the_transposed_one_are_the_tangent(problem):
    v = state(problem)
    here, (w, x) = problem.linearised(v), np.random.default_rng(1).normal(size=(2, problem.size))
    largest = np.abs(here.tangent(w)).max()
    assert x @ here.tangent(w) == pytest.approx(w @ here.transposed(x), abs=1e-12 * problem.size * largest)  # round-off
    inside, inner, outer = here.acting, np.zeros_like(w), w.copy()
    inner[inside], outer[inside] = w[inside], 0.0
    # kernels come from another transform
    assert here.matrix() @ w[inside] == pytest.approx(here.tangent(inner)[inside], abs=1e-9 * largest)
    assert here.tangent(outer) == pytest.approx(-outer, abs=1e-6 * largest)


def test_slopes_are_the_change_of_the_tangent(problem):
    """Central differences over 1e-5 nm: their error is 1e-10 of the third derivative, and 1e-16/1e-5 by round-off."""
    v = state(problem)
    way, right, left = 0.1 * np.random.default_rng(1).normal(size=(3, problem.size))
    ahead, behind = (left @ problem.linearised(v + h * way).tangent(right) for h in (1e-5, -1e-5))
    slopes = problem.linearised(v).slopes(right, left)
    # `slopes` itself takes differences over 1e-3 units
    assert slopes @ way == pytest.approx((ahead - behind) / 2e-5, rel=1e-4, abs=1e-8)


def test_right_eigenvectors_are_mirrored_to_left_ones_where_the_interaction_is_symmetric(problem):
    v = state(problem)
    here = problem.linearised(v)
    if hasattr(here, "J"):
        here.J[1] = here.J[2]
    dense = np.array([here.tangent(e) for e in np.eye(problem.size)]).T
    if not hasattr(here, "J") and not np.array_equal(dense, dense.T):
        return  # a toy whose interaction has no potential
    values, vectors = np.linalg.eig(dense)
    right = vectors[:, np.abs(values.imag).argmin()].real
    left = here.mirrored(right)
    value = values[np.abs(values.imag).argmin()].real
    assert here.transposed(left) == pytest.approx(value * left, abs=1e-7 * np.abs(left).max())  # round-off of `eig`


def test_motion_starts_at_the_given_state(problem):
    v = state(problem)
    motion = problem.motion()
    y = motion.start(v, S)
    u = slice(0, 2 * getattr(problem, "nodes", problem.size))  # a top without mass is where the load wants it
    assert motion.unknowns(y)[u] == pytest.approx(v[u], abs=1e-12)


def test_motion_ends_where_the_residual_vanishes(problem):
    """The force less that of the layer vanishes on a surface in equilibrium; to first order it is that of `product`."""
    v = state(problem)
    here, motion = problem.linearised(v), problem.motion()
    x = np.random.default_rng(2).normal(size=here.size)
    y = motion.start(v, S)
    dy = np.fft.rfft(x.reshape(2, -1), axis=1) if here.size > 2 else x.reshape(-1, 1)
    dy = np.vstack([dy, np.zeros((2 - len(dy), dy.shape[1]))])

    def force(y):
        xx, zz, c = motion.stiffness
        layer = np.array([xx * y[0] - 1j * c * y[1], zz * y[1] + 1j * c * y[0]])
        return motion.force(y, S).copy() - layer

    change = (force(y + 1e-5 * dy) - force(y - 1e-5 * dy)) / 2e-5
    change = np.fft.irfft(change, here.size // 2, axis=1) if here.size > 2 else change.real[: here.size]
    expected = here.product(x)
    assert change.reshape(-1) == pytest.approx(expected, abs=1e-6 * np.abs(expected).max())


def test_response_to_a_force_solves_the_tangent(problem):
    v = state(problem)
    here = problem.linearised(v)
    matrix = np.array([here.tangent(e) for e in np.eye(problem.size)]).T
    f = np.random.default_rng(3).normal(size=here.size)
    x, layer = here.inverse(lambda b: np.linalg.solve(matrix, b), f)
    assert here.product(x) == pytest.approx(-f, abs=1e-8 * np.abs(f).max())
    rough, layer = here.inverse(lambda b: 0.9 * np.linalg.solve(matrix, b), f)
    assert here.product(rough, layer) == pytest.approx(here.product(rough), abs=1e-8 * np.abs(f).max())
    assert here.seen(f).shape == (problem.size,)


@pytest.mark.parametrize("name", ["patch", "all nodes", "flat", "held load", "lattice"])
def test_a_state_translated_by_a_period_is_an_equilibrium(name):
    problem = PROBLEMS[name]()
    period = problem.period if name == "lattice" else problem.contact.scene.spacing
    v = state(problem)
    moved = residual(problem, v + period * problem.direction, S + period)
    assert moved == pytest.approx(residual(problem, v), abs=1e-10)


def test_evaluations_are_counted(problem):
    v = state(problem)
    before = problem.evaluations
    residual(problem, v)
    here = problem.linearised(v)
    here.tangent(v)
    problem.motion().force(problem.motion().start(v, S), S)
    assert problem.evaluations - before == 3


# Steppers


PERIOD, A = 2.4, 1.0  # nm, GPa: a Prandtl-Tomlinson model whose springs are stiffer than the drive
CLOSED = 2.0 * np.pi / PERIOD * A  # GPa/nm
STEPPERS = {
    "fast": QuasiStatic,
    "gfmd": Gfmd,
    "gfmd, increments with slips halved": Halving,
    "gfmd mass-weighted": MassWeighted,
    "FIRE": Fire,
}
BEFORE, BEYOND = [-1.0, -0.4, 0.2, 0.38], 0.5  # loads of the cubic up to its fold at 0.3849, and beyond it


@pytest.fixture(params=STEPPERS)
def stepper_of(request):
    """The function (problem, closed) -> Stepper, at critical damping."""
    return lambda problem, closed: STEPPERS[request.param](problem, 1.0, closed)


def advanced(stepper, state, loads):
    """The Increments to these loads, one after the other."""
    done = []
    for load in loads:
        done.append(stepper.increment(done[-1].state if done else state, load))
    return done


def lattice():
    """A Prandtl-Tomlinson model of a tolerance that plain transients reach."""
    toy = toys.lattice((A, 0.0), period=PERIOD)
    toy.tolerance = 1e-9
    return toy


def cubic():
    """The cubic of `toys` with the same tolerance."""
    toy = toys.cubic()
    toy.tolerance = 1e-9
    return toy


def test_every_stepper_has_all_members_of_the_protocol(stepper_of):
    stepper = stepper_of(cubic(), 2.0)
    assert [name for name in members(Stepper) if not hasattr(stepper, name)] == []


def test_on_a_branch_the_state_is_the_equilibrium_at_the_target(stepper_of):
    toy = cubic()
    done = advanced(stepper_of(toy, 2.0), toy.at_rest(-2.0, -1.6), BEFORE)
    assert [d.state.load for d in done] == BEFORE and not any(d.slips for d in done)
    for d in done:
        assert d.state.residual <= toy.tolerance
        assert np.abs(residual(toy, d.state.v, d.state.load)).max() <= toy.tolerance
        # at 0.38 the fold is 0.0049 away: the slope 1 - 3 v^2 is -0.25, and magnifies the residual by 4
        assert d.state.v == pytest.approx(toy.at_rest(d.state.load, d.state.v).v, abs=10.0 * toy.tolerance)


def test_a_jump_is_a_slip_between_the_loads_of_its_increment(stepper_of):
    toy = cubic()
    stepper = stepper_of(toy, 2.0)
    before = advanced(stepper, toy.at_rest(-2.0, -1.6), BEFORE)[-1].state
    done = stepper.increment(before, BEYOND)
    (slip,) = done.slips
    assert before.load <= slip.load <= BEYOND and slip.v[0] < 0.0 < slip.after.v[0]
    assert slip.load == pytest.approx(toys.CUBIC.fold, abs=1e-8) or not slip.located
    assert done.state.load == BEYOND and done.state.v == pytest.approx(toy.at_rest(BEYOND, 1.2).v, abs=1e-8)


def test_an_increment_can_be_repeated_from_the_same_state(stepper_of):
    """Secant pairs that a first attempt leaves change where within the tolerance the second ends."""
    toy = lattice()
    stepper = stepper_of(toy, CLOSED)
    state = advanced(stepper, toy.at_rest(0.0, 0.0), np.arange(0.2, 2.0, 0.2))[-1].state
    load, v = state.load, state.v.copy()
    first, again = stepper.increment(state, 2.1), stepper.increment(state, 2.1)
    assert state.load == load and np.array_equal(state.v, v)
    assert len(first.slips) == len(again.slips) and first.state.load == again.state.load
    assert first.state.v == pytest.approx(again.state.v, abs=100.0 * toy.tolerance)


def test_all_methods_reach_the_same_states_over_four_periods(stepper_of):
    """Four periods. Steps of 0.05 nm begin a transient at most that far beyond the fold: it goes one site."""
    loads, ends = np.arange(0.05, 4.5 * PERIOD, 0.05), []
    for make in (lambda toy, closed: QuasiStatic(toy, 1.0, closed), stepper_of):
        toy = lattice()
        done = advanced(make(toy, CLOSED), toy.at_rest(0.0, 0.0), loads)
        ends.append([(len(d.slips), d.state.load, d.state.v[0]) for d in done])
        assert sum(len(d.slips) for d in done) >= 3
        for d in done:
            assert all(a.load <= b.load for a, b in zip(d.slips, d.slips[1:], strict=False))
    assert np.array(ends[1]) == pytest.approx(np.array(ends[0]), abs=1e-6)


def test_a_stepper_without_an_equilibrium_raises_not_converged(stepper_of):
    """R = s + v^2: none for s > 0."""
    toy = toys.Toy(lambda v: v + v**2, lambda v: np.diag(1.0 + 2.0 * v), tolerance=1e-9)
    with np.errstate(all="ignore"), pytest.raises(NotConverged):
        stepper_of(toy, 2.0).increment(toy.at_rest(-0.5, -0.7), 0.5)


def test_a_contact_is_advanced_with_the_problem_of_its_state(stepper_of):
    """From a patch of the punch; on the branch all methods agree to a thousand times the tolerance."""
    scene = PUNCH.changed(tolerance=1e-6)
    ends = []
    for make in (lambda problem, closed: QuasiStatic(problem, 1.0, closed), stepper_of):
        stepper = make(Equilibrium(Contact(scene, *patch(scene)), sideways(1.0, -scene.delta)), closed_stiffness(scene))
        start = State.at_rest(0.0, stepper.problem.undeformed(0.0))
        done = advanced(stepper, start, [0.1, 0.2, 0.3])[-1]
        assert done.state.v.size == stepper.problem.size and done.state.residual <= scene.tolerance
        surface = np.zeros((2, scene.nodes))
        first, size = stepper.problem.contact.first, stepper.problem.contact.size
        surface[:, first : first + size] = stepper.problem.surface(done.state.v)
        ends.append(surface)
    touched = (ends[0] != 0.0).any(axis=0) & (ends[1] != 0.0).any(axis=0)
    assert np.abs(ends[0] - ends[1])[:, touched].max() < 1e3 * scene.tolerance
