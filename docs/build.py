"""Build the documentation, with tutorials and gallery executed: `python docs/build.py [FOLDER]`.

Every warning is an error: a broken reference between pages, a tutorial that fails, a docstring that does not parse.
"""

import argparse
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).parent
# Sphinx reads the pages in as many batches, in the order of their names: four spread the tutorials over two cores.
BATCHES = "4"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("folder", nargs="?", type=Path, default=HERE / "_build")
    parser.add_argument("--links", action="store_true", help="check links to other sites, which needs the internet")
    arguments = parser.parse_args()
    builders = ["html"] + ["linkcheck"] * arguments.links
    commands = [
        [sys.executable, "-m", "sphinx", "-j", BATCHES, "-W", "--keep-going", "-q", "-b", name] for name in builders
    ]
    return max(subprocess.run([*command, HERE, arguments.folder / command[-1]]).returncode for command in commands)


if __name__ == "__main__":
    sys.exit(main())
