"""The equilibrium that each slip reaches, by the paper's GFMD alone; the branches of all runs are compared with it.

Nothing but the damped motion in explicit steps, from equilibrium to equilibrium. An increment with a slip is halved
until it is shorter than SHORT. The transient then begins at rest just beyond the end of the branch; the remainder of a
long increment would set it swinging. Where the reference's event is `sensitive`, the transient itself bifurcates: no
branch is right there, and none is compared.
"""

from ..continuation.gfmd import Gfmd
from ..continuation.state import Increment
from ..scene import Scene
from .compare import Curves, perform

# of the problem's unit: the increment in which a slip begins. The end of the branch is not located, and a slip of
# either method within it counts as the same
SHORT = 2e-3
STEP = 0.5  # of delta_t and delta_n: the longest increment; longer than a site, it would hide slips
FACTORS = (5, 2, 1)  # increments of the scene in one of these runs
TOLERANCE = 1e-5  # nm: branches lie compare.SAME_BRANCH apart, ten thousand times as far


class Halving(Gfmd):
    """GFMD that halves increments in which the surface slips."""

    def increment(self, state, target) -> Increment:
        """The Increment from `state` to load `target`, nm; raises NotConverged."""
        problem = self.problem
        done = super().increment(state, target)
        if not done.slips or target - state.load <= SHORT * problem.unit:
            return done
        self.problem = problem  # it may have grown
        first = self.increment(state, 0.5 * (state.load + target))
        second = self.increment(first.state, target)
        return second._replace(slips=first.slips + second.slips)


def landings(scene: Scene, longest: float) -> Curves:
    """The Curves of GFMD from rest to rest, at long increments, which `Halving` refines at slips; longest: s."""
    for name in ("du_x", "du_z"):
        own = getattr(scene, name)
        scene = scene.changed(**{name: own * next(n for n in FACTORS if n == 1 or own * n <= STEP)})
    return perform(scene.changed(tolerance=max(TOLERANCE, 2.0 * scene.attainable)), Halving, longest=longest)
