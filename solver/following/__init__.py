"""Continuation of a run in its parameters: its skeleton is followed to another scene, in place of another run.

branch      states along a branch, its fold, and interpolation between them; NotFollowed
solver      states and folds of one problem from guesses
skeleton    a run that slides, by its branches
moved       branches and their folds moved to a changed problem; knows nothing of contacts
refinement  how many states a branch needs
held        the state at the end of the approach, which gives the held load
patch       a skeleton on a wider patch
no_contact  sliding without contact, before the jump into it
follow      the skeleton of another scene from that of one nearby
from_run    the skeleton of a run from its trace
"""
