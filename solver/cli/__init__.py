"""The command line.

main           all commands, exit codes, the lists of parameters and presets
run, verify    one experiment, and a repeated one
sweep          first slips of combinations of values
accuracy       error against run time
serve          the page of the app
options        what commands share: the options of a scene, files, progress
measured       options that say how measured files are read
pairs          NAME=VALUE arguments
"""

from .main import main, parser

__all__ = ["main", "parser"]
