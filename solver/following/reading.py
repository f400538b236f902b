"""The skeleton of a run from its frames, without solving anything."""

from dataclasses import replace
from itertools import pairwise

import numpy as np

from ..continuation.interpolation import combine
from ..run.loadpath import load_path
from ..run.summary import whole_surface
from .branch import Branch, Fold, NotFollowed, place, weights_near
from .skeleton import Skeleton

SAME = 0.01  # delta_n or delta_t, the smaller: states closer than that are the same, others are part of a site off
LONGEST = 12  # sites, longest period that is looked for
MOST = 12  # branches that are worth following
FEWEST = 3  # frames of a branch, from which its states can be interpolated
STEP = 1e-4  # of t, over which the way of a branch at its end is told
INTERVALS = (12, 18, 24, 36, 48, 72)  # between the states of a branch: as few as will do
TOLD = 2e-4  # of the largest force


def skeleton_of(scene):
    """The Skeleton of a scene, from a run; raises NotFollowed where it has none, NotConverged as the run does."""
    frames = []
    for frame in load_path(scene):
        frames.append(frame)
        if frame.repeated:
            break
    return skeleton_from(scene, frames)


def skeleton_from(scene, frames):
    """The Skeleton of a scene from the Frames of its run, in order and from the first on; solves nothing.

    The run may stop where it begins to repeat itself. Raises NotFollowed where it has none.
    """
    if scene.path != "shear":
        raise NotFollowed(f"path {scene.path!r} is computed")
    sheared = [f for f in frames if f.stage == "shear"]
    if not sheared:
        raise NotFollowed("the run has not slid yet")
    reader = _Reader(scene, frames)
    lines = _lines(scene, sheared)
    home, sites, count = _period(reader, lines)
    if not sites and sheared[-1].U_x < scene.u_x_max - scene.du_x * scene.delta_t:
        raise NotFollowed("the run has not come to where it repeats itself")
    if count > MOST:
        raise NotFollowed(f"{count} branches until the run repeats itself, at most {MOST} are followed")
    read = [reader.branch(line, bool(sites) and not line.slips) for line in lines[:count]]
    branches, tractions = ([one[part] for one in read] for part in (0, 1))
    return Skeleton(scene, reader.first, tuple(branches), tuple(tractions), home, sites, reader.jumps(frames))


class _Line:
    """The frames of one branch, from load `start` to `end`, where it slips if `slips`."""

    def __init__(self, start, end, slips, frames, loads):
        self.start, self.end, self.slips = start, end, slips
        self.frames, self.t = frames, [self.t_of(load) for load in loads]

    def t_of(self, load):
        return float(place(self.start, self.end, load))

    def weights(self, t):
        """(frames, their weights) in the state at t."""
        near, weights = weights_near(self.t, t)
        return self.frames[near], weights


def _lines(scene, frames, coordinate=lambda f: f.U_x):
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
        if line.start + a <= line.end and reader.same(line, line.start, line.frames[0], line.start + a, line, a):
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
                if within and reader.same(lines[home], load, landed, None, None, sites * a):
                    return home, sites, j + 1
    return 0, 0, len(lines)


class _Reader:
    """Frames as unknowns on one patch, that of the last frame."""

    def __init__(self, scene, frames):
        self.scene, last = scene, frames[-1]
        self.uniform = last.u.strides[1] == 0
        self.first, self.m = (0, 1) if self.uniform else (last.first, last.u.shape[1])
        self.held = scene.hold == "load"
        self._kept = {}
        sums = [self.fields(f)[1].sum(axis=1) for f in frames if f.stage == "shear"]
        self.largest = np.abs(sums).max(axis=0)

    def fields(self, frame):
        """(u, T), each (2, m)."""
        if id(frame) not in self._kept:
            self._kept[id(frame)] = frame, *self._fields(frame)
        return self._kept[id(frame)][1:]

    def _fields(self, frame):
        if self.uniform:
            return frame.u[:, :1], frame.T[:, :1]
        if (frame.first, frame.u.shape[1]) == (self.first, self.m):
            return frame.u, frame.T
        if frame.u.shape[1] == self.scene.nodes and frame.u.strides[1] == 0:
            raise NotFollowed("nodes move alike at first, and not later")
        first, m = frame.first, frame.u.shape[1]
        u, T = whole_surface(self.scene, frame).copy(), np.zeros((2, self.scene.nodes))
        u[:, first : first + m], T[:, first : first + m] = frame.u, frame.T
        part = slice(self.first, self.first + self.m)
        return u[:, part], T[:, part]

    def at(self, line, t):
        """(u, T, delta) of a line at t, interpolated between its frames."""
        near, weights = line.weights(t)
        fields = [self.fields(f) for f in near]
        delta = sum(weight * f.delta for weight, f in zip(weights, near, strict=True))
        return *(combine(weights, [np.ascontiguousarray(f[part]) for f in fields]) for part in (0, 1)), delta

    def same(self, line, load, frame, other_load, other, moved):
        """Whether a frame, or the state of the line `other`, is the state of a line at `load` moved on."""
        u = self.at(line, line.t_of(load))[0]
        there = self.fields(frame)[0] if other is None else self.at(other, other.t_of(other_load))[0]
        off = there - u - np.array([[moved], [0.0]])
        return bool(np.abs(off).max() <= SAME * min(self.scene.delta_n, self.scene.delta_t))

    def branch(self, line, periodic):
        """(Branch, T (n + 1, 2, m)) of a line, with as many states as it takes to tell its frames."""
        for n in INTERVALS:
            blank = Branch(line.start, line.end, np.empty((n + 1, 0)), None, None, periodic)
            states = [self.at(line, line.t_of(load)) for load in blank.loads]
            T = np.array([T for _, T, _ in states])
            if self.told(line, blank, T):
                break
        v = np.array([self.unknowns(u, delta, self.held) for u, _, delta in states])
        active = np.array([self.active(u) for u, _, _ in states])
        fold = self.fold(line, self.held) if line.slips else None
        return replace(blank, v=v, active=active, fold=fold), T

    def told(self, line, branch, T):
        """Whether the forces at all frames of a line are told by tractions T of the states of a Branch."""
        sums = np.array([self.fields(f)[1].sum(axis=1) for f in line.frames])
        off = np.abs(branch.weights(np.array([f.U_x for f in line.frames])) @ T.sum(axis=2) - sums)
        return bool((off.max(axis=0) <= TOLD * self.largest).all())

    def unknowns(self, u, delta, held):
        return np.append(u.ravel(), -delta if held else ())

    def active(self, u):
        gap = (np.zeros(1) if self.uniform else self.scene.profile[self.first : self.first + self.m]) + u[1]
        return gap <= self.scene.window_n * self.scene.delta_n

    def fold(self, line, held):
        """The Fold at the end of a line, extrapolated."""
        u, _, delta = self.at(line, 1.0)
        before, after = (self.at(line, 1.0 + step) for step in (-STEP, STEP))
        bend = -0.5 * np.pi**2 * (line.end - line.start)  # of the load, by t
        way = self.unknowns(after[0] - before[0], after[2] - before[2], held) / (2.0 * STEP)
        return Fold.of(line.end, self.unknowns(u, delta, held), self.active(u), way, bend)

    def jumps(self, frames):
        """The Folds of the approach."""
        approach = [f for f in frames if f.stage == "approach"]
        if not any(f.slips for f in approach):
            return ()
        lines = _lines(self.scene, approach, lambda f: f.delta)
        return tuple(self.fold(line, False) for line in lines if line.slips)
