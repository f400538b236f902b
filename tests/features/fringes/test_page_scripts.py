"""Stress inside the layer, as the page sums it."""

import base64

import numpy as np
import pytest
from exact_interior import inside, principal_difference
from scripts import SHORT, run_of

from app.features.fringes import tasks
from app.service import packing
from solver import Scene


@pytest.fixture
def finely(monkeypatch):
    """Fields are packed as finely as int16 can, for tests of what is computed from them."""
    monkeypatch.setattr(packing, "FINE", 1e-5)


@pytest.mark.parametrize("scene", [SHORT, SHORT.changed(nu=0.2, height=0.05), Scene(surface="flat", u_x_max=2.0)])
def test_stress_inside_the_layer_equals_the_sum_over_all_modes(tab, scene, finely):
    """To 5e-4 of the largest stress: tractions come as int16, and modes that are not felt at a depth are left out."""
    frame, rows, half = run_of(tab, scene)[-1], 40, 60.0
    depth = min(half, scene.height * scene.width)
    counts, scale, body = tasks.layer_table(scene, depth, rows, scene.nodes // 2)
    assert len(body) == 12 * sum(counts)
    made = tab.evaluate(
        """async ([table, counts, scale]) => {
            const { tableOf, sumsIn, middles, XX, ZZ, XZ, APART, SHEARED } = await import("http://scripts/features/fringes/inside.js")
            const weights = [XX, ZZ, XZ, APART, SHEARED]
            const { buffer: body } = Uint8Array.from(atob(table), (c) => c.charCodeAt(0))
            const sums = sumsIn(run, run.length - 1, tableOf({ counts, scale, body }), middles(50, 60), weights)
            return sums.map((sum) => [...sum])
        }""",
        [base64.b64encode(body).decode(), counts, scale],
    )
    *made, apart, sheared = np.array(made).reshape(-1, rows, 50)
    first, T = (0, np.repeat(frame.T[:, :1], scene.nodes, 1)) if scene.surface == "flat" else (frame.first, frame.T)
    x, z = scene.width / 2 + half * ((np.arange(50) + 0.5) / 25 - 1), (np.arange(rows) + 0.5) * (depth / rows)
    true = inside(scene, first, T, (0.0, 0.0), x, z)
    assert np.array(made) == pytest.approx(true.stress, abs=5e-4 * np.abs(true.stress).max())
    exact = principal_difference(true.stress)
    assert np.hypot(apart, sheared) == pytest.approx(exact, abs=5e-4 * exact.max())
