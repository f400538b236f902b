"""The table from tractions to stress in the layer, for workers."""

from typing import Any

import numpy as np

from solver import Scene
from solver.analysis.interior import transfer, wavenumbers

DECAYED = 12.0  # q z beyond which a mode is negligible: (1 + q z) exp(-q z) is 8e-5


def layer_table(scene: Scene, depth: float, rows: Any, modes: int) -> tuple[list[int], float, bytes]:
    """Return (counts, scale, body): stresses in the layer per mode of the tractions, for `rows` down to `depth`, nm.

    Each row is evaluated at its centre, with its first `counts` modes. body: int16 (sum of counts, 6) in units of
    scale, row by row. Columns: sigma_xx, sigma_zz, sigma_xz of `interior.transfer`, each even then odd.
    """
    q, z = wavenumbers(scene, modes), (np.arange(rows) + 0.5) * (depth / rows)
    counts = 1 + np.searchsorted(q[1:], DECAYED / z, "right")
    height = scene.height * scene.width
    parts = [
        transfer(q[:n], z[r : r + 1], height, 1.0, scene.nu)[2:, :, 0].reshape(6, n).T for r, n in enumerate(counts)
    ]
    factors = np.concatenate(parts)
    scale = float(np.abs(factors).max()) / 32767
    return counts.tolist(), scale, np.rint(factors / scale).astype("<i2").tobytes()
