"""Continuation, motion and replay on problems of one and two unknowns with known answers."""

from math import inf
from types import SimpleNamespace
from weakref import ref

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from toys import CUBIC, Node, Toy, cubic, lattice, spiral

from solver import Scene
from solver.continuation.branch import continue_branch
from solver.continuation.corrector import Corrector
from solver.continuation.fold import FoldOptions, fold_near
from solver.continuation.gfmd import Gfmd
from solver.continuation.inverse import Solves
from solver.continuation.motion import Creep, ExplicitMotion, Motion
from solver.continuation.quasistatic import QuasiStatic
from solver.continuation.replay import advanced
from solver.continuation.rest import Judge
from solver.continuation.state import End, NotConverged, Point, State
from solver.continuation.trace import FEWEST_STATES, STATES, Branch, Trace, lagrange
from solver.run.loadpath import Run

A, PERIOD = 1.0, 2.4
Q = 2.0 * np.pi / PERIOD


def followed(stepper, state, targets):
    """The Increments to those loads, one after the other."""
    done = []
    for target in targets:
        if target > state.load:
            done.append(stepper.increment(state, target))
            state = done[-1].state
    return done


def replayed(stepper, state, targets, trace=None, spacing=PERIOD):
    """(the Increments to those loads, the Trace at their end), with known states moved on by sites."""
    done, trace = [], trace or Trace.of(state)
    for target in targets:
        if target > state.load:
            increment, trace = advanced(stepper, state, target, trace, spacing)
            done.append(increment)
            state = increment.state
    return done, trace


def slips_of(increments):
    return [slip for done in increments for slip in done.slips]


# A fold


@pytest.mark.parametrize("damping", [0.3, 1.0, inf])
@pytest.mark.parametrize("du", [0.01, 0.1, 0.37, 1.0, 2.5])
def test_a_fold_is_located_to_1e_9_whatever_the_increment(du, damping):
    """2.5: the whole branch in one increment. The load at a fold is as sharp as the square of an error in v."""
    toy = cubic()
    stepper = QuasiStatic(toy, damping, 2.0)
    done = followed(stepper, toy.at_rest(-2.0, -1.6), np.append(np.arange(-2.0 + du, 0.5, du), 0.5))
    (slip,) = slips_of(done)
    assert slip.load == pytest.approx(CUBIC.fold, abs=1e-9)
    assert slip.v[0] == pytest.approx(CUBIC.at, abs=1e-4)
    assert slip.kind == "fold" and slip.located
    # the rest after it, at the same load: the other root
    assert slip.after.load == slip.load and slip.after.v[0] == pytest.approx(CUBIC.rest, abs=1e-8)
    assert done[-1].state.load == pytest.approx(0.5, abs=1e-12)
    assert done[-1].state.v[0] == pytest.approx(toy.at_rest(0.5, 1.2).v[0], abs=1e-11)


@pytest.mark.parametrize("start", [0.3, 0.36, 0.38, 0.3848])
@pytest.mark.parametrize("before", [1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9])
def test_states_up_to_a_fold_are_those_of_the_stable_branch(start, before):
    """The last target lies at most 1e-4 before the fold, where the branches are at most 0.015 apart."""
    toy = cubic()
    targets = [*np.arange(-1.9, start - 0.01, 0.1), start, CUBIC.fold - before]
    done = followed(QuasiStatic(toy, 1.0, 2.0), toy.at_rest(-2.0, -1.6), targets)
    assert not slips_of(done) and [d.state.load for d in done] == targets
    for d in done:
        v = d.state.v[0]
        assert abs(d.state.load + v - v**3) <= toy.tolerance and 1.0 - 3.0 * v * v < 0.0
        assert d.state.residual <= toy.tolerance


def test_a_branch_that_does_not_end_is_followed_without_slips():
    """Half the force: 1 - v^2 + ..., one root for every load, however steep."""
    toy = Toy(lambda v: 0.99 * np.sin(v), lambda v: np.diag(0.99 * np.cos(v)))
    done = followed(QuasiStatic(toy, 1.0, 1.0), toy.at_rest(-3.0, -3.0), np.arange(-2.9, 3.05, 0.1))
    assert not slips_of(done)
    for d in done:
        exact = brentq(lambda v, s=d.state.load: s + 0.99 * np.sin(v) - v, -5.0, 5.0, xtol=1e-15)
        assert d.state.v[0] == pytest.approx(exact, abs=1e-9)


# Prandtl-Tomlinson


def tomlinson_fold(A=A):
    """(u, load) at the first fold of T = -A sin(q u), k = 1."""
    u = np.arccos(-1.0 / (A * Q)) / Q
    return u, u + A * np.sin(Q * u)


def first_rest(load, u, A=A):
    """The next root of load - u - A sin(q u) beyond u."""
    grid = np.linspace(u + 1e-3, u + 2 * PERIOD, 4001)
    f = load - grid - A * np.sin(Q * grid)
    i = int(np.argmax((f[:-1] > 0.0) & (f[1:] <= 0.0)))
    return brentq(lambda x: load - x - A * np.sin(Q * x), grid[i], grid[i + 1], xtol=1e-14)


@pytest.mark.parametrize("du", [0.05, 0.3, 1.0])
def test_overdamped_tomlinson_model_slips_at_its_fold_to_the_next_equilibrium(du):
    u, fold = tomlinson_fold()
    toy = lattice((A, 0.0), period=PERIOD)
    slips = slips_of(followed(QuasiStatic(toy, inf, A * Q), toy.at_rest(0.0, 0.0), np.arange(du, 10.0, du)))
    assert [slip.load for slip in slips] == pytest.approx(fold + PERIOD * np.arange(len(slips)), abs=1e-9)
    assert len(slips) == int((np.arange(du, 10.0, du)[-1] - fold) / PERIOD) + 1
    for k, slip in enumerate(slips):
        assert slip.after.v[0] == pytest.approx(first_rest(fold, u) + k * PERIOD, abs=1e-8)


def test_slips_of_one_increment_are_each_located():
    """After a slip there is no second state to extrapolate from; here five follow on the way to one load."""
    _, fold = tomlinson_fold()
    toy = lattice((A, 0.0), period=PERIOD)
    stepper = QuasiStatic(toy, inf, A * Q)
    done = stepper.increment(toy.at_rest(0.0, 0.0), fold + 4.5 * PERIOD)
    assert [slip.load for slip in done.slips] == pytest.approx(fold + PERIOD * np.arange(5), abs=1e-9)
    assert all(slip.located and slip.kind == "fold" for slip in done.slips)


def test_a_fold_is_found_from_a_state_that_lies_on_it_to_the_tolerance():
    """The load of that state may be above the fold's by its error, and the branch falls in every direction."""
    toy = cubic().solved_to(1e-8)
    past = [Point(CUBIC.fold + 5e-9, np.array([CUBIC.at + 1e-6]))]
    past += [Point(float(v**3 - v), np.array([v])) for v in (CUBIC.at - 0.1, CUBIC.at - 0.2)]
    state = State(*past[0], past)
    corrector = Corrector(toy)
    state = state._replace(secants=corrector.secants())
    end = continue_branch(corrector, Judge(1.0), state, CUBIC.fold + 0.1)
    assert end.kind == "fold" and end.load == pytest.approx(CUBIC.fold, abs=1e-8)


@pytest.mark.parametrize("chord", [None, np.ones(1)], ids=["load", "arc"])
def test_a_residual_that_is_no_number_is_not_a_solution(chord):
    """The interaction is not a number beyond v = 0.5; a solve that begins or comes there fails."""
    toy = Toy(lambda v: np.where(v > 0.5, np.nan, 0.0), lambda v: np.zeros((1, 1)))
    for start, load in ((0.6, 0.6), (0.4, 2.0)):
        corrector = Corrector(toy)
        assert corrector.solve(np.array([start]), load, corrector.secants(), chord, 2.0) is None


def test_a_motion_is_freed_without_the_garbage_collector():
    toy = cubic()
    motion = Motion(toy.motion(), toy.motion().start(np.zeros(1), 0.0), 0.0, 1.0, 1.0)
    motion.soften(1.0)
    alive = ref(motion)
    del motion
    assert alive() is None


def test_a_fold_is_located_from_a_state_without_history_just_before_it():
    """1e-3 and 1e-6 before the fold, where v moves 20 and 700 times faster than the load."""
    u, fold = tomlinson_fold()
    toy = lattice((A, 0.0), period=PERIOD)
    for before in (1e-2, 1e-3, 1e-6):
        state = toy.at_rest(fold - before, u - (2.0 * before / (A * Q * Q * np.sin(Q * u))) ** 0.5)
        assert state.v[0] < u and len(state.past) == 1
        (slip,) = QuasiStatic(toy, inf, A * Q).increment(state, fold + 0.1).slips
        assert slip.located and slip.load == pytest.approx(fold, abs=1e-9)


@pytest.mark.once(4)
@pytest.mark.parametrize("A", [1.0, 3.0])
@pytest.mark.parametrize("damping", [0.3, 1.0, 0.05, 0.1, 4.0])
def test_inertia_carries_as_far_as_an_integrated_equation_of_motion(damping, A):
    """u'' = s - u + T(u) - gamma u' from the fold, by a Runge-Kutta scheme at 1e-10: the same well, to 1e-8."""
    u, fold = tomlinson_fold(A)
    toy = lattice((A, 0.0), period=PERIOD)
    stepper = QuasiStatic(toy, damping, A * Q)
    (slip, *_) = slips_of(followed(stepper, toy.at_rest(0.0, 0.0), np.arange(0.1, fold + 0.1, 0.1)))

    def motion(t, y):
        return [y[1], slip.load - y[0] - A * np.sin(Q * y[0]) - 2.0 * damping * y[1]]

    end = solve_ivp(motion, (0.0, 60.0 / min(damping, 1.0 / damping)), [u + 0.05, 0.0], rtol=1e-10, atol=1e-12).y[0, -1]
    assert slip.after.v[0] == pytest.approx(end, abs=1e-7)


def test_infinite_damping_is_the_limit_of_large_damping_in_the_motion():
    """At 1e3 over critical the well is that of the overdamped limit, which knows no velocity."""
    toy = lattice((3.0, 0.0), period=PERIOD)
    rests = []
    for damping in (30.0, inf):
        slips = slips_of(followed(QuasiStatic(toy, damping, 3.0 * Q), toy.at_rest(0.0, 0.0), np.arange(0.1, 6.0, 0.1)))
        rests.append([slip.after.v[0] for slip in slips])
    assert rests[0] == pytest.approx(rests[1], abs=1e-8) and len(rests[0]) >= 1


# One contract


class Bare:
    """A stepper with the members of the contract, and no other."""

    def __init__(self, stepper):
        self.problem, self.increment = stepper.problem, stepper.increment


def test_replay_needs_no_more_of_a_stepper_than_the_contract():
    toy = lattice((A, 0.0), period=PERIOD)
    done, _ = replayed(Bare(QuasiStatic(toy, inf, A * Q)), toy.at_rest(0.0, 0.0), np.arange(0.1, 9.0, 0.1))
    assert any(increment.repeated for increment in done)


@pytest.mark.parametrize("damping", [0.2, 1.0, 4.0, inf])
def test_every_stepper_reaches_the_same_states(damping):
    """The motion at every increment, branches and motion, and what repeats moved on."""
    toys = [lattice((A, 0.0), period=PERIOD, k=1.0) for _ in range(3)]
    for toy in toys:
        toy.tolerance = 1e-10
    targets = np.arange(0.1, 9.0, 0.1)
    runs = [
        followed(Gfmd(toys[0], damping, A * Q), toys[0].at_rest(0.0, 0.0), targets),
        followed(QuasiStatic(toys[1], damping, A * Q), toys[1].at_rest(0.0, 0.0), targets),
        replayed(QuasiStatic(toys[2], damping, A * Q), toys[2].at_rest(0.0, 0.0), targets)[0],
    ]
    states = np.array([[done.state.v[0] for done in run] for run in runs])
    assert states[1] == pytest.approx(states[0], abs=1e-8)
    assert states[2] == pytest.approx(states[0], abs=1e-8)
    slipped = [[bool(done.slips) for done in run] for run in runs]
    assert slipped[0] == slipped[1] == slipped[2] and sum(slipped[0]) >= 2
    for run in runs:
        assert max(done.state.residual for done in run) <= 1e-10
        assert [done.state.load for done in run] == list(targets)


def test_an_increment_does_not_depend_on_which_stepper_object_computes_it():
    """A step is state in, state out."""
    toy = lattice((A, 0.0), period=PERIOD)
    one = followed(QuasiStatic(toy, 1.0, A * Q), toy.at_rest(0.0, 0.0), np.arange(0.1, 9.0, 0.1))
    state, many = toy.at_rest(0.0, 0.0), []
    for target in np.arange(0.1, 9.0, 0.1):
        many.append(QuasiStatic(lattice((A, 0.0), period=PERIOD), 1.0, A * Q).increment(state, target))
        state = many[-1].state
    assert [done.state.v[0] for done in one] == [done.state.v[0] for done in many]


# Flutter


FLUTTER = {"growth": 0.8, "reach": 3.0, "turn": 0.8}  # no fold, one equilibrium at every load


def flutter_loads(damping):
    """The loads between which the only equilibrium of `spiral` flutters: lambda^2 + gamma lambda = a +- i b."""
    toy, gamma2 = spiral(**FLUTTER), 4.0 * damping**2

    def excess(r):
        return toy.real(r) if damping == inf else toy.imaginary2(r) + gamma2 * toy.real(r)

    grid = np.linspace(0.05, 3.0, 2000)
    signs = np.sign([excess(r) for r in grid])
    ends = [brentq(excess, grid[i], grid[i + 1], xtol=1e-14) for i in np.flatnonzero(np.diff(signs))]
    return [float(toy.load(r)) for r in ends]


@pytest.mark.once(3)
@pytest.mark.parametrize("damping", [0.6, 1.0, inf])
@pytest.mark.parametrize("du", [0.11, 0.02])
def test_flutter_ends_a_branch_where_a_pair_of_modes_starts_to_grow_under_the_motion(du, damping):
    first, _ = flutter_loads(damping)
    toy = spiral(**FLUTTER)
    done = followed(QuasiStatic(toy, damping, 2.0), toy.at_rest(0.0, np.zeros(2)), np.arange(du, first + du, du))
    (slip,) = slips_of(done)
    assert slip.kind == "flutter" and slip.located
    assert slip.load == pytest.approx(first, abs=1e-6)


def test_less_damping_lets_a_branch_flutter_earlier():
    """What the test above rests on: the loads are apart by more than it tells."""
    loads = [flutter_loads(damping)[0] for damping in (0.6, 1.0, inf)]
    assert np.diff(loads).min() > 0.02


@pytest.mark.parametrize("damping", [1.0, inf])
def test_load_increases_until_an_equilibrium_exists(damping):
    """Between the two loads the only equilibrium flutters: the motion comes to rest beyond the second."""
    first, second = flutter_loads(damping)
    toy = spiral(**FLUTTER)
    done = followed(QuasiStatic(toy, damping, 2.0), toy.at_rest(0.0, np.zeros(2)), np.arange(0.05, second + 1.0, 0.05))
    loads = [d.state.load for d in done]
    assert not [s for s in loads if first < s < second]
    assert min(s for s in loads if s > first) < second + 0.3
    for d in done:
        assert toy.load(np.linalg.norm(d.state.v)) == pytest.approx(d.state.load, abs=1e-10)
    (slip,) = slips_of(done)
    assert slip.after.load >= second


# Motion


def oscillator(k=1.7):
    """A node that feels nothing but its spring."""
    return Node(Toy(np.zeros_like, lambda v: np.zeros((v.size, v.size)), k=k))


def linear_decay(t, omega2, gamma, x0):
    """x of x'' = -omega2 x - gamma x' from rest at x0."""
    root = np.sqrt(complex(gamma**2 / 4.0 - omega2))
    fast, slow = -gamma / 2.0 - root, -gamma / 2.0 + root
    return (x0 * (slow * np.exp(fast * t) - fast * np.exp(slow * t)) / (slow - fast)).real


@pytest.mark.parametrize("kind", [Motion, ExplicitMotion])
@pytest.mark.parametrize("damping", [0.1, 0.7, 2.5])
def test_a_node_on_its_spring_moves_as_the_linear_oscillator(damping, kind):
    """Below and above critical; the error over a swing falls with the square of the step."""
    k, off = 1.7, []
    for closed in (40.0, 4000.0):
        node = oscillator(k)
        motion = kind(node, np.array([[1.0], [0.3]], complex), 0.0, damping, closed)
        motion.soften(0.0)
        times, places = [], []
        for n in range(1, int(6.0 / motion.step)):
            motion.advance(1)
            times.append(n * motion.step)
            places.append(motion.y[:, 0].real.copy())
        exact = linear_decay(np.array(times), k, 2.0 * damping * k**0.5, 1.0)
        off.append(np.abs(np.array(places) - exact[:, None] * [1.0, 0.3]).max())
    assert off[0] < 0.03
    assert off[1] < off[0] / 50.0


def test_a_fast_mode_follows_quasistatically_and_hardly_changes_a_slow_one():
    """With a step beyond the fast mode's bound of stability. Where masses are needed, all modes get step^2 sigma/4."""

    class Two(Node):
        """Two directions of different stiffness, nothing else."""

        def __init__(self, stiff):
            super().__init__(Toy(np.zeros_like, lambda v: np.zeros((v.size, v.size)), k=1.0))
            self.stiffness = np.array([[1.0], [stiff], [0.0]])

    for stiff in (1.0, 1e7):
        motion = Motion(Two(stiff), np.array([[1.0], [1.0]], complex), 0.0, 0.5, 40_000.0)
        motion.soften(0.0)
        motion.advance(round(8.0 / motion.step))
        slow, fast = motion.y[:, 0].real
        mass = 1.0 + (stiff > 1.0) * motion.step**2 / 4.0 * 40_000.0
        assert slow == pytest.approx(linear_decay(8.0 / mass**0.5, 1.0, 1.0, 1.0), abs=1e-3)
    assert mass < 1.07
    assert motion.step * 1e7**0.5 > 2.0  # beyond what explicit steps bear
    assert abs(fast) < 0.3  # friction over the root of its mass: exp(-2) or so; a whole first step would start it at -3


def test_creep_decays_exponentially_and_in_proportion_to_stiffness():
    """gamma u' = -k u at one mobility for all: decay rates of two modes are in the ratio of their stiffness."""

    class Two(Node):
        def __init__(self):
            super().__init__(Toy(np.zeros_like, lambda v: np.zeros((v.size, v.size)), k=1.0))
            self.stiffness = np.array([[1.0], [2.5], [0.0]])

    motion, places = Creep(Two(), np.array([[1.0], [1.0]], complex), 0.0, inf, 1000.0), []
    motion.soften(1000.0)
    for _ in range(40):
        motion.advance(200)
        places.append(np.log(np.abs(motion.y[:, 0])))
    rates = np.diff(np.array(places), axis=0)
    assert np.ptp(rates, axis=0).max() < 1e-9 * np.abs(rates).max()
    # a step of 1/4000 of the time in which springs close: first order
    assert rates[0, 1] / rates[0, 0] == pytest.approx(2.5, rel=2e-3)
    # in its own time, an implicit step delays by the stiffness that it counts on
    sigma = 0.25 / motion.step
    assert rates[0, 0] == pytest.approx(-200.0 * motion.step / (1.0 + sigma * motion.step), rel=2e-3)


def test_creep_reaches_equilibrium_without_overshoot():
    """Overdamped: towards the next rest of a lattice, never back."""
    _, fold = tomlinson_fold(3.0)
    toy = lattice((3.0, 0.0), period=PERIOD)
    motion = Creep(toy.motion(), np.array([[tomlinson_fold(3.0)[0] + 0.05], [0.0]], complex), fold, inf, 3.0 * Q)
    places = []
    for _ in range(4000):
        motion.soften(toy.motion().interface(motion.y[:1, 0].real))
        motion.advance(1)
        places.append(motion.y[0, 0].real)
    assert np.diff(places).min() > -1e-12
    assert places[-1] == pytest.approx(first_rest(fold, tomlinson_fold(3.0)[0], 3.0), abs=1e-6)


def test_the_load_may_change_while_something_moves():
    """The spring pulls to another place from then on."""
    motion = Motion(oscillator(), np.zeros((2, 1), complex), 0.0, 1.0, 40.0)
    motion.soften(0.0)
    motion.advance(50)
    assert np.abs(motion.y).max() == 0.0
    motion.load = 2.0
    motion.advance(4000)
    assert motion.y[0, 0] == pytest.approx(2.0, abs=1e-9) and abs(motion.y[1, 0]) < 1e-12


# Anderson


class Linear(Toy):
    """R = s d + b - M v, with M = 1 + a compact part, not symmetric."""

    def __init__(self, size=12):
        rng = np.random.default_rng(3)
        self.M = np.eye(size) + rng.normal(size=(size, size)) * 0.5 ** np.arange(size) / size**0.5
        self.b = rng.normal(size=size)
        super().__init__(None, None, size=size, tolerance=1e-11)
        self.unit = 100.0  # no step is long

    def residual(self, v, s, out):
        self.evaluations += 1
        out[:] = s * self.direction + self.b - self.M @ v
        return float(np.abs(out).max())

    def linearised(self, v):
        return SimpleNamespace(tangent=lambda w: -self.M @ w, matrix=lambda: -self.M)


def test_anderson_steps_solve_a_linear_problem_in_as_many_steps_as_it_has_unknowns():
    problem = Linear()
    corrector = Corrector(problem)
    solution = corrector.solve(np.zeros(problem.size), 0.0, corrector.secants())
    assert solution.v == pytest.approx(np.linalg.solve(problem.M, problem.b), abs=1e-10)
    assert problem.evaluations - 1 <= problem.size + 2  # steps; in exact arithmetic one more than unknowns


def test_secant_pairs_kept_from_one_load_serve_at_the_next():
    problem = Linear()
    corrector = Corrector(problem)
    secants = corrector.secants()
    first = corrector.solve(np.zeros(problem.size), 0.0, secants)
    problem.evaluations = 0
    second = corrector.solve(first.v, 1.0, secants)
    assert problem.evaluations - 1 <= 4 < problem.size
    expected = np.linalg.solve(problem.M, problem.b + problem.direction)
    assert second.v == pytest.approx(expected, abs=1e-10)


def test_steps_with_an_inverse_converge_where_anderson_steps_do_not():
    """100 unlike eigenvalues: more than 20 secant pairs can tell apart in 60 steps."""
    problem = Linear(100)
    problem.M, problem.tolerance = np.diag(np.linspace(1.0, 1000.0, 100)), 1e-7
    corrector = Corrector(problem)
    assert corrector.sharp is None
    solution = corrector.solve(np.zeros(problem.size), 0.0, corrector.secants())
    assert corrector.sharp is not None
    assert solution.v == pytest.approx(np.linalg.solve(problem.M, problem.b), abs=1e-6)


def test_no_solution_is_reported_where_none_exists():
    """R = s - 1 - v^2 has no root below s = 1."""
    toy = Toy(lambda v: v - 1.0 - v**2, lambda v: np.diag(1.0 - 2.0 * v))
    corrector = Corrector(toy)
    assert corrector.solve(np.array([0.3]), 0.5, corrector.secants()) is None
    assert corrector.solve(np.array([0.3]), 1.25, corrector.secants())


def test_arc_length_steps_solve_for_the_load_beyond_a_fold():
    """On the unstable branch of the cubic, v = -0.3 belongs to the load v^3 - v."""
    toy = cubic()
    corrector = Corrector(toy)
    v, load, _ = corrector.solve(np.array([-0.35]), 0.3, corrector.secants(), np.array([1.0]), -0.3)
    assert v[0] == pytest.approx(-0.3, abs=1e-11) and load == pytest.approx(-(0.3**3) + 0.3, abs=1e-11)


# Replay


def exact_path(toy, loads, period, sweep=400):
    """v of the overdamped model at increasing loads, each from the rest before, by the next root of its force."""
    v, places = 0.0, []
    for load in loads:

        def force(x, load=load):
            return load - x + toy.T(np.array([x]))[0]

        step = period / sweep
        x = v - step
        while force(x) < 0.0:
            x -= step
        while force(x + step) > 0.0:
            x += step
        v = brentq(force, x, x + step, xtol=1e-14)
        places.append(v)
    return np.array(places)


@pytest.mark.parametrize("waves", [((1.0, 0.0),), ((0.6, 0.0), (0.8, 0.4))])
def test_translated_known_states_are_exact(waves):
    """One well per period, and two wells of different depth: two slips per period, at two folds."""
    toy = lattice(*waves, period=PERIOD)
    loads = np.arange(1, 301) * 0.05
    start = toy.at_rest(0.0, exact_path(toy, [0.0], PERIOD))
    done, _ = replayed(QuasiStatic(toy, inf, 4.0), start, loads)
    assert [d.state.v[0] for d in done] == pytest.approx(exact_path(toy, loads, PERIOD), abs=1e-9)
    assert sum(d.repeated for d in done) > 0.5 * len(done)
    assert max(d.state.residual for d in done) <= toy.tolerance
    slips = np.array([slip.load for slip in slips_of(done)])
    per_period = len(waves)
    assert len(slips) >= 4 * per_period
    assert slips[per_period:] - slips[:-per_period] == pytest.approx(PERIOD, abs=1e-9)
    if per_period == 2:
        assert not np.allclose(np.diff(slips), PERIOD / 2.0, atol=0.05)
    assert all(slip.located for slip in slips_of(done))


def test_repeated_states_cost_one_evaluation_each():
    toy = lattice((0.6, 0.0), (0.8, 0.4), period=PERIOD)
    stepper, state, spent = QuasiStatic(toy, inf, 4.0), toy.at_rest(0.0, exact_path(toy, [0.0], 1.0)), []
    trace = Trace.of(state)
    for load in np.arange(1, 401) * PERIOD / 24:  # commensurate: no state in between is asked for
        before = toy.evaluations
        done, trace = advanced(stepper, state, load, trace, PERIOD)
        state = done.state
        if done.repeated:
            spent.append(toy.evaluations - before)
    assert len(spent) > 300 and np.median(spent) == 1


def aperiodic(amplitude):
    """A force that grows by 2 % a period, so that no state is repeated."""

    def T(u):
        return -amplitude * (1.0 + 0.02 * u / PERIOD) * np.sin(Q * u)

    def J(u):
        return np.diag(-amplitude * ((1.0 + 0.02 * u / PERIOD) * Q * np.cos(Q * u) + 0.02 / PERIOD * np.sin(Q * u)))

    return Toy(T, J)


def test_states_of_an_aperiodic_lattice_are_not_replayed():
    """Every state is verified, so that none is merely moved on."""
    toy = aperiodic(1.0)
    loads = np.arange(1, 200) * 0.1
    done, _ = replayed(QuasiStatic(toy, inf, 4.0), toy.at_rest(0.0, 0.0), loads)
    assert [d.state.v[0] for d in done] == pytest.approx(exact_path(toy, loads, PERIOD), abs=1e-9)
    loads = [slip.load for slip in slips_of(done)]
    assert len(loads) >= 6
    exact = [max(x + (1.0 + 0.02 * x / PERIOD) * np.sin(Q * x) for x in np.arange(u, u + 0.8, 1e-5))
             for u in 0.6 + PERIOD * np.arange(len(loads))]  # fmt: skip
    assert loads == pytest.approx(exact, abs=1e-8)


def test_replay_does_not_change_the_trace_of_an_earlier_state():
    """Going on twice from the same state gives the same twice."""
    toy = lattice((1.0, 0.0), period=PERIOD)
    stepper = QuasiStatic(toy, inf, 4.0)
    done, trace = replayed(stepper, toy.at_rest(0.0, 0.0), np.arange(1, 100) * 0.1)
    first, again = (
        [d.state.v[0] for d in replayed(stepper, done[-1].state, [10.03, 10.7], trace)[0]] for _ in range(2)
    )
    assert first == pytest.approx(again, abs=1e-12)


def test_smooth_sliding_is_repeated_after_one_period():
    """Its own curvature below 1: no slip, v is a function of the load."""
    toy = lattice((0.3, 0.0), period=PERIOD)
    loads = np.arange(1, 200) * 0.1
    done, trace = replayed(QuasiStatic(toy, inf, 4.0), toy.at_rest(0.0, 0.0), loads)
    assert [d.state.v[0] for d in done] == pytest.approx(exact_path(toy, loads, PERIOD), abs=1e-9)
    assert trace.period == PERIOD and all(d.repeated for d in done if d.state.load > PERIOD + 0.05)


def test_smooth_sliding_in_long_increments_is_repeated_once_its_states_are_many():
    """Five states over a period do not describe what lies between them; each increment adds one."""
    toy, loads = lattice((0.3, 0.0), period=PERIOD), np.arange(1, 40) * 0.5
    done, trace = replayed(QuasiStatic(toy, inf, 4.0), toy.at_rest(0.0, 0.0), loads)
    assert trace.period == PERIOD and not any(d.repeated for d in done[:FEWEST_STATES])
    assert any(d.repeated for d in done)
    assert [d.state.v[0] for d in done] == pytest.approx(exact_path(toy, loads, PERIOD), abs=1e-9)


@pytest.mark.once(2)
@pytest.mark.parametrize(("amplitude", "slips", "step"), [(0.05, False, 1e-3), (1.0, True, 1e-3), (1.0, True, 0.05)])
def test_the_memory_of_5000_increments_is_bounded(amplitude, slips, step):
    """Without slips, with few and with many; what is left of the newest branch describes it."""
    toy, loads = aperiodic(amplitude), np.arange(1, 5001) * step
    done, trace = replayed(QuasiStatic(toy, inf, 4.0), toy.at_rest(0.0, 0.0), loads, spacing=1000.0)
    assert not trace.period and bool(slips_of(done)) == slips
    assert 0.5 * STATES < sum(len(branch.states) for branch in trace.branches) <= STATES
    newest = trace.branches[-1]
    there = [d.state for d in done if newest.start < d.state.load < newest.end]
    assert len(there) > len(newest.states)
    off = [abs(newest.at(state.load).v[0] - state.v[0]) for state in there]
    assert max(off) < 1e-3 * toy.unit  # thinned states are interpolated from those left


# Failure


def test_a_motion_without_an_equilibrium_raises_an_error():
    """A force that turns and grows without bound: no rest anywhere."""
    turned = np.array([[1.5, -3.0], [3.0, 1.5]])
    toy = Toy(lambda u: turned @ u, lambda u: turned, size=2)
    state = toy.at_rest(0.5, np.zeros(2))._replace(unsure=True)
    with pytest.raises(NotConverged, match=r"diverges|does not come to rest|still moving"):
        QuasiStatic(toy, 1.0, 3.0).increment(state, 0.6)


def test_an_unstable_start_leaves_its_saddle_along_the_unstable_mode():
    """The cubic at s = 0, v = 0: an equilibrium, and none of the motion's rests."""
    toy = cubic()
    state = toy.at_rest(0.0, 0.0)._replace(unsure=True)
    done = QuasiStatic(toy, 1.0, 2.0).increment(state, 0.05)
    assert abs(done.state.v[0]) > 0.9
    assert abs(0.05 + done.state.v[0] - done.state.v[0] ** 3) < 1e-11


def test_a_state_close_to_the_end_of_a_branch_is_replaced_by_that_end():
    """Two states at one load have no interpolation between them."""
    states = [Point(load, np.array([load**2])) for load in (0.0, 0.2, 0.4, 0.6, 0.8, 1.0 - 2e-7)]
    branch = Branch((states[0],))
    for state in states[1:]:
        branch = branch.added(state)
    branch = branch.ended(End(1.0, np.ones(1)))
    assert [state.load for state in branch.states] == [0.0, 0.2, 0.4, 0.6, 0.8, 1.0]
    # quadratic in the load is of the fourth degree in the root of the distance to the end
    assert branch.at(0.99).v[0] == pytest.approx(0.99**2, abs=1e-12)


def test_a_trace_is_not_changed_by_extending_it():
    branch = Branch((Point(0.0, np.zeros(1)),))
    longer = branch.added(Point(1.0, np.ones(1)))
    assert len(branch.states) == 1 and len(longer.states) == 2
    assert longer.added(Point(1.0 + 1e-7, np.ones(1))) is longer


# folds


def fold_guess(problem, load, v, way):
    return End(load, np.array(v, float), np.array(way, float))


def test_a_fold_is_found_from_a_state_off_it():
    """s = v^3 - v has its maximum 2/(3 sqrt 3) at v = -1/sqrt 3."""
    toy = cubic()
    fold = fold_near(toy, fold_guess(toy, 0.2, [-0.9], [1.0]))
    assert fold.load == pytest.approx(CUBIC.fold, abs=1e-9)  # the default sharpness
    assert fold.v[0] == pytest.approx(CUBIC.at, abs=1e-4)  # its square is the error of the load
    assert fold.residual <= toy.tolerance


def test_a_fold_of_an_interaction_without_potential_has_both_null_vectors():
    toy = spiral(growth=1.5, turn=0.3)
    r = np.linspace(0.4, 0.6, 200_001)  # its first fold is at 0.54
    top = np.argmax([toy.load(x) for x in r])
    at = toy.at_rest(toy.load(r[top] - 0.05), [0.4, 0.2])
    way = toy.at_rest(at.load + 1e-3, at.v).v - at.v
    fold = fold_near(toy, fold_guess(toy, at.load, at.v, way), FoldOptions(accuracy=1e-9, state=1e-9, alike=1e-9))
    assert fold.load == pytest.approx(toy.load(r[top]), abs=1e-9)
    assert np.hypot(*fold.v) == pytest.approx(r[top], abs=1e-5)  # between values of r
    A = toy.linearised(fold.v).matrix()
    assert np.abs(A @ fold.phi).max() < 1e-8 and np.abs(A.T @ fold.psi).max() < 1e-8
    assert fold.psi @ toy.direction == pytest.approx(1.0)


def test_no_fold_is_found_where_there_is_none():
    toy = lattice((0.3, 0.0))  # 2 pi A/period < 1: it slides smoothly
    assert fold_near(toy, fold_guess(toy, 1.0, [0.8], [1.0])) is None


@pytest.mark.filterwarnings("error")
def test_a_fold_search_on_a_straight_branch_ends_without_a_warning():
    """At v = 0 the curvature of s = v^3 - v vanishes, so that Newton's step divides by zero."""
    assert fold_near(cubic(), fold_guess(cubic(), 0.0, [0.0], [1.0])) is None


def test_a_minimum_of_the_load_is_no_fold():
    assert fold_near(cubic(), fold_guess(cubic(), -0.3, [0.6], [1.0])) is None


def test_a_fold_is_left_unchanged_by_the_search():
    toy = cubic()
    guess = fold_guess(toy, 0.2, [-0.9], [1.0])
    before = guess.v.copy(), guess.phi.copy()
    fold_near(toy, guess)
    assert np.array_equal(guess.v, before[0]) and np.array_equal(guess.phi, before[1])


def test_dense_solves_replace_iterations_that_do_not_converge():
    toy = spiral()
    v = np.array([1.0, 0.3])
    solves = Solves(toy.linearised(v), accuracy=1e-12, most=1)
    matrix, f = toy.linearised(v).matrix(), np.array([1.0, 2.0])
    assert matrix @ solves(f) == pytest.approx(f, abs=1e-12)
    assert matrix.T @ solves(f, transposed=True) == pytest.approx(f, abs=1e-12)


@pytest.mark.parametrize("transposed", [False, True])
@pytest.mark.parametrize("bordered", [False, True])
@pytest.mark.parametrize("hold", ["delta", "load"])
def test_dense_solves_leave_out_what_does_not_act(hold, bordered, transposed):
    """Nodes far from the contact follow from the others: the solution is that of all unknowns, found by iterations."""
    scene = Scene(nodes=128, width=320.0, radius=1.0, delta_bar=0.2, u_x_max=1.0, hold=hold)
    run = Run(scene)
    *_, (_, checkpoint) = run.frames()
    here = run.stepper.problem.linearised(checkpoint.state.v)
    column, row, f = np.random.default_rng(1).normal(size=(3, here.problem.size))
    border = (column, row) if bordered else (None, None)
    f = np.append(f, 1.0) if bordered else f
    assert 10 < here.acting.size < 0.9 * here.problem.size
    direct, iterated = (Solves(here, *border, accuracy=1e-9, most=most)(f, transposed) for most in (1, 2000))
    assert direct == pytest.approx(iterated, abs=1e-7 * np.abs(iterated).max())


@pytest.mark.parametrize("kind", [list, tuple, np.array])
def test_weights_at_any_sequence_of_nodes_reproduce_a_polynomial(kind):
    nodes = kind([0.0, 0.3, 1.0, 1.7])
    values = [2.0 - node + 3.0 * node**3 for node in nodes]
    assert np.dot(lagrange(nodes, 2.0), values) == pytest.approx(24.0, rel=1e-13)  # some roundings


def test_the_weight_of_a_single_node_is_a_float():
    """A whole number would make an array of weights that cannot be scaled in place."""
    assert np.array(lagrange(np.array([0.5]), 2.0)).dtype == float


def test_weights_at_nodes_that_coincide_are_not_finite_and_raise_nothing():
    assert not np.isfinite(lagrange([0.0, 0.0, 1.0], 0.5)).all()
