"""The fast method: secant steps on a stable branch, the overdamped flow where the branch ends.

On a branch, an increment starts from the extrapolation of those before and takes a few accelerated fixed-point steps
(`secants`). Where that fails or the state would move far, the branch is followed by its arc length instead (`fold`), to
the load asked for or to the load's maximum: the end of the branch, where a slip begins. `flow` carries it through, and
where a large part of a soft layer jumps into contact, `closing`.
"""

from functools import lru_cache

import numpy as np

from .closing import QUIET, Closing, closed_stiffness, closed_up
from .flow import STEP_ERROR, Flow
from .fold import Fold, follow
from .growth import growth_rate
from .held import contact_of
from .interpolation import combine, lagrange
from .layer import Modes
from .left_out import ALL, mirrored
from .record import SAME, Record
from .secants import Secants, advance
from .state import Increment, NotConverged, Slip, State

MEMORY = 30  # secant pairs
ORDER = 3  # of the extrapolation in the load
MOST_STEPS = 60  # of a load increment on a branch, before the branch is followed by arc length
LONGEST_STEP = 0.15  # of min(delta_n, delta_t): bound of one secant step
FARTHEST = 0.5  # of min(delta_n, delta_t): a larger change in one increment is followed by arc length
NUDGE = 1e-3  # of min(delta_n, delta_t), off a saddle
LANDED = 0.02  # of the slip's peak speed: below it the flow has entered a new basin, and secant steps may finish
MOST_LANDING_STEPS = 150
SUSPECT = 11  # secant steps after which a state may lie beyond the fold of its branch
UNSTABLE = 1e-6  # growth rate, per unit of time, above which an equilibrium is a saddle
STIFF = 50.0  # interface stiffness times the patch's largest compliance, from which on residuals are smoothed
BUDGET, WORK = 1_500_000, 1.5e9  # force evaluations of one increment, and times nodes
FAR = 100.0  # of min(delta_n, delta_t): a slip that has moved a node that far goes on by `closing`,
PATIENCE, PATIENT_WORK = 30_000, 1e8  # and so does one that has taken as many evaluations, or times nodes,
STIFFEST = 5e3  # or whose fastest mode decays that much faster than a free surface moves, as on a soft layer
CIRCLING = 1000  # steps of `closing` without another node in the window, after which the flow takes over again
SETTLED = 0.1  # of min(delta_n, delta_t): residual at which secant steps may finish such a slip


class Fast:
    """Advances States of one scene on one patch; holds no state between calls but buffers."""

    def __init__(self, scene, first, size, leave_out=ALL, pressure=None):
        """pressure: the mean normal traction to hold, GPa; None: the top moves as the Loading says."""
        normal_only = scene.phi_ratio == 0.0 and "friction" in leave_out
        self.scene, self.contact = scene, contact_of(scene, first, size, pressure, leave_out, normal_only)
        self._mirror = "mirror" in leave_out and mirrored(self.contact.profile)
        self.unit = min(scene.delta_n, scene.delta_t)
        self.tolerance = scene.tolerance
        self.smooth = None  # what secant steps do to the unknown part of the residual
        self.steps = 0  # secant steps of the last solution
        self.worst = np.inf  # nm, residual of the last evaluation
        self.budget = int(min(BUDGET, WORK / size))
        self._r = np.empty((2, self.contact.size))
        longest_wave = Modes.of(scene).compliance[1, min(max(1, round(scene.nodes / size)), scene.nodes // 2)]
        self._stiff = STIFF / float(longest_wave)
        self._smoother = lru_cache(maxsize=8)(self._new_smoother)
        self._soft = closed_stiffness(scene).max() * Modes.of(scene).compliance[:2].max() > STIFFEST

    def _choose_smoother(self, state):
        """Damp the long waves that a stiff interface pins: without it they take most of the secant steps."""
        stiffness = self.contact.stiffness(state.u, state.active)
        self.smooth = self._smoother(int(np.ceil(np.log2(0.5 * stiffness)))) if stiffness > self._stiff else None

    def _new_smoother(self, power):
        """r -> (I + sigma C)^-1 r on the patch, for sigma = 2^power GPa/nm."""
        shifted = self.contact.shifted(2.0**power)

        def smooth(r):
            shifted.field[:] = r.reshape(shifted.field.shape)
            shifted.apply()
            return shifted.product.reshape(-1)

        return smooth

    def undeformed(self, loading, load):
        """The State of a layer that nothing acts on."""
        u = self.contact.undeformed(loading.at(load))
        return State(load, u, self.contact.within_window(u), [(load, u)], Secants(MEMORY, u.size))

    def increment(self, state, loading, target):
        """The equilibrium at load `target` that is reached from `state`; raises NotConverged."""
        state.secants = state.secants or Secants(MEMORY, state.u.size)
        self.contact.mirror = self._mirror and loading.upright and mirrored(state.u[1], 1e-12)
        repeated = self._repeat(state, loading, target)
        if repeated is not None:
            return repeated
        self._choose_smoother(state)
        slips, limit = [], self.contact.evaluations + self.budget
        while True:
            found = self._on_branch(state, loading, target) or follow(self, state, loading, target)
            if isinstance(found, Fold):
                before, state = state, self._through(found, loading, limit)
                if self.contact.crowded(state.active):
                    return Increment(state, self.contact.traction(), self.worst)  # of no use but to be widened
                slips += self._slips(before, found, state)
                if found.load < target:
                    continue
                found = state  # the flow was needed at the target itself
            if found.record is not None:
                found.record.add(target, found.u, found.active, found.sites * self.scene.spacing)
            return Increment(found, self.contact.traction(), self.worst, tuple(slips))

    def _repeat(self, state, loading, target):
        """The increment to `target` from the record of a sliding run; None if it tells nothing."""
        record, spacing, slips = state.record, self.scene.spacing, []
        if record is None or not record.sites:
            return None
        sites = state.sites
        while target - sites * spacing > record.fold.load:
            slips.append(record.slip(sites * spacing))
            sites += record.sites
        u, active = record.state_at(target, sites * spacing)
        guess, before = u.copy(), self.contact.evaluations
        active = self.settle(u, active, loading.at(target), state.secants, MOST_STEPS)
        if active is None or np.abs(u - guess).max() > SAME * self.unit:
            state.record = None  # from here on everything is solved for
            return None
        if self.contact.evaluations > before + 1:  # not accurate enough as interpolated: now it is known better
            record.add(target, u, active, sites * spacing)
        past = [(target, u)] if slips else [(target, u), *state.past[: ORDER + 1]]
        moved = State(target, u, active, past, state.secants, record, sites)
        return Increment(moved, self.contact.traction(), self.worst, tuple(slips), True)

    def _on_branch(self, state, loading, target):
        """The state at `target` on the same branch by secant steps, or None if that is not to be had safely."""
        past = state.past[: ORDER + 1]
        u = combine(lagrange([load for load, _ in past], target), [u for _, u in past])
        if np.abs(u - state.u).max() > FARTHEST * self.unit:
            return None
        most = MOST_STEPS if len(state.past) > 1 else MOST_LANDING_STEPS
        active = self.settle(u, self.contact.admitted(u, state.active), loading.at(target), state.secants, most)
        if active is None or np.abs(u - state.u).max() > FARTHEST * self.unit:
            return None
        if (state.doubtful or (self.steps > SUSPECT and self._speeds_up(state, target, u))) and not self.stable(
            u, active, loading.at(target)
        ):
            return None  # beyond the fold of its branch, on the unstable side
        return self.reached(state, target, u, active)

    def _speeds_up(self, state, target, u):
        """Whether u moved farther per unit of load than in the increment before, as towards the end of a branch."""
        if len(state.past) < 2:
            return True
        (load1, u1), (load0, u0) = state.past[:2]
        before = np.abs(u1 - u0).max() / (load1 - load0)
        return np.abs(u - state.u).max() > 1.05 * before * (target - state.load)

    def stable(self, u, active, load):
        """Whether the equilibrium u is stable; leaves its residual and traction as the last evaluation."""
        growth = growth_rate(self.contact, u, active)
        self.worst = self.contact.residual(u, active, load, self._r)
        return growth <= UNSTABLE

    def reached(self, state, load, u, active):
        """The state at `load` on the branch of `state`."""
        older = [p for p in state.past if p[0] != load]
        return State(load, u, active, [(load, u), *older[: ORDER + 1]], state.secants, state.record, state.sites)

    def settle(self, u, active, load, secants, most):
        """Solve for u, in place, with the set of active nodes it implies; that set, or None."""
        return self.contact.settle(lambda chosen: self.solve(u, chosen, load, secants, most), u, active)

    def solve(self, u, active, load, secants, most, longest=LONGEST_STEP):
        """Secant steps on u, in place, at fixed load; True if the residual came below the tolerance."""
        r, bound = self._r, longest * self.unit
        self.worst = worst = self.contact.residual(u, active, load, r)
        first, steps = worst, 0
        while worst > self.tolerance:
            if steps == most or not worst < 1e3 * max(first, bound):
                return False
            u_before, r_before = u.copy(), r.copy()
            advance(u.ravel(), secants.move(r.ravel(), self.smooth), bound)
            self.worst = worst = self.contact.residual(u, active, load, r)
            secants.push(u.ravel(), r.ravel(), u_before.ravel(), r_before.ravel())
            steps += 1
        self.steps = steps
        return True

    def _slips(self, before, fold, landed):
        """[the Slip] between the State before and the one landed in, or [] if it was none; hands on the record."""
        moved = np.abs(landed.u - before.u).max()
        if not fold.certain and moved < FARTHEST * self.unit + 2.0 * abs(fold.load - before.load):
            landed.record, landed.sites = before.record, before.sites
            return []
        slip = Slip(fold.load, fold.u, fold.traction)
        if before.record is not None:
            if before.record.close(slip, landed, self.scene.spacing, self.unit):
                landed.record, landed.sites = before.record, before.record.sites
            else:
                landed.record = Record([fold.load], [(landed.u, landed.active)], direction=before.record.direction)
        return [slip]

    def _through(self, fold, loading, limit):
        """The state that the overdamped flow from the fold of a branch reaches, at the fold's load.

        Or, where the patch is too narrow, one that is not at rest and shows it (`Contact.crowded`).
        """
        way = Flow(self.contact, fold.beyond, loading.at(fold.load), STEP_ERROR * self.unit)
        patience = self.contact.evaluations + min(PATIENCE, PATIENT_WORK / self.contact.size)
        landed, found = 1.0, None
        while found is None:
            while self._moving(way, landed):
                way.advance()
                self._check_budget(way, loading, fold.load, limit)
                if isinstance(way, Flow) and self._far(way, fold, patience):
                    way = self._closing(way)
                elif isinstance(way, Closing) and way.idle > CIRCLING:
                    way, patience, landed = Flow(self.contact, way.u, way.load, STEP_ERROR * self.unit), None, 1.0
                if self.contact.crowded(way.active):
                    return State(fold.load, way.u, way.active)
            found = self._land(way, loading, fold.load)
            if found is None and way.residual <= self.tolerance:  # at rest on a saddle, as symmetry can hold it
                self.contact.mirror = False
                if isinstance(way, Closing):  # the law has no potential, so the flow may leave where this stays
                    way, patience = Flow(self.contact, way.u, way.load, STEP_ERROR * self.unit), None
                way.nudge(NUDGE * self.unit)
                self._check_budget(way, loading, fold.load, limit)
            landed *= 0.2
            if found is None and isinstance(way, Closing):
                way.advance()
        return found

    def _moving(self, way, landed):
        """Whether a slip is still faster than secant steps may finish; landed: 1 at first, the less the later."""
        if isinstance(way, Flow):
            return way.speed > max(landed * LANDED * way.peak, self.tolerance)
        if way.quiet % QUIET == QUIET - 1:  # slow to settle
            return False
        return way.residual > max(landed * SETTLED * self.unit, self.tolerance)

    def _far(self, flow, fold, patience):
        """Whether this slip is none that the flow can follow to its end; patience: None if it must."""
        if patience is None or self.contact.held:  # `closing` knows of no top that moves
            return False
        if (self._soft and flow.radius > STIFFEST) or self.contact.evaluations > patience:
            return True
        return np.abs(flow.u - fold.u).max() > FAR * self.unit

    def _closing(self, flow):
        """What goes on where the flow is too stiff, from where coarser surfaces have got."""
        u = closed_up(self.contact, flow.u, flow.load, self.unit)
        way = Closing(self.contact, flow.u if u is None else u, flow.load)
        if u is None:
            way.active[:] = True  # too narrow
        self._choose_smoother(way)
        return way

    def _check_budget(self, way, loading, load, limit):
        if self.contact.evaluations > limit:
            raise NotConverged(
                f"Not converged at {loading.name} = {load:.6g} nm: residual {way.residual:.2g} nm after {self.budget}"
                " force evaluations of the slip; try fewer nodes, a larger tolerance, or a smaller du_x or du_z"
            )

    def _land(self, way, loading, load):
        """Secant steps from where a slip has nearly come to rest; None if they fail or lead away."""
        secants = Secants(MEMORY, way.u.size)
        u = way.u.copy()
        active = self.settle(u, way.active, loading.at(load), secants, MOST_LANDING_STEPS)
        if active is None or np.abs(u - way.u).max() > FARTHEST * self.unit:
            return None
        if not self.stable(u, active, loading.at(load)):  # secant steps are drawn to the saddle that the flow passes
            return None
        return State(load, u, active, [(load, u)], secants)
