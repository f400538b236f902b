"""Error against run time of the solver. No run needs this package.

accuracy, compare, landings, methods         error against run time of one scene, by several methods
accuracy_report                              its report
document                                     a report as text and as a page
"""
