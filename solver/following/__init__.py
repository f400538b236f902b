"""A slider is a continuation parameter: what carries a run is followed to other parameters, not computed anew.

branch      states along a branch, its fold, and what lies between; NotFollowed
moving      a branch and its fold moved to a changed problem; knows nothing of contacts
solving     from a guess to a state, for many states of one problem
skeleton    a run that slides, from the branches that carry it
reading     the skeleton of a run from its frames
telling     how many states a branch needs
wider       a skeleton on a wider patch
without     left of the jump into contact
follow      the skeleton of another scene from that of one nearby
"""
