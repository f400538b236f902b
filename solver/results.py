"""A computed experiment as tables and plots."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from html import escape
from math import inf
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from . import plots
from .cautions import cautions_of
from .continuation.state import SENTENCES, NotConverged, Outcome
from .following.from_run import skeleton_from, skeleton_of
from .following.skeleton import Skeleton
from .run.frame import Frame, SlipEvent
from .run.held_load import held_at
from .run.load_steps import abscissa, load_steps_of, place, slip_at
from .run.loadpath import Checkpoint, Run, deadline, time_limit
from .run.summary import curves_of, fields_of, first_slip_in, kind_of, least_force, values_of
from .scene import Scene, checked_scene
from .text import counted, in_ascii
from .threads import computation

if TYPE_CHECKING:  # imported when asked for: `import solver` needs numerics only
    import holoviews as hv
    import pandas as pd
    import xarray as xr

    from .analysis.interior import Stress

FIRST = "U_s (nm)", "F_s (N/m)", "L_s (N/m)", "A_s (nm)"  # columns of a first slip


class FirstSlip(NamedTuple):
    """The first slip along U_x: U_s (nm), and F_s, L_s (N/m) and A_s (nm) just before it."""

    U_s: float
    F_s: float
    L_s: float
    A_s: float


class PullOff(NamedTuple):
    """Where the surfaces part: U_x, delta (nm) of the stage, and F, L (N/m) just before; L is the parting load.

    The largest pull of a retraction, `L_min` of `summarize`, comes before and is larger.
    """

    U_x: float
    delta: float
    F: float
    L: float


@dataclass(frozen=True, eq=False, repr=False)
class Result:
    """A run of one scene: its Frames, its Outcome, why it failed, if it did, and the Checkpoint at its end.

    Example: `simulate(Scene()).slips`
    """

    scene: Scene
    frames: Sequence[Frame]
    failure: str | None = None
    checkpoint: Checkpoint | None = None
    outcome: Outcome = Outcome.FINISHED

    @cached_property
    def table(self) -> pd.DataFrame:
        """A row per increment: U_x, delta (nm), F, L (N/m), A (nm), residual (nm), evaluations, slip and stage.

        Beside U_x and delta of the stage are those of the top of the layer; they differ where a drive is not rigid.
        """
        import pandas as pd

        return pd.DataFrame(curves_of(self.frames))

    @cached_property
    def slips(self) -> pd.DataFrame:
        """A row per end of a branch: U_s (nm), F_s, L_s (N/m) and A_s (nm) just before it, its kind, `sensitive`.

        Where delta moves after the approach, on path 'unload' or 'points', delta_s (nm) stands beside U_s.
        """
        import pandas as pd

        rows, least = list[tuple](), least_force(self.frames)
        for frame in self.frames:
            for event in frame.slips:
                values = values_of(frame, event, least)
                numbers = (*slip_at(frame, event), *(values[name] for name in "FLA"))
                rows.append((event.stage, *numbers, values["kind"], event.sensitive))
        table = pd.DataFrame(rows, columns=["stage", FIRST[0], "delta_s (nm)", *FIRST[1:], "kind", "sensitive"])
        return table if self.scene.path in ("unload", "points") else table.drop(columns="delta_s (nm)")

    @property
    def first_slip(self) -> FirstSlip | None:
        """The FirstSlip of a stage that moves U_x; None without one."""
        found = first_slip_in(self.frames)
        return found and first_of(*found)

    @property
    def pull_off(self) -> PullOff | None:
        """The PullOff of a retraction, or under a held load, there to one increment; None if the surfaces hold."""
        least = least_force(self.frames)
        for frame in self.frames:
            for event in frame.slips:
                if kind_of(frame, event) == "pull-off":
                    values = values_of(frame, event, least)
                    return PullOff(*slip_at(frame, event), values["F"], values["L"])
        if self.frames and self.outcome is Outcome.PULLED_OFF:
            last = self.frames[-1]
            return PullOff(last.U_x, last.delta, last.F, last.L)
        return None

    @cached_property
    def cautions(self) -> tuple[str, ...]:
        """A sentence for every choice that affects the result, such as a sensitive slip, a soft layer, low damping."""
        return tuple(cautions_of(self.scene, self.frames))

    @cached_property
    def skeleton(self) -> Skeleton:
        """The Skeleton of the run, from which curves at other parameters follow. Raises NotFollowed."""
        return skeleton_from(self.scene, self.checkpoint) if self.checkpoint else skeleton_of(self.scene)

    def stress(self, U_x: float, z: NDArray[np.float64] | None = None) -> Stress:
        """The stress in the layer (GPa) at the increment nearest to U_x (nm), of the first stage if several are.

        z (k,): heights above the lower surface, nm; by default 101 from the surface to the top of the layer.
        Returns Stress(x (m,), z (k,), xx, zz, xz (k, m)). Raises ValueError for a z outside the layer, and
        for a run without an increment.
        """
        from .analysis.interior import stress_in

        return stress_in(min(self._shown, key=lambda frame: abs(frame.U_x - U_x)), z)

    @cached_property
    def edges(self) -> pd.DataFrame:
        """A row per increment in which one part is in contact: U_x (nm), and of its trailing and its leading edge the
        place x (nm), the energy release rate J (N/m) and the mode angle psi (rad); see `release_rates`.
        """
        import pandas as pd

        from .analysis.toughness import edges_over

        return pd.DataFrame(edges_over(self._after))

    def plot(self, over_top: bool = False) -> hv.Layout:
        """F and L, A, and the normal traction over place and displacement, as a HoloViews layout.

        over_top: draw F, L and A over the displacement of the top of the layer, not of the stage. Only a drive with a
        stiffness makes a difference. Raises ValueError for a path through points, whose length is that of the stage,
        and for a run without an increment.
        """
        if over_top and self.scene.legs:
            raise ValueError("over_top = True; allowed with path 'shear', 'unload' or 'loop'; plot over the stage")
        return plots.experiment(self.scene, self._shown, over_top)

    def save(self, file: str | PathLike) -> None:
        """Writes the plot as .html, .png or .svg, or the table as .csv; .png and .svg need matplotlib.

        Raises ValueError for another suffix and as `plot`, ImportError without matplotlib.
        """
        if Path(file).suffix == ".csv":
            self.table.to_csv(file, index=False, lineterminator="\n")
        else:
            plots.save(file, self.plot, repr(self.scene), self.notes)

    def to_xarray(self) -> xr.Dataset:
        """The curves over the increment, and the tractions T_x and T_z (GPa) over increment and x (nm).

        x counts from the middle of the cell. Every variable has its unit as the attribute `units`. Needs xarray.
        """
        import xarray as xr

        fields = fields_of(self.frames)
        variables: dict[str, Any] = {}
        for heading, column in self.table.items():
            name, _, unit = str(heading).rstrip(")").partition(" (")
            variables[name] = "increment", column.to_numpy(), {"units": unit} if unit else {}
        for k, name in enumerate(("T_x", "T_z")):
            variables[name] = ("increment", "x"), fields["T"][:, k], {"units": "GPa"}
        place = {"x": ("x", fields["x"], {"units": "nm"})}
        return xr.Dataset(variables, coords=place, attrs=self.scene.differences())

    @property
    def _after(self) -> list[Frame]:
        """The Frames after the approach; of a run that failed before, those that there are."""
        return [frame for frame in self.frames if frame.stage != "approach"] or list(self.frames)

    @property
    def _shown(self) -> list[Frame]:
        """As `_after`; raises ValueError, which says why, where there is no Frame at all."""
        if not self.frames:
            raise ValueError(f"the run has no increment to show: {self.failure or 'compute it by simulate'}")
        return self._after

    @property
    def notes(self) -> list[str]:
        """Sentences on what limits the result: failure, pull-off, cautions, and what was done to a measured profile."""
        profile = self.scene.measured.notes if self.scene.measured else ()
        failed = [each for each in (self.failure, self.parted) if each]
        return [*failed, *(f"Caution: {each}" for each in self.cautions), *(f"Profile: {note}" for note in profile)]

    @property
    def parted(self) -> str:
        """Where the contact pulled off under its held load, as a sentence; "" where it did not."""
        if self.outcome is not Outcome.PULLED_OFF:
            return ""
        if (end := self.pull_off) is None:
            return SENTENCES[Outcome.PULLED_OFF]
        where = f"U_x = {end.U_x:.4g} nm, delta = {end.delta:.4g} nm"
        return f"Pulled off at {where}, under the held load L = {end.L:.4g} N/m, with F = {end.F:.4g} N/m."

    @property
    def _lines(self) -> list[str]:
        """What differs from the default, the first slip, and what limits the result."""
        changed = ", ".join(f"{name} = {value}" for name, value in self.scene.differences().items()) or "the default"
        count, first = int((self.slips["stage"] != "approach").sum()), self.first_slip
        lines = [f"Scene: {changed}", f"{counted(len(self.frames), 'increment')}, {counted(count, 'slip')}"]
        if first:
            forces = f"F = {first.F_s:.4g} N/m, L = {first.L_s:.4g} N/m, A = {first.A_s:.4g} nm"
            lines.append(f"First slip at U_x = {first.U_s:.2f} nm: {forces}")
        return [*lines, *self.notes]

    def __repr__(self) -> str:
        return in_ascii("\n".join(self._lines))  # a file on Windows may hold ASCII only

    def _repr_html_(self) -> str:
        """The lines of `print`, and F over the path as a small curve."""
        return "".join(f"<p>{escape(line)}</p>" for line in self._lines) + _curve(self.scene, self._after)


@computation
def simulate(
    scene: Scene | None = None, progress: bool = False, load: float | None = None, limit: float | None = None
) -> Result:
    """Computes one scene from approach to the end of its path.

    Parameters: scene (default: that of the paper's Fig. 6); progress: show a bar on standard error; load: the normal
    load (N/m) to hold during the shear, in place of delta_bar and hold. `result.scene` has the indentation found;
    limit: processor time of the run, s (default: none, but 50 s for a soft layer, as of `time_limit`).
    Returns a Result. Where an increment has no equilibrium in reach, the Result ends before it, `outcome` says how, and
    `failure` has the reason and a remedy. A contact that pulls off under its held load is no failure: see `pull_off`.
    Raises SceneError for a load that the approach does not reach or the path cannot hold, TypeError for a scene that is
    none.

    Example: `simulate(Scene(delta_bar=0.2)).table`
    """
    frames, checkpoint, scene = list[Frame](), None, checked_scene(Scene() if scene is None else scene)
    observe = deadline(time_limit(scene, limit), inf)
    try:
        if load is not None:
            scene, frames, checkpoint = held_at(scene, load, observe)
        path: Iterable[tuple[Frame, Checkpoint]] = Run(scene).frames(checkpoint, observe=observe)
        if progress:
            path = with_progress(scene, path, initial=len(frames))
        for frame, checkpoint in path:  # noqa: B007  the last one counts
            keep(frames, frame)
    except NotConverged as error:
        return ended(scene, frames, error, checkpoint)
    return Result(scene, frames, None, checkpoint)


def _room():
    """Half of the memory of this machine, bytes; where that is not known, as on Windows, that of a small one."""
    try:
        return 0.5 * os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (AttributeError, OSError, ValueError):
        return 4e9


ROOM = _room()


def keep(frames: list[Frame], frame: Frame) -> None:
    """Appends a Frame; raises NotConverged where so many take more memory than there is room for."""
    frames.append(frame)
    size = len(frames) * (frame.u.nbytes + frame.T.nbytes)
    if size > ROOM:
        what = f"{len(frames)} increments of {frame.u.shape[1]} nodes take {size / 1e9:.3g} GB, half of the memory"
        remedy = "use a larger du_x or du_z, or fewer nodes; load_path hands on one increment at a time"
        raise NotConverged(f"{what}; {remedy}", Outcome.OUT_OF_MEMORY)


def ended(scene: Scene, frames: Sequence[Frame], by: NotConverged, checkpoint: Checkpoint | None = None) -> Result:
    """The Result of a run that ended early."""
    return Result(scene, frames, None if by.outcome.reached else str(by), checkpoint, by.outcome)


def with_progress(scene: Scene, path: Iterable[Any], **options: Any) -> Iterable[Any]:
    """What a scene's path yields for its increments, counted by a bar on standard error; options: those of tqdm."""
    from tqdm import tqdm  # only who asks for a bar needs it

    count = sum(step.increments + 1 for step in load_steps_of(scene))
    return tqdm(path, total=count, unit=" increments", **options)


def first_of(frame: Frame, event: SlipEvent) -> FirstSlip:
    """The FirstSlip of a SlipEvent of a Frame."""
    values = values_of(frame, event)
    return FirstSlip(event.load, values["F"], values["L"], values["A"])


def _curve(scene, frames):
    """F over the `abscissa` as an SVG without axes."""
    if len(frames) < 2:
        return ""
    x, y = np.array([(place(frame), frame.F) for frame in frames]).T
    wide, high = 320, 90  # pixels: readable beside a table, and no taller than four of its lines
    at = [(value - value.min()) / (np.ptp(value) or 1.0) for value in (x, y)]
    points = " ".join(f"{wide * a:.1f},{high * (1.0 - b):.1f}" for a, b in zip(*at, strict=True))
    label = f"F over {abscissa(scene)}, {y.min():.4g} to {y.max():.4g} N/m"
    line = f'<polyline points="{points}" fill="none" stroke="#0072b2" stroke-width="1.5"/>'
    return f'<svg width="{wide}" height="{high}" role="img" aria-label="{label}"><title>{label}</title>{line}</svg>'
