"""The script that `panel serve app` runs once per visitor."""

import panel as pn

from app import experiment, interface, routes

routes.require()  # a server of this file alone has run no hooks
owner = interface.owner(pn.state.session_args)
owner.serve(pn.state.session_args) if owner else experiment.serve()
