"""The script that `panel serve app` runs once per visitor."""

import panel as pn

from app import lab
from app.page import open_page

lab.serve() if "lab" in pn.state.session_args else open_page()
