"""Error against run time of one experiment, by every method. Not needed to run anything.

methods, fire    the methods that are compared
compare          one run against a reference: errors, branches
judge            which branches are right, by GFMD alone
measure          the sweeps of one scene
verdict, page    what the figures mean in a sentence, and the page with the diagrams
"""
