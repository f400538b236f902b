"""`python -m solver`: the command line of `cli`."""

import sys

from .cli import main

if __name__ == "__main__":
    sys.stdout.reconfigure(errors="replace")  # units in --help are Greek, which some terminals cannot show
    sys.exit(main())
