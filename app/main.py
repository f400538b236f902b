"""The script that `panel serve app` runs once per visitor."""

import panel as pn

from app import experiment, lab, routes

routes.require()  # a server of this file alone has run no hooks
lab.serve() if "lab" in pn.state.session_args else experiment.serve()
