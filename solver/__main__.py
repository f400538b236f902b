"""`python -m solver`: the command line of `cli`."""

import sys

from .cli.main import process

if __name__ == "__main__":
    sys.exit(process())
