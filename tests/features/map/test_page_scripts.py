"""The map of tractions, as the page makes it."""

import numpy as np
import pytest
from scripts import run_of

from app.service import packing
from solver import Scene

WIDE = Scene(u_x_max=2.0)  # has free nodes at its edges


ROUNDED = 2 * packing.FINE + 0.002  # of the largest value: straight lines over frames and nodes, and the steps


def test_contact_map_is_empty_where_no_traction_acts(tab):
    frames = run_of(tab, WIDE)
    shear = [frame for frame in frames if frame.stage == "shear"]
    made = tab.evaluate(
        """(async () => {
            const { tractionsOver } = await import("http://scripts/features/map/index.js")
            const { image, rows, columns, start, low } = tractionsOver(run, run.length - 1)
            return { image: [...image].map((v) => (Number.isNaN(v) ? null : v)), rows, columns, start, low }
        })()"""
    )
    image = np.array(made["image"], dtype=float).reshape(made["rows"], made["columns"])
    assert made["columns"] == len(shear) and made["start"] == 0.0
    peak = WIDE.phi_n / (np.e * WIDE.delta_n)
    for column in (0, len(shear) // 2, -1):
        frame = shear[column]
        nodes = frame.first + np.arange(frame.u.shape[1])
        own = np.full(nodes.size, np.nan)  # a browser gets no nodes that are far away
        rows = nodes - round((made["low"] + WIDE.width / 2) / WIDE.spacing + 0.5)
        sent = (rows >= 0) & (rows < made["rows"])
        own[sent] = image[rows[sent], column]
        gap = WIDE.profile[nodes % WIDE.nodes] + frame.u[1]
        acts = (gap <= WIDE.delta_n) | (frame.T[1] <= -packing.FREE * peak)
        sure = np.abs(frame.T[1] + packing.FREE * peak) > ROUNDED * peak  # not on the limit, where rounding decides
        assert (np.isfinite(own) == acts)[sure].all() and acts.any() and not acts.all()
        assert own[acts & sure] == pytest.approx(frame.T[1][acts & sure], abs=ROUNDED * np.abs(frame.T[1]).max())
