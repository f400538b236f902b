"""Checks of the solver that share no code with it, and its error against run time. No run needs this package.

extended, recheck, spectrum     the residual of a frame in extended precision, all growth rates of its disturbances
form, closed_forms, adhesion    problems with published solutions
conditioning                    the round-off of each formula
atlas, stability, stability_report           stiff and extreme scenes, the verdict on each, the report
accuracy, compare, landings, methods         error against run time of one scene, by several methods
accuracy_report                              its report
document                                     a report as text and as a page
"""
