"""The features of the page, a folder each: see app/interface.py. Those of APP_FEATURES_PATH count, too."""

import os

__path__ += filter(None, os.environ.get("APP_FEATURES_PATH", "").split(os.pathsep))
