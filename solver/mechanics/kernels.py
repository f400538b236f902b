"""Compiled functions of the contact: law, layer, residual and force.

All of them stand here because Numba's cache looks at the file of a caller only (see `continuation.vectors`).
Loops over nodes hold no branch and no call that remains, so that they compile to vector instructions.
`residual` and `force` are called by address from the loops of `continuation`. A Callback holds their address and data.
"""

import numpy as np
from numba import carray

from ..continuation.compiled import address_of, call, kernel, pointer

DEEPEST = -50.0  # dn/delta_n: deeper nodes, which occur in iterates only, count as this deep; exp(50) is finite
# dn/delta_n: nodes farther away count as this far. They pull with 1e-24 of the strength, and no product of two such
# numbers leaves the range of double precision, where arithmetic is slow
REMOTEST = 60.0
FARTHEST = 700.0  # argument of exp, beyond which a number of double precision is out of range soon
WORK = 10  # rows of the scratch array `work`
LOG2_E = 1.4426950408889634
# ln 2 in two parts: the first has so few digits that its product with a whole number up to 1,100 is exact
LN2, LN2_REST = 6.93147180369123816490e-01, 1.90821492927058770002e-10
ROUNDING = 6755399441055744.0  # 1.5 * 2^52: added to a number, it leaves a whole number in the last bits

# The data of a Callback. Addresses are those of arrays as in the kernels; `field`, `spectrum` and `product` belong to a
# `layer.Transform`, and so do the plans; pressure: GPa, held; blocks: of `multiply`
CONTEXT = np.dtype(
    [(name, np.intp) for name in ("first", "size", "count", "held")]
    + [(name, np.intp) for name in ("profile", "law", "work", "blocks", "field", "spectrum", "product")]
    + [(name, np.intp) for name in ("transform", "forward", "transform_back", "backward")]
    + [(name, np.float64) for name in ("x", "z", "scale", "pressure")]
)

_fast = {"contract", "nsz", "arcp"}  # sums are not reordered, and NaN stays NaN


@kernel(fastmath=_fast, error_model="numpy")
def _exp(x):
    """exp(x) for |x| <= 708, to 2e-16 of it; that of the C library would keep loops from vector instructions.

    With x = k ln 2 + r it is 2^k, made of bits, times the series of exp(r), |r| <= 0.35.
    """
    shifted = x * LOG2_E + ROUNDING
    k = shifted - ROUNDING
    r = (x - k * LN2) - k * LN2_REST
    p = 1.0 / 6227020800.0
    p = p * r + 1.0 / 479001600.0
    p = p * r + 1.0 / 39916800.0
    p = p * r + 1.0 / 3628800.0
    p = p * r + 1.0 / 362880.0
    p = p * r + 1.0 / 40320.0
    p = p * r + 1.0 / 5040.0
    p = p * r + 1.0 / 720.0
    p = p * r + 1.0 / 120.0
    p = p * r + 1.0 / 24.0
    p = p * r + 1.0 / 6.0
    p = (p * r + 0.5) * r + 1.0
    p = p * r + 1.0
    return p * np.int64((np.float64(shifted).view(np.int64) + 1023) << 52).view(np.float64)


@kernel(fastmath=_fast, error_model="numpy")
def _sums(u_x, u_z, profile, law, work):
    """Fill rows of work (WORK, m): exp(-dn), sums of 1, dt and dt^2 times exp(-dt^2), and dn, in 0 to 4.

    u_x, u_z, profile: (m,) nm; dt in delta_t, dn in delta_n. Sums run over the sites |dt| <= window_t.
    """
    delta_n, delta_t, a, window, m = law[2], law[3], law[4], law[5], profile.size
    e, s0, s1, s2, dn = work[0], work[1], work[2], work[3], work[4]
    r, up, down, ahead, behind = work[5], work[6], work[7], work[8], work[9]
    shrink = np.exp(-a * a)
    for i in range(m):
        x = u_x[i] / delta_t
        q = x - a * np.floor(x / a + 0.5)  # the distance of the nearest site
        gap = min(max((profile[i] + u_z[i]) / delta_n, DEEPEST), REMOTEST)
        g = _exp(max(-q * q, -FARTHEST))
        ratio = _exp(min(max(2.0 * a * q, -FARTHEST), FARTHEST))
        r[i], dn[i], e[i] = q, gap, _exp(-gap)
        s0[i], s1[i], s2[i], ahead[i], behind[i] = g, -q * g, q * q * g, g, g
        up[i], down[i] = shrink * ratio, shrink / ratio
    shrink *= shrink
    for k in range(1, int((window + 0.5 * a) / a) + 1):
        for i in range(m):
            ahead[i] *= up[i]  # Gaussian of site k ahead from that of site k - 1; up, down: their ratios
            behind[i] *= down[i]
            up[i] *= shrink
            down[i] *= shrink
            front, back = k * a - r[i], k * a + r[i]
            g = ahead[i] if front <= window else 0.0
            h = behind[i] if back <= window else 0.0
            s0[i] += g + h
            s1[i] += front * g - back * h
            s2[i] += front * front * g + back * back * h


@kernel(fastmath=_fast, error_model="numpy")
def tractions(u_x, u_z, profile, law, work, T_x, T_z) -> None:
    """Fill T_x and T_z, as `cohesive_law.tractions`."""
    _sums(u_x, u_z, profile, law, work)
    normal, shear, c = law[0], law[1], law[6]
    e, s0, s1, dn = work[0], work[1], work[2], work[4]
    for i in range(T_x.size):
        T_x[i] = shear * s1[i] * (1.0 + c * dn[i]) * e[i]
        T_z[i] = -normal * dn[i] * s0[i] * e[i]


@kernel(fastmath=_fast, error_model="numpy")
def _slopes(work, law, i):
    """The tangents of node i, rows as of `cohesive_law.tangents`."""
    normal, shear, delta_n, delta_t, c = law[0], law[1], law[2], law[3], law[6]
    force, s0, s1, s2, dn = work[0, i], work[1, i], work[2, i], work[3, i], work[4, i]
    xx = -shear * (s0 - 2.0 * s2) * (1.0 + c * dn) * force / delta_t
    xz = -shear * s1 * (1.0 - c + c * dn) * force / delta_n
    zx = -normal * dn * 2.0 * s1 * force / delta_t
    return xx, xz, zx, -normal * (1.0 - dn) * s0 * force / delta_n


@kernel(fastmath=_fast, error_model="numpy")
def tangents(u_x, u_z, profile, law, work, out) -> None:
    """Fill out (4, m), as `cohesive_law.tangents`."""
    _sums(u_x, u_z, profile, law, work)
    for i in range(out.shape[1]):
        out[0, i], out[1, i], out[2, i], out[3, i] = _slopes(work, law, i)


@kernel(fastmath=_fast, error_model="numpy")
def stiffest(u_x, u_z, profile, law, work) -> float:
    """The largest sum of the magnitudes of a row of dT/du of any node, GPa/nm; nan if one is."""
    _sums(u_x, u_z, profile, law, work)
    largest, total = 0.0, 0.0
    for i in range(profile.size):
        xx, xz, zx, zz = _slopes(work, law, i)
        x, z = abs(xx) + abs(xz), abs(zx) + abs(zz)
        largest = max(largest, x, z)
        total += x + z
    return largest if np.isfinite(total) else np.nan  # a maximum passes over nan


@kernel
def add_product(J, x, z, out_x, out_z) -> None:
    """As `cohesive_law.add_product`, by rows."""
    for i in range(x.size):
        a, b = x[i], z[i]
        out_x[i] += J[0, i] * a + J[1, i] * b
        out_z[i] += J[2, i] * a + J[3, i] * b


@kernel(fastmath={"contract", "nsz"})
def multiply(spectrum, c) -> None:
    """Multiply spectrum (2, modes) in place by blocks [[xx, i c], [-i c, zz]], c (3, modes) with rows xx, zz, c.

    These are the signs of a compliance: of a stiffness pass -c.
    """
    for k in range(spectrum.shape[1]):
        x, z = spectrum[0, k], spectrum[1, k]
        spectrum[0, k] = complex(c[0, k] * x.real - c[2, k] * z.imag, c[0, k] * x.imag + c[2, k] * z.real)
        spectrum[1, k] = complex(c[1, k] * z.real + c[2, k] * x.imag, c[1, k] * z.imag - c[2, k] * x.real)


@kernel
def respond(transform, forward, field, spectrum, blocks, transform_back, backward, product) -> None:
    """Transform field to spectrum, `multiply` that by blocks, and transform it back to product.

    Arguments but spectrum and blocks are addresses, as in CONTEXT.
    """
    call(transform, forward, field, spectrum.ctypes.data)
    multiply(spectrum, blocks)
    call(transform_back, backward, spectrum.ctypes.data, product)


@kernel
def subtract(v, displaced_x, displaced_z, top_x, top_z, out) -> None:
    """Fill out with R of the nodes, as of `equilibrium`."""
    m = displaced_x.size
    for i in range(m):
        out[i] = top_x + displaced_x[i] - v[i]
        out[m + i] = top_z + displaced_z[i] - v[m + i]


@kernel
def _attract(c, u_x, u_z):
    """Put the tractions of the patch, displaced by u, into the field of the transform; returns T_z."""
    field, m = carray(pointer(c.field), (2, c.count), np.float64), c.size
    T_x, T_z = field[0, c.first : c.first + m], field[1, c.first : c.first + m]
    profile, law = carray(pointer(c.profile), (m,), np.float64), carray(pointer(c.law), (7,), np.float64)
    tractions(u_x, u_z, profile, law, carray(pointer(c.work), (WORK, m), np.float64), T_x, T_z)
    return T_z


def residual(context, v, out) -> None:
    """R of the unknowns at the address v into those at `out`: as `equilibrium.Equilibrium.residual`."""
    c = carray(pointer(context), 1, CONTEXT)[0]
    m, modes = c.size, c.count // 2 + 1
    u, r = carray(pointer(v), (2 * m + c.held,), np.float64), carray(pointer(out), (2 * m + c.held,), np.float64)
    T_z = _attract(c, u[:m], u[m : 2 * m])
    spectrum = carray(pointer(c.spectrum), (2, modes), np.complex128)
    blocks = carray(pointer(c.blocks), (3, modes), np.float64)
    respond(c.transform, c.forward, c.field, spectrum, blocks, c.transform_back, c.backward, c.product)
    product, last = carray(pointer(c.product), (2, c.count), np.float64), c.first + m
    subtract(u, product[0, c.first : last], product[1, c.first : last], c.x, u[2 * m] if c.held else c.z, r)
    if c.held:
        total = 0.0
        for i in range(m):
            total += T_z[i]
        r[2 * m] = c.scale * (total / c.count - c.pressure)


def force(context, y, out) -> None:
    """T + K U of the coordinates at the address y into the spectrum, which is at `out`: as `surface.Surface.force`."""
    c = carray(pointer(context), 1, CONTEXT)[0]
    modes = c.count // 2 + 1
    spectrum = carray(pointer(out), (2, modes), np.complex128)
    coordinates, part = carray(pointer(y), (2, modes), np.complex128), 1.0 / c.count
    for k in range(modes):
        spectrum[0, k] = part * coordinates[0, k]
        spectrum[1, k] = part * coordinates[1, k]
    call(c.transform_back, c.backward, out, c.product)
    product, last = carray(pointer(c.product), (2, c.count), np.float64), c.first + c.size
    _attract(c, product[0, c.first : last], product[1, c.first : last])
    call(c.transform, c.forward, c.field, out)
    spectrum[0, 0] += c.x
    spectrum[1, 0] += c.z


class Callback:
    """`residual` or `force` of a contact as a function to be called by address, with its data.

    Attributes: data, (1,) of CONTEXT; addresses, of the function and of the data. It keeps the arrays.
    """

    def __init__(self, function, contact, transform, first, blocks, **numbers):
        arrays = {"profile": contact.profile, "law": contact.law, "work": contact.work, "blocks": blocks}
        arrays |= {name: getattr(transform, name) for name in ("field", "spectrum", "product")}
        self.data, self._kept = np.zeros(1, CONTEXT), (arrays, transform)
        values = {name: array.ctypes.data for name, array in arrays.items()} | transform.plans.addresses | numbers
        values |= {"first": first, "size": contact.size, "count": contact.nodes}
        for name, value in values.items():
            self.data[name] = value
        self.addresses = address_of(function), self.data.ctypes.data
        self._x, self._z = self.data["x"], self.data["z"]

    def at(self, x, z) -> tuple[int, int]:
        """The `addresses`, with these numbers in the data."""
        self._x[0], self._z[0] = x, z
        return self.addresses
