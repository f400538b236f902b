"""A computed experiment as tables and plots: `simulate` one scene, `sweep` the first slips of many."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from html import escape
from itertools import product
from os import PathLike
from typing import TYPE_CHECKING, Any

import numpy as np

from . import plots
from .continuation.state import NotConverged
from .following.from_run import skeleton_of
from .following.skeleton import Skeleton
from .isolated import Lost, outcomes
from .run.frame import Frame, moving, slides_in
from .run.load_steps import abscissa, load_steps_of, place
from .run.loadpath import load_path
from .run.summary import fields_of
from .scene import PARAMETERS, SET_BY_POINTS, Scene, SceneError
from .text import counted
from .threads import one_thread

if TYPE_CHECKING:  # imported when asked for: `import solver` needs numerics only
    import holoviews as hv
    import pandas as pd
    import xarray as xr

SVG = 320, 90  # pixels of the curve in a notebook: readable beside a table, and no taller than four of its lines


@dataclass(frozen=True, eq=False)
class Result:
    """A run of one scene: its Frames, and why it ended early (None: it reached the end of its path).

    Example: `simulate(Scene()).slips`
    """

    scene: Scene
    frames: Sequence[Frame] = field(repr=False)
    failure: str | None = None

    @cached_property
    def table(self) -> pd.DataFrame:
        """A row per increment: U_x, delta, A (nm), F, L (N/m), residual (nm), evaluations, slip and stage.

        Beside U_x and delta of the stage are those of the top of the layer; they differ where a drive is not rigid.
        """
        import pandas as pd

        return pd.DataFrame(
            {
                "stage": frame.stage,
                "U_x (nm)": frame.U_x,
                "delta (nm)": frame.delta,
                "U_x_top (nm)": frame.U_x_top,
                "delta_top (nm)": frame.delta_top,
                "F (N/m)": frame.F,
                "L (N/m)": frame.L,
                "A (nm)": frame.A_bar * frame.scene.width,
                "residual (nm)": frame.residual,
                "evaluations": frame.evaluations,
                "slip": frame.slip,
            }
            for frame in self.frames
        )

    @cached_property
    def slips(self) -> pd.DataFrame:
        """A row per end of a branch: load (U_x or delta, nm), F, L (N/m) and A (nm) just before it, and its kind."""
        import pandas as pd

        return pd.DataFrame(
            [_slip(frame, event) for frame in self.frames for event in frame.slips],
            columns=["stage", "load (nm)", "F (N/m)", "L (N/m)", "A (nm)", "kind", "located", "sensitive"],
        )

    @cached_property
    def skeleton(self) -> Skeleton:
        """The Skeleton of the scene, from which curves at other parameters follow. Raises NotFollowed."""
        return skeleton_of(self.scene)

    def plot(self, over_top: bool = False) -> hv.Layout:
        """F and L, A, and the normal traction over place and displacement, as a HoloViews layout.

        over_top: draw F, L and A over the displacement of the top of the layer, not of the stage. Only a drive with a
        stiffness makes a difference. Raises ValueError for a path through points, whose length is that of the stage.
        """
        if over_top and self.scene.legs:
            raise ValueError("over_top = True; allowed with path 'shear', 'unload' or 'loop'; plot over the stage")
        return plots.experiment(self.scene, self._after, over_top)

    def save(self, file: str | PathLike) -> None:
        """Writes the plot as HTML, or as PNG (needs matplotlib). Raises ValueError for another suffix."""
        plots.save(file, self.plot)

    def to_xarray(self) -> xr.Dataset:
        """The curves over the increment, and the traction T_z (GPa) over increment and x (nm). Needs xarray."""
        import xarray as xr

        fields = fields_of(self.scene, self.frames)
        x, T_z = fields["x"] - self.scene.width / 2, fields["T"][:, 1]
        curves = {name.split(" (")[0]: ("increment", column.to_numpy()) for name, column in self.table.items()}
        return xr.Dataset(curves | {"T_z": (("increment", "x"), T_z)}, coords={"x": x}, attrs=self.scene.differences())

    @property
    def _after(self) -> list[Frame]:
        """The Frames after the approach; of a run that failed before, those that there are."""
        return [frame for frame in self.frames if frame.stage != "approach"] or list(self.frames)

    def _repr_html_(self) -> str:
        """What differs from the default, the first slip, and F over the path as a small curve."""
        changed = ", ".join(f"{name} = {value}" for name, value in self.scene.differences().items()) or "the default"
        sliding = self.slips[self.slips["stage"].map(moving).eq("U_x") & (self.slips["kind"] != "control")]
        count = int((self.slips["stage"] != "approach").sum())
        slipping = f"{counted(count, 'slip')}, none along U_x" if count else "no slip"
        if len(sliding):
            first = sliding.iloc[0]
            slipping = f"first slip at U_x = {first['load (nm)']:.2f} nm: F = {first['F (N/m)']:.4g} N/m"
            slipping += f", A = {first['A (nm)']:.4g} nm; {counted(count, 'slip')}"
        lines = [f"Scene: {changed}", f"{len(self.frames)} increments, {slipping}", self.failure]
        return "".join(f"<p>{escape(line)}</p>" for line in lines if line) + _curve(self.scene, self._after)


def simulate(scene: Scene | None = None, progress: bool = False) -> Result:
    """Computes one scene from approach to the end of its path.

    Parameters: scene (default: that of the paper's Fig. 6); progress: show a bar on standard error.
    Returns a Result. Where an increment has no equilibrium in reach, the Result ends before it, and `failure` has the
    reason and a remedy.

    Example: `simulate(Scene(delta_bar=0.2)).table`
    """
    scene = scene or Scene()
    path = load_path(scene)
    return Result(scene, *collected(with_progress(scene, path) if progress else path))


@one_thread()
def collected(path: Iterable[Frame]) -> tuple[list[Frame], str | None]:
    """(the Frames of a path up to its end or failure, the reason of the failure or None)."""
    frames: list[Frame] = []
    try:
        frames.extend(path)
    except NotConverged as failure:
        return frames, str(failure)
    return frames, None


def with_progress(scene: Scene, path: Iterable[Frame], **options: Any) -> Iterable[Frame]:
    """The Frames of a scene's path, counted by a bar on standard error; options: those of tqdm."""
    from tqdm import tqdm  # only who asks for a bar needs it

    count = sum(step.increments + 1 for step in load_steps_of(scene))
    return tqdm(path, total=count, unit=" increments", **options)


def sweep(scene: Scene | None = None, workers: int = 1, **values: Iterable[Any]) -> pd.DataFrame:
    """Computes the first slip for every combination of parameter values.

    Parameters: scene: what the values change (default: Scene()); workers: processes; values: NAME=[...] of parameters.
    Returns a row per combination, the last name varying fastest: the parameters, U_s (nm), F_s, L_s (N/m), A_s, A_0
    (nm), and `outcome`: "slips", "no slip" up to u_x_max, or why there is no result. Missing numbers are nan.
    Raises ValueError for a name that is no parameter, or values that are no list; SceneError for a value outside its
    range, and for one that path 'points' does not use.

    With workers > 1 processes are started: call it under `if __name__ == "__main__":`.

    Example: `sweep(delta_bar=[0.0, 0.2], phi_ratio=[0.5, 1.0])`
    """
    import pandas as pd

    combinations, scenes = _swept(scene or Scene(), values)
    if workers > 1:
        first = dict(outcomes(first_slip, scenes, workers))
    else:
        first = {k: first_slip(each) for k, each in enumerate(scenes)}
    rows = [first[k] if isinstance(first[k], dict) else {"outcome": _lost(first[k])} for k in range(len(scenes))]
    columns = [*values, "U_s (nm)", "F_s (N/m)", "L_s (N/m)", "A_s (nm)", "A_0 (nm)", "outcome"]
    return pd.DataFrame([given | row for given, row in zip(combinations, rows, strict=True)], columns=columns)


def _swept(scene, values):
    """(the combinations of {name: values}, the Scene of each); raises as `sweep`."""
    for name, listed in values.items():
        if name not in PARAMETERS:
            raise ValueError(f"{name} is no parameter of a Scene; allowed: {', '.join(PARAMETERS)}")
        if isinstance(listed, str) or not isinstance(listed, Iterable):
            raise ValueError(f"{name} = {listed!r}: allowed: a list of values; write {name}=[{listed!r}]")
    combinations = [dict(zip(values, combination, strict=True)) for combination in product(*values.values())]
    scenes = [scene.changed(**combination) for combination in combinations]
    for name in SET_BY_POINTS:
        if name in values and any(each.legs for each in scenes):
            why = "not used with path 'points', whose points set it"
            raise SceneError(name, values[name], why, "sweep points instead")
    return combinations, scenes


def _lost(lost: Lost) -> str:
    return f"not computed: {lost}"


def first_slip(scene: Scene) -> dict[str, Any]:
    """The first slip of a scene, and its area at U_x = 0, as a row of `sweep`; the run ends there."""
    row: dict[str, Any] = {}
    try:
        for frame in load_path(scene):
            if frame.stage == "approach":
                continue
            row.setdefault("A_0 (nm)", frame.A_bar * scene.width)
            if slips := slides_in(frame):
                numbers = _slip(frame, slips[0])
                slip = {f"{name}_s ({unit})": numbers[f"{name} ({unit})"] for name, unit in FORCES}
                return row | {"U_s (nm)": slips[0].load, "outcome": "slips"} | slip
    except NotConverged as failure:
        return row | {"outcome": str(failure)}
    return row | {"outcome": "no slip"}


FORCES = ("F", "N/m"), ("L", "N/m"), ("A", "nm")


def _slip(frame, event):
    """A SlipEvent of a Frame as a row, in N/m and nm."""
    forces = {"F (N/m)": event.F_bar * frame.unit, "L (N/m)": event.L_bar * frame.unit}
    where = {"stage": event.stage, "load (nm)": event.load} | forces | {"A (nm)": event.A_bar * frame.scene.width}
    return where | {name: getattr(event, name) for name in ("kind", "located", "sensitive")}


def _curve(scene, frames):
    """F over the `abscissa` as an SVG without axes."""
    if len(frames) < 2:
        return ""
    x, y = np.array([(place(scene, frame), frame.F) for frame in frames]).T
    wide, high = SVG
    at = [(value - value.min()) / (np.ptp(value) or 1.0) for value in (x, y)]
    points = " ".join(f"{wide * a:.1f},{high * (1.0 - b):.1f}" for a, b in zip(*at, strict=True))
    label = f"F over {abscissa(scene)}, {y.min():.4g} to {y.max():.4g} N/m"
    line = f'<polyline points="{points}" fill="none" stroke="#0072b2" stroke-width="1.5"/>'
    return f'<svg width="{wide}" height="{high}" role="img" aria-label="{label}"><title>{label}</title>{line}</svg>'
