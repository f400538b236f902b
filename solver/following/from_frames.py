"""The skeleton of a run from its frames: these give guesses, its states are solved for, and the run must follow."""

from collections.abc import Sequence
from copy import copy
from dataclasses import replace
from itertools import pairwise

import numpy as np

from ..continuation.fold import Fold
from ..continuation.interpolation import lagrange
from ..run.frame import Frame
from ..run.loadpath import load_path
from ..run.summary import whole_surface
from ..scene import Scene
from ..threads import one_thread
from .branch import Branch, NotFollowed, place
from .follow import moved
from .refinement import ERROR, forces_of
from .skeleton import Held, Skeleton

SAME = 0.01  # delta_n or delta_t, the smaller: states closer than that are the same, others are part of a site off
LONGEST = 12  # sites, longest period that is looked for
ALIKE = 1e-4  # nm, between ends of branches that are the same
MOST = 12  # branches that are worth following
STENCIL = 6  # frames through which a state between them is interpolated: a jerk farther off does not spoil it
STEP = 1e-4  # of t, for the way of a branch at its end: the square of it is its error
FEWEST = 3  # frames of a branch, from which its states can be interpolated
INTERVALS = (12, 16, 24, 36, 48, 72)  # between the states of a branch: as few as will do
OFF = 1e-3  # of the largest force, by which a skeleton may be off its run's frames: what followed runs promise
MINOR = 0.1  # of the larger force, to which a smaller one is compared: one may be held at nearly nothing
CLEAR = 1e-4  # nm from a slip: nearer, one of the two has slipped and the other has not; and the promise for its load


def skeleton_of(scene: Scene) -> Skeleton:
    """The Skeleton of a scene, from a run; raises NotFollowed where it has none, NotConverged as the run does."""
    frames = []
    for frame in load_path(scene):
        frames.append(frame)
        if frame.repeated:
            break
    skeleton = skeleton_from(scene, frames)
    return replace(skeleton, evaluations=skeleton.evaluations + sum(frame.evaluations for frame in frames))


@one_thread()
def skeleton_from(scene: Scene, frames: Sequence[Frame]) -> Skeleton:
    """The Skeleton of a scene from the Frames of its run, in order and from the first on.

    Its states are solved for, which takes a small part of the run's evaluations. The run may stop where it begins to
    repeat itself. Raises NotFollowed where it has no skeleton, or its skeleton does not describe it.
    """
    if scene.path != "shear":
        raise NotFollowed(f"path {scene.path!r} is computed")
    sheared = [f for f in frames if f.stage == "shear"]
    if len(sheared) < 2:
        raise NotFollowed("the run has not slid yet")
    spent = [0]
    skeleton = moved(_guess(scene, frames, sheared), scene, spent)
    _compare(skeleton, sheared)
    return replace(skeleton, evaluations=spent[0])


def _guess(scene, frames, sheared):
    """The Skeleton as interpolated from the frames, not solved for."""
    reader = _Reader(scene, frames)
    begin = replace(sheared[0], slips=tuple(event for event in sheared[0].slips if event.kind != "control"))
    lines = _lines([begin, *sheared[1:]], reader)
    home, sites, count = _period(scene, lines)
    if not sites and sheared[-1].U_x < scene.u_x_max - scene.du_x * scene.delta_t:
        raise NotFollowed("the run has not come to where it repeats itself")
    if count > MOST:
        raise NotFollowed(f"{count} branches until the run repeats itself, at most {MOST} are followed")
    lines, home = _longest(lines[:count], home, sites * scene.spacing)
    branches = tuple(reader.branch(line, bool(sites) and not line.slips) for line in lines)
    approach = [f for f in frames if f.stage == "approach"]
    held = reader.held(approach[-1]) if scene.hold == "load" else None
    jumps = reader.jumps(approach)
    return Skeleton(scene, reader.first, branches, home, sites, jumps or (), jumps is None, held=held)


def _compare(skeleton, sheared):
    """Raises NotFollowed where a Skeleton is not its run."""
    last = sheared[-1].U_x
    events = [event.load for frame in sheared for event in frame.slips if event.stage == "shear"]
    slips = [event.load for event in skeleton.slips if event.load <= last + CLEAR]
    if len(slips) != len(events) or np.abs(np.subtract(slips, events)).max(initial=0.0) > CLEAR:
        raise NotFollowed("the skeleton's slips are not those of its run")
    ends = np.array([*events, np.inf])
    clear = [frame for frame in sheared if np.abs(frame.U_x - ends).min() > CLEAR]
    exact = np.array([[frame.F_bar, frame.L_bar] for frame in clear])
    curve = np.array(skeleton.curve(np.array([frame.U_x for frame in clear]))[:2]).T
    largest = np.abs(exact).max(axis=0)
    largest = np.maximum(largest, MINOR * largest.max())
    if not (np.abs(curve - exact) <= OFF * np.maximum(largest, 1e-300)).all():
        raise NotFollowed("the skeleton's forces are not those of its run")


class _Line:
    """The frames of one branch, from load `start` to `end`, where it slips if `slips`: loads (k,), states v (k, size).

    moved: nm by which these were moved back, `nodes` unknowns of them.
    """

    def __init__(self, start, end, slips, loads, v, nodes):
        self.start, self.end, self.slips, self.loads, self.v = start, end, slips, np.array(loads), np.array(v)
        self.nodes = nodes

    def back(self, distance):
        """The same moved back by a whole number of sites, nm."""
        other = copy(self)
        other.start, other.end, other.loads = self.start - distance, self.end - distance, self.loads - distance
        other.v = self.v.copy()
        other.v[:, : self.nodes] -= distance
        return other

    def until(self, end):
        """The part up to load `end`, nm."""
        within = self.loads <= end
        return _Line(self.start, end, self.slips, self.loads[within], self.v[within], self.nodes)

    def at(self, load):
        """v (size,) at a load, nm, interpolated through the frames nearest to it."""
        return self._at(float(place(self.start, self.end, load)))

    def _at(self, t):
        places = place(self.start, self.end, self.loads)
        low = max(0, min(int(np.searchsorted(places, t)) - STENCIL // 2, len(places) - STENCIL))
        near = slice(low, low + STENCIL)
        return np.asarray(lagrange(places[near], t)) @ self.v[near]

    def end_way(self):
        """(v, its derivative by t) (size,) at the end, extrapolated."""
        return self._at(1.0), (self._at(1.0 + STEP) - self._at(1.0 - STEP)) / (2.0 * STEP)


def _lines(frames, reader, coordinate=lambda f: f.U_x, held=None):
    """The _Lines of frames in order; raises NotFollowed where a branch does not end in a fold."""
    lines, begun, start = [], [], coordinate(frames[0])

    def line(end, slips):
        v = [reader.unknowns(frame, held) for frame in begun]
        return _Line(start, end, slips, [coordinate(frame) for frame in begun], v, reader.m)

    for frame in frames:
        for event in frame.slips:
            if event.kind != "fold":
                raise NotFollowed(f"a branch ends by {event.kind} at {event.load:g} nm: that is computed")
            if len(begun) < FEWEST:
                raise NotFollowed(f"a branch that ends at {event.load:g} nm has but {len(begun)} frames")
            lines.append(line(event.load, True))
            begun, start = [], event.load
        begun.append(frame)
    if len(begun) >= 2:
        lines.append(line(coordinate(begun[-1]), False))
    return lines


def _period(scene, lines):
    """(branch to which the last one leads on, by how many sites, branches until then); sites 0 if none is known."""
    a, unit = scene.spacing, min(scene.delta_n, scene.delta_t)

    def same(line, load, v, moved):
        off = v - line.at(load)
        off[: line.nodes] -= moved
        return bool(np.abs(off).max() <= SAME * unit)

    if len(lines) == 1 and not lines[0].slips:
        line = lines[0]
        if line.start + a <= line.end and same(line, line.start, line.at(line.start + a), a):
            lines[0] = line.until(line.start + a)
            return 0, 1, 1
        return 0, 0, 1
    for j, (line, after) in enumerate(pairwise(lines)):
        for sites in range(1, LONGEST + 1):
            load = after.loads[0] - sites * a
            if line.end - sites * a < lines[0].start:
                break
            for home in range(j + 1):
                within = lines[home].start <= load <= lines[home].end
                if within and same(lines[home], load, after.v[0], sites * a):
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

    def unknowns(self, frame, held=None):
        """v (size,), with the height of the top where a load is held."""
        held = self.scene.hold == "load" if held is None else held
        return np.append(self._u(frame).ravel(), [-frame.delta] if held else [])

    def _u(self, frame):
        """(2, m) nm."""
        if self.uniform:
            return frame.u[:, :1]
        if (frame.first, frame.u.shape[1]) == (self.first, self.m):
            return frame.u
        if frame.u.shape[1] == self.scene.nodes and frame.u.strides[1] == 0:
            raise NotFollowed("nodes move alike at first, and not later")
        u = whole_surface(self.scene, frame).copy()
        u[:, frame.first : frame.first + frame.u.shape[1]] = frame.u
        return u[:, self.first : self.first + self.m]

    def branch(self, line, periodic):
        """The Branch of a _Line: of smooth sliding its frames, else as few states as describe these."""
        if periodic:
            return self._period_of(line)
        for n in INTERVALS:
            branch = Branch(line.start, line.end, np.empty((n + 1, 0)), None)
            branch = replace(branch, v=np.array([line.at(load) for load in branch.loads]))
            between = branch.load_at((np.arange(n) + 0.5) / n)
            loads = np.append(line.loads[(line.loads > line.start) & (line.loads < line.end)], between)
            exact, largest = forces_of(self.scene, self.first, np.array([line.at(load) for load in loads]))
            states = forces_of(self.scene, self.first, branch.states(loads, self.m))[0]
            if (np.abs(states - exact) <= ERROR * largest).all():
                break
        return replace(branch, active=self._active(branch.v), fold=self._fold(line) if line.slips else None)

    def _period_of(self, line):
        """The Branch of a _Line of one period of smooth sliding, which may jerk between any two frames."""
        period = line.end - line.start
        loads, last = np.append(line.loads[line.loads < line.end], line.end), line.v[:1].copy()
        last[:, : self.m] += period
        v = np.vstack([line.v[: loads.size - 1], last])
        return Branch(line.start, line.end, v, self._active(v), None, True, (loads - line.start) / period)

    def _active(self, v):
        """(k, m) of v (k, size)."""
        gap = self.scene.profile[self.first : self.first + self.m] + v[:, self.m : 2 * self.m]
        return gap <= self.scene.window_n * self.scene.delta_n

    def _fold(self, line):
        """A guess of the Fold at the end of a _Line, extrapolated."""
        v, way = line.end_way()
        return Fold.of(line.end, v, self._active(v[None])[0], way)

    def held(self, frame):
        """A guess of Held from the last Frame of the approach."""
        v = self.unknowns(frame, False)
        return Held(v, self._active(v[None])[0])

    def jumps(self, approach):
        """Guesses of the Folds of the approach; None where one is not a fold, or comes too soon after another."""
        if not any(frame.slips for frame in approach):
            return ()
        try:
            lines = _lines(approach, self, lambda f: f.delta, False)
        except NotFollowed:
            return None
        return tuple(self._fold(line) for line in lines if line.slips)
