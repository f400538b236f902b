"""What carries a run that slides: its branches until they repeat, and from them the run at any load."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..run.frame import Frame, SlipEvent, contact_area, forces, on_nodes
from ..scene import Scene
from .branch import Branch

EDGE = 1e-3  # phi_n/delta_n; twice what a node at the edge of the window bears


@dataclass(frozen=True)
class Skeleton:
    """The shear of a scene. Branches in order; the last one leads on to branch `home`, moved on by so many sites.

    sites: 0 where that is not known; the branches then reach to u_x_max. Unknowns are those of a patch whose first node
    is `first`. jumps: Folds of the approach, loads delta (nm). Treat it as read-only.
    """

    scene: Scene
    first: int
    branches: tuple[Branch, ...]
    tractions: tuple[np.ndarray, ...]  # T (n + 1, 2, m) of the states of each branch, GPa
    home: int = 0
    sites: int = 0
    jumps: tuple = ()
    evaluations: int = 0  # force evaluations spent in getting it
    contact: "Skeleton | None" = None  # without contact: that in contact which comes back beyond the jump-in

    @property
    def period(self):
        """After which everything repeats, nm, or None where that is not known."""
        return self.sites * self.scene.spacing if self.sites else None

    @property
    def jumps_in(self):
        """delta_bar at which the surfaces jump into contact on approach, or None."""
        return self.jumps[0].load / self.scene.delta_0 if self.jumps else None

    @property
    def nodes(self):
        """Of the patch."""
        return self.tractions[0].shape[2]

    @cached_property
    def slips(self):
        """The SlipEvents of the shear up to u_x_max."""
        events, last = [], self.scene.u_x_max
        for k, (branch, T) in enumerate(zip(self.branches, self.tractions, strict=True)):
            if branch.fold is None:
                continue
            values = *map(float, forces(self.scene, self._on_nodes(T[-1]))), self._area(T[-1])
            load = float(branch.end)
            while load <= last:
                events.append(SlipEvent(load, *values, "shear", "fold", True))
                if not self.sites or k < self.home:
                    break
                load += self.period
        return tuple(sorted(events, key=lambda event: event.load))

    def curve(self, U_x):
        """(F_bar, L_bar, A_bar), arrays, at loads U_x (k,) nm."""
        out = np.empty((3, np.size(U_x)))
        for k, mine, weights, _ in self._places(U_x):
            T = self.tractions[k]
            scale = 1.0 / (self.scene.nodes * self.scene.E) * (self.scene.nodes if self._uniform else 1)
            sums = T.sum(axis=2) * scale
            out[0, mine], out[1, mine] = -(weights @ sums[:, 0]), weights @ sums[:, 1]
            fields = (weights @ T.reshape(len(T), -1)).reshape(-1, *T.shape[1:])
            out[2, mine] = [self._area(field) for field in fields]
        return tuple(out)

    def frames(self, U_x):
        """The Frames at loads U_x (k,) nm, with no slips in them and `residual` nan, as none was evaluated."""
        frames = [None] * np.size(U_x)
        for k, mine, weights, shift in self._places(U_x):
            loads = np.atleast_1d(U_x)[mine]
            branch, tractions = self.branches[k], self.tractions[k]
            states = weights @ (branch.v - branch.loads[:, None] * self._along)
            states += (loads - shift)[:, None] * self._along
            fields = (weights @ tractions.reshape(len(tractions), -1)).reshape(-1, *tractions.shape[1:])
            for i, load, v, T, moved in zip(np.flatnonzero(mine), loads, states, fields, shift, strict=True):
                frames[i] = self._frame(float(load), v, T, moved)
        return frames

    def _frame(self, U_x, v, T, moved):
        scene, m = self.scene, self.nodes
        u = v[: 2 * m].reshape(2, m).copy()
        u[0] += moved
        u, T = self._on_nodes(u), self._on_nodes(T)
        delta = scene.delta if v.size == 2 * m else -float(v[-1])
        index = round(U_x / (scene.du_x * scene.delta_t))
        first, numbers = 0 if self._uniform else self.first, (*forces(scene, T), self._area(T[:, : self.nodes]))
        return Frame("shear", index, U_x, delta, first, u, T, *numbers, residual=np.nan, evaluations=0)

    @cached_property
    def _along(self):
        """How the unknowns move with the load where they slide steadily."""
        along = np.zeros(self.branches[0].v.shape[1])
        along[: self.nodes] = 1.0
        return along

    @property
    def _uniform(self):
        return self.nodes == 1

    def _area(self, T):
        """A_bar of interpolated tractions; where nodes come and go at the window's edge they are not quite zero."""
        T = T.copy()
        T[1, np.abs(T[1]) < EDGE * self.scene.phi_n / self.scene.delta_n] = 0.0
        return contact_area(self.scene, self._on_nodes(T))

    def _on_nodes(self, field):
        return on_nodes(self.scene, field) if self._uniform else field

    def _places(self, U_x):
        """(branch's number, which of the loads lie on it, weights of its states there, nm they are moved on by)."""
        U_x = np.atleast_1d(np.asarray(U_x, float))
        ends = np.array([branch.end for branch in self.branches])
        shift = np.maximum(0.0, np.ceil((U_x - ends[-1]) / self.period)) * self.period if self.sites else 0.0 * U_x
        place = np.minimum(np.searchsorted(ends, U_x - shift), ends.size - 1)
        for k, branch in enumerate(self.branches):
            mine = place == k
            if mine.any():
                yield k, mine, branch.weights((U_x - shift)[mine]), shift[mine]
