"""Uncertain parameters: a band around the curves of a run, and intervals of its slips."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..following.follow import follow
from ..following.moved import NotFollowed
from ..following.skeleton import Skeleton
from ..scene import Scene, SceneError
from .outputs import over_own
from .partial import continuous
from .sensitivities import Sensitivities, sensitivities

WIDE = 1.96  # standard deviations on both sides of the mean: 95 % of a normal distribution
ENDS = (2.5, 97.5)  # per cent, of the draws, for the same
SLIP = ("U_s", "F_s", "L_s", "A_s")


@dataclass(frozen=True)
class Spread:
    """The spread of a run with independent normal parameters; forces and areas over its own wE and w.

    deviations: {parameter: standard deviation}. band: of each branch (4, n), standard deviations of U_x (nm), F_bar,
    L_bar, A_bar of its states, each at its place on the branch. slips: of each slip (4,), those of U_s, F_s, L_s, A_s.
    drawn: (draws, 4), U_s, F_s, L_s, A_s of the first slip in runs followed to drawn parameters. lost: the number of
    draws without such a run.
    """

    sensitivities: Sensitivities
    deviations: dict[str, float]
    band: tuple[NDArray[np.float64], ...]
    slips: tuple[NDArray[np.float64], ...]
    drawn: NDArray[np.float64]
    lost: int

    def interval(self, name: str, slip: int = 0) -> tuple[float, float]:
        """95 % of U_s, F_s, L_s or A_s of a slip, by the derivatives."""
        k = SLIP.index(name)
        middle = float(self.sensitivities.slips[slip].values[k])
        return middle - WIDE * float(self.slips[slip][k]), middle + WIDE * float(self.slips[slip][k])

    def drawn_interval(self, name: str) -> tuple[float, float] | None:
        """95 % of U_s, F_s, L_s or A_s of the first slip, by the draws; None without draws."""
        if not len(self.drawn):
            return None
        low, high = np.percentile(self.drawn[:, SLIP.index(name)], ENDS)
        return float(low), float(high)

    def sentences(self) -> list[str]:
        """The intervals of the first slip, by the derivatives and by the draws if there are any."""
        scene, lines = self.sensitivities.skeleton.scene, []
        if not self.slips:
            return [f"The run has no slip up to u_x_max = {scene.u_x_max:g} nm"]
        force = scene.width * scene.E
        units = dict(zip(SLIP, ((1.0, "nm"), (force, "N/m"), (force, "N/m"), (scene.width, "nm")), strict=True))
        for name in SLIP:
            low, high = self.interval(name)
            factor, unit = units[name]
            lines.append(f"{name} of the first slip: {low * factor:.6g} .. {high * factor:.6g} {unit} (95 %, linear)")
            if drawn := self.drawn_interval(name):
                low, high = drawn
                lines.append(f"  by {len(self.drawn)} draws: {low * factor:.6g} .. {high * factor:.6g} {unit}")
        if self.lost:
            lines.append(f"{self.lost} draws are runs of another kind, and are left out")
        return lines

    def rows(self) -> list[list[float]]:
        """Branch, U_x, F_bar, L_bar, A_bar and deviations of the last three, of every state."""
        rows = []
        for k, (branch, band) in enumerate(zip(self.sensitivities.branches, self.band, strict=True), 1):
            rows += [
                [k, *map(float, state), *map(float, sd)] for state, sd in zip(branch.values.T, band[1:].T, strict=True)
            ]
        return rows

    def as_dict(self) -> dict[str, object]:
        """By plain names, as JSON has it."""
        linear = [{name: self.interval(name, k) for name in SLIP} for k in range(len(self.slips))]
        drawn = {name: self.drawn_interval(name) for name in SLIP}
        return {
            "deviations": self.deviations,
            "slips": linear,
            "drawn": drawn,
            "draws": len(self.drawn),
            "lost": self.lost,
        }


def deviations(scene: Scene, texts: Mapping[str, str]) -> dict[str, float]:
    """{parameter: standard deviation} of {'phi_n': '10%'} or {'phi_n': '0.2'}; raises ValueError.

    A share of a parameter that is 0 is refused: its deviation would be 0.
    """
    result = {}
    for name, text in texts.items():
        if name not in continuous(scene):
            raise ValueError(f"--of {name}: allowed: {', '.join(continuous(scene))}")
        try:
            value = float(text.rstrip(" %"))
        except ValueError:
            value = -1.0
        if not 0.0 < value < float("inf"):
            raise ValueError(
                f"--of {name}={text}: give a standard deviation above 0, as 10% or in the parameter's unit"
            )
        if text.rstrip().endswith("%") and not getattr(scene, name):
            raise ValueError(f"--of {name}={text}: {name} is 0; give its standard deviation in the parameter's unit")
        result[name] = 0.01 * value * abs(getattr(scene, name)) if text.rstrip().endswith("%") else value
    return result


def spread(skeleton: Skeleton, of: Mapping[str, float], draws: int = 0) -> Spread:
    """The Spread of a run with uncertain parameters, by its derivatives.

    Parameters: skeleton: as of `skeleton_of`; of: {parameter: standard deviation, in its unit}; draws: the number of
    runs followed to parameters drawn at random, which check the derivatives.
    Returns a Spread: a band around every branch, intervals of U_s, F_s, L_s and A_s.
    Raises NotFollowed where Newton's steps do not solve a state or a slip.

    Example: `spread(skeleton_of(Scene()), {"phi_n": 0.1}).interval("F_s")`
    """
    result = sensitivities(skeleton, tuple(of))

    def deviation(part):
        own = [over_own(skeleton.scene, name, part.values, part.by[name]) * of[name] for name in of]
        return np.linalg.norm(np.array([np.zeros_like(part.values), *own]), axis=0)

    band, slips = (tuple(map(deviation, parts)) for parts in (result.branches, result.slips))
    rows = [draw(skeleton, of, number) for number in range(draws if slips else 0)]
    drawn = [row for row in rows if row is not None]
    return Spread(result, dict(of), band, slips, np.array(drawn).reshape(-1, 4), len(rows) - len(drawn))


def draw(skeleton: Skeleton, of: Mapping[str, float], number: int) -> NDArray[np.float64] | None:
    """U_s, F_s, L_s, A_s (4,) of the first slip of a run followed to random parameters; None without a slip."""
    rng, scene = np.random.default_rng((1, number)), skeleton.scene
    values = {name: getattr(scene, name) + deviation * rng.normal() for name, deviation in of.items()}
    try:
        drawn = scene.changed(**values)
        slip = sensitivities(follow(skeleton, drawn), (), branches=False).slips[0]
    except (NotFollowed, SceneError, IndexError):
        return None
    wide = drawn.width / scene.width
    return slip.values * [1.0, wide * drawn.E / scene.E, wide * drawn.E / scene.E, wide]
