"""Two punches beside a table of their slips: `panel serve docs/apps/dashboard.py`, or save it as a file by this script.

Stage plays a Result of the solver in any layout of Panel, without a server.
"""

import pandas as pd
import panel as pn
from bokeh.resources import INLINE

from app.stage import Stage
from solver import Scene, simulate

pn.extension()
soft, stiff = simulate(Scene(E=50.0)), simulate(Scene(E=140.0))
slips = pd.concat({"E = 50 GPa": soft.slips, "E = 140 GPa": stiff.slips}, names=["layer", "slip"])
columns = ["U_s (nm)", "F_s (N/m)", "A_s (nm)"]

dashboard = pn.Column(
    "# A soft and a stiff layer",
    pn.Row(Stage(soft, height=520), Stage(stiff, height=520)),
    "The stiffer layer slips earlier, at a larger force.",
    pn.pane.DataFrame(slips[columns].groupby("layer").head(3), float_format="{:.4g}".format),
    sizing_mode="stretch_width",
)
dashboard.servable("Two layers")

if __name__ == "__main__":
    dashboard.save("dashboard.html", title="Two layers", resources=INLINE)  # needs no network
