"""The page "Inside the solid": the stress in the layer. The browser draws it (page.js)."""

import numpy as np
from bokeh.palettes import cividis

from app.pages import Sheet
from app.pages.notebook import laid_out, page_of
from app.schema import STRESSES
from app.views.plots import blank, draw_image
from solver import load_path
from solver.analysis.interior import transfer, wavenumbers

TITLE, ORDER, FIGURES = "Inside the solid", 4, ("field",)
COLUMNS, ROWS, MODES, WIDE = 400, 100, 1024, 250.0  # of the picture, as in page.js; WIDE: half width, nm


def compose():
    """Return the figure of the stress."""
    plot = blank("solid_field", "x in the punch, undeformed (nm)", "height z in the layer (nm)", (-250, 250), (0, 250))
    draw_image(plot, "field", [("x", "$x{0} nm"), ("z", "$y{0} nm"), ("", "@image{0.000} GPa")])
    return [plot]


def figure(scene):
    """Return the largest shear stress in the layer at the end of the run of a Scene, for a notebook."""
    page = page_of(compose, Page, scene)
    (*_, frame) = load_path(scene)
    half = min(WIDE, 0.5 * scene.width)
    depth = min(half, scene.height * scene.width)
    stress = stress_in(frame, (np.arange(COLUMNS) + 0.5) * (2.0 * half / COLUMNS) - half, depth)
    largest = np.hypot(stress[1] - stress[0], 2.0 * stress[2]) / 2.0
    place = {"x": [-half], "y": [0.0], "dw": [2.0 * half], "dh": [depth]}
    page.draw("field", "field", image=[largest.astype(np.float32)], **place)
    view = page.views["field"]
    view.parts["field"].glyph.color_mapper.update(palette=list(cividis(256)), low=0.0, high=float(largest.max()))
    view.figure.x_range.update(start=-half, end=half)
    view.figure.y_range.update(start=0.0, end=depth)
    return laid_out(page)


def stress_in(frame, x, depth):
    """Return sigma_xx, sigma_zz, sigma_xz (3, ROWS, x.size), GPa, at x (nm from the middle), down to a depth (nm)."""
    scene = frame.scene
    T = np.zeros((2, scene.nodes))
    T[:, frame.first : frame.first + frame.T.shape[1]] = frame.T
    T_q = np.fft.rfft(T, norm="forward")[:, : min(MODES, scene.nodes // 2)]
    T_q[:, 1:] *= 2.0  # the modes of -q
    q, z = wavenumbers(scene, T_q.shape[1]), (np.arange(ROWS) + 0.5) * (depth / ROWS)
    even, odd = np.moveaxis(transfer(q, z, scene.height * scene.width, 1.0, scene.nu)[2:], 1, 0)
    modes = even * T_q[[1, 1, 0], None] + 1j * odd * T_q[[0, 0, 1], None]
    return (modes @ np.exp(1j * np.outer(q, x + 0.5 * scene.width))).real


class Page(Sheet):
    """The page of one visitor; see app/pages."""

    def start(self):
        """Send colours and labels; the browser draws from its frames and its table of the layer."""
        self.publish(palette=list(cividis(256)), stresses={name: vars(stress) for name, stress in STRESSES.items()})
