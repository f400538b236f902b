"""A live experiment below a slider of one's own: `panel serve docs/apps/own_slider.py`.

The scene of an Experiment can be watched, bound and set. Its own sliders set it as well.
"""

import panel as pn

from app.experiment import Experiment
from solver import Scene

pn.extension()
experiment = Experiment(Scene(hold="load", u_x_max=20.0))
friction = pn.widgets.DiscreteSlider(name="friction over adhesion", options=[0.2, 0.5, 1.0, 2.0], value=1.0)


def grip(ratio):
    experiment.scene = experiment.scene.changed(phi_ratio=ratio)


def described(scene):
    return f"φₜ/φₙ = {scene.phi_ratio:g}, E = {scene.E:g} GPa, at a held load"


friction.param.watch(lambda event: grip(event.new), "value")
said = pn.pane.Markdown(pn.bind(described, experiment.param.scene))
pn.Column("# Who sets the grip?", pn.Row(friction, said), experiment, sizing_mode="stretch_width").servable("Grip")
