"""Continuation of a run in its parameters: its skeleton is followed to another scene, in place of another run.

skeleton    a run that slides, by its branches
moved       states, folds and branches moved to a changed problem; knows nothing of contacts; NotFollowed
refinement  how many states a branch needs
follow      the skeleton of another scene from that of one nearby, also under a held load
from_run    the skeleton of a run from its trace
approach    an approach walked in long steps
certify     whether a skeleton is the run of its scene, checked in place of computed
"""
