"""The skeleton of a run from its frames, without solving anything."""

from collections.abc import Sequence
from copy import copy
from dataclasses import replace
from itertools import pairwise

import numpy as np

from ..continuation.interpolation import combine
from ..run.frame import Frame
from ..run.loadpath import load_path
from ..run.summary import whole_surface
from ..scene import Scene
from .branch import Branch, Fold, NotFollowed, place, weights_near
from .skeleton import Skeleton
from .telling import TOLD, forces_between

SAME = 0.01  # delta_n or delta_t, the smaller: states closer than that are the same, others are part of a site off
LONGEST = 12  # sites, longest period that is looked for
ALIKE = 1e-4  # nm, between ends of branches that are the same
MOST = 12  # branches that are worth following
FEWEST = 3  # frames of a branch, from which its states can be interpolated
STEP = 1e-4  # of t, over which the way of a branch at its end is told
INTERVALS = (12, 16, 24, 36, 48, 72)  # between the states of a branch: as few as will do


def skeleton_of(scene: Scene) -> Skeleton:
    """The Skeleton of a scene, from a run; raises NotFollowed where it has none, NotConverged as the run does."""
    frames = []
    for frame in load_path(scene):
        frames.append(frame)
        if frame.repeated:
            break
    return replace(skeleton_from(scene, frames), evaluations=sum(frame.evaluations for frame in frames))


def skeleton_from(scene: Scene, frames: Sequence[Frame]) -> Skeleton:
    """The Skeleton of a scene from the Frames of its run, in order and from the first on; solves nothing.

    The run may stop where it begins to repeat itself. Raises NotFollowed where it has none.
    """
    if scene.path != "shear":
        raise NotFollowed(f"path {scene.path!r} is computed")
    sheared = [f for f in frames if f.stage == "shear"]
    if len(sheared) < 2:
        raise NotFollowed("the run has not slid yet")
    reader = _Reader(scene, frames)
    lines = _lines(sheared)
    home, sites, count = _period(reader, lines)
    if not sites and sheared[-1].U_x < scene.u_x_max - scene.du_x * scene.delta_t:
        raise NotFollowed("the run has not come to where it repeats itself")
    if count > MOST:
        raise NotFollowed(f"{count} branches until the run repeats itself, at most {MOST} are followed")
    lines, home = _longest(lines[:count], home, sites * scene.spacing)
    branches = [reader.branch(line, bool(sites) and not line.slips) for line in lines]
    jumps, lost = reader.jumps(frames)
    return Skeleton(scene, reader.first, tuple(branches), home, sites, jumps, lost=lost)


class _Line:
    """The frames of one branch, from load `start` to `end`, where it slips if `slips`."""

    def __init__(self, start, end, slips, frames, loads):
        self.start, self.end, self.slips, self.moved = start, end, slips, 0.0
        self.frames, self.t = frames, [self.t_of(load) for load in loads]

    def t_of(self, load):
        return float(place(self.start, self.end, load))

    def back(self, distance):
        """The same moved back by a whole number of sites, nm."""
        other = copy(self)
        other.start, other.end, other.moved = self.start - distance, self.end - distance, self.moved + distance
        return other

    def weights(self, t):
        """(frames, their weights) in the state at t."""
        near, weights = weights_near(self.t, t)
        return self.frames[near], weights


def _lines(frames, coordinate=lambda f: f.U_x):
    """The _Lines of frames in order; raises NotFollowed where a branch does not end in a fold."""
    lines, begun, start = [], [], coordinate(frames[0])
    for frame in frames:
        for event in frame.slips:
            if event.kind != "fold":
                raise NotFollowed(f"a branch ends by {event.kind} at {event.load:g} nm: that is computed")
            if len(begun) < FEWEST:
                raise NotFollowed(f"a branch that ends at {event.load:g} nm has but {len(begun)} frames")
            lines.append(_Line(start, event.load, True, begun, list(map(coordinate, begun))))
            begun, start = [], event.load
        begun.append(frame)
    if len(begun) >= 2:
        lines.append(_Line(start, coordinate(begun[-1]), False, begun, list(map(coordinate, begun))))
    return lines


def _period(reader, lines):
    """(branch to which the last one leads on, by how many sites, branches until then); sites 0 if none is known."""
    a = reader.scene.spacing
    if len(lines) == 1 and not lines[0].slips:
        line = lines[0]
        if line.start + a <= line.end and reader.same(
            line, line.start, reader.at(line, line.t_of(line.start + a))[0], a
        ):
            line.end = line.start + a
            line.t = [line.t_of(f.U_x) for f in line.frames if f.U_x <= line.end]
            line.frames = line.frames[: len(line.t)]
            return 0, 1, 1
        return 0, 0, 1
    for j, (line, after) in enumerate(pairwise(lines)):
        landed = after.frames[0]
        for sites in range(1, LONGEST + 1):
            if line.end - sites * a < lines[0].start:
                break
            load = landed.U_x - sites * a
            for home in range(j + 1):
                within = lines[home].start <= load <= lines[home].end
                if within and reader.same(lines[home], load, reader.u(landed), sites * a):
                    return home, sites, j + 1
    return 0, 0, len(lines)


def _longest(lines, home, period):
    """(lines, home), the branch before `home` left out where it is but a part of the last one, a period before."""
    if not home:
        return lines, home
    part, last = lines[home - 1], lines[-1].back(period)
    if last.start > part.start or abs(last.end - part.end) > ALIKE:
        return lines, home
    return [*lines[: home - 1], last, *lines[home:-1]], home - 1


class _Reader:
    """Frames as unknowns on one patch, that of the last frame."""

    def __init__(self, scene, frames):
        self.scene, last = scene, frames[-1]
        self.uniform = last.u.strides[1] == 0
        self.first, self.m = (0, 1) if self.uniform else (last.first, last.u.shape[1])
        self.held = scene.hold == "load"
        self._kept = {}

    def u(self, frame):
        """(2, m) nm."""
        if id(frame) not in self._kept:
            self._kept[id(frame)] = frame, np.ascontiguousarray(self._u(frame))
        return self._kept[id(frame)][1]

    def _u(self, frame):
        if self.uniform:
            return frame.u[:, :1]
        if (frame.first, frame.u.shape[1]) == (self.first, self.m):
            return frame.u
        if frame.u.shape[1] == self.scene.nodes and frame.u.strides[1] == 0:
            raise NotFollowed("nodes move alike at first, and not later")
        u = whole_surface(self.scene, frame).copy()
        u[:, frame.first : frame.first + frame.u.shape[1]] = frame.u
        return u[:, self.first : self.first + self.m]

    def at(self, line, t):
        """(u (2, m), delta) of a line at t, interpolated between its frames."""
        near, weights = line.weights(t)
        fields = [self.u(f) for f in near]
        delta = sum(weight * f.delta for weight, f in zip(weights, near, strict=True))
        u = combine(weights, fields)
        u[0] -= line.moved
        return u, delta

    def same(self, line, load, u, moved):
        """Whether u (2, m) is the state of a line at `load` moved on by so much, nm."""
        off = u - self.at(line, line.t_of(load))[0] - np.array([[moved], [0.0]])
        return bool(np.abs(off).max() <= SAME * min(self.scene.delta_n, self.scene.delta_t))

    def branch(self, line, periodic):
        """The Branch of a line, with as many states as it takes to tell what lies between."""
        for n in INTERVALS:
            branch = Branch(line.start, line.end, np.empty((n + 1, 0)), None, None, periodic)
            v = np.array([self.state(line, load) for load in branch.loads])
            branch = replace(branch, v=v)
            if self.told(line, branch):
                break
        active = np.array([self.active(u) for u in v[:, self.m : 2 * self.m]])
        return replace(branch, active=active, fold=self.fold(line, self.held) if line.slips else None)

    def state(self, line, load):
        u, delta = self.at(line, line.t_of(load))
        return self.unknowns(u, delta, self.held)

    def told(self, line, branch):
        """Whether the forces of a line, at its frames and half-way between states of a Branch, are told by these."""
        loads = np.array([f.U_x - line.moved for f in line.frames])
        between = branch.load_at((np.arange(branch.intervals) + 0.5) / branch.intervals)
        loads = np.append(loads[(loads > line.start) & (loads < line.end)], between)
        known = np.array([self.state(line, load) for load in loads])
        known, largest = forces_between(self.scene, self.first, known)
        told, _ = forces_between(self.scene, self.first, branch.states(loads, self.m))
        return bool((np.abs(told - known) <= TOLD * largest).all())

    def unknowns(self, u, delta, held):
        return np.append(u.ravel(), -delta if held else ())

    def active(self, u_z):
        return self.scene.profile[self.first : self.first + self.m] + u_z <= self.scene.window_n * self.scene.delta_n

    def fold(self, line, held):
        """The Fold at the end of a line, extrapolated."""
        u, delta = self.at(line, 1.0)
        before, after = (self.at(line, 1.0 + step) for step in (-STEP, STEP))
        bend = -0.5 * np.pi**2 * (line.end - line.start)  # of the load, by t
        way = self.unknowns(after[0] - before[0], after[1] - before[1], held) / (2.0 * STEP)
        return Fold.of(line.end, self.unknowns(u, delta, held), self.active(u[1]), way, bend)

    def jumps(self, frames):
        """(Folds of the approach, delta_bar of the last where they are not all folds, or come too close together)."""
        approach = [f for f in frames if f.stage == "approach"]
        events = [event for f in approach for event in f.slips]
        if not events:
            return (), -np.inf
        try:
            lines = _lines(approach, lambda f: f.delta)
        except NotFollowed:
            return (), events[-1].load / self.scene.delta_0
        return tuple(self.fold(line, False) for line in lines if line.slips), -np.inf
