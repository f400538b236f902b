"""A slider is a continuation parameter: what carries a run is followed to other parameters, not computed anew.

branch      states along a branch, its fold, and what lies between; NotFollowed
moving      a branch and its fold moved to a changed problem
solving     from a guess to a state, for many states of one problem
skeleton    a run that slides, from the branches that carry it
reading     the skeleton of a run from its frames
follow      the skeleton of another scene from that of one nearby
"""

from .branch import NotFollowed
from .follow import follow
from .reading import skeleton_from, skeleton_of
from .skeleton import Skeleton

__all__ = ["NotFollowed", "Skeleton", "follow", "skeleton_from", "skeleton_of"]
