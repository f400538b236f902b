"""The script that `panel serve app` runs once per visitor."""

import panel as pn

from app import lab, routes
from app.page import open_page

routes.require()  # a server of this file alone has run no hooks
lab.serve() if "lab" in pn.state.session_args else open_page()
