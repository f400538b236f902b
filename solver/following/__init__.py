"""A slider is a continuation parameter: what carries a run is followed to other parameters, not computed anew.

branch      states along a branch, its fold, and what lies between; NotFollowed
solver      from guesses to states and folds of one problem
skeleton    a run that slides, from the branches that carry it
moved       branches and their folds moved to a changed problem; knows nothing of contacts
refinement  how many states a branch needs
held        the load that is held
patch       a skeleton on a wider patch
no_contact  left of the jump into contact
follow      the skeleton of another scene from that of one nearby
from_run    the skeleton of a run from its trace
"""
