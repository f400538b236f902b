"""Predicted runs while a visitor drags a slider: a worker continues the run on screen to the new parameters."""

import re
from dataclasses import dataclass

import numpy as np

from app.service.skeletons import packed
from solver import NotFollowed, Scene, follow
from solver.following.skeleton import Skeleton


@dataclass(frozen=True)
class Followed:
    """A predicted run: its `body` for the browser, and the Skeleton from which the next prediction starts."""

    body: bytes
    skeleton: Skeleton


def followed(skeleton: Skeleton, scene: Scene) -> Followed | str:
    """Predict a scene from the Skeleton of a similar scene; return its Followed, or a str: why it failed."""
    try:
        with np.errstate(invalid="ignore"):  # `packed` finds it
            there = follow(skeleton, scene)
            return Followed(packed(there), there)
    except NotFollowed as why:
        return re.sub(r"\d[\d.e+-]*", "n", str(why))  # metrics count reasons without their numbers
