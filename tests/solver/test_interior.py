"""Displacement and stress inside the layer."""

import mpmath
import numpy as np
import pytest
from exact_interior import inside, mean_stress, principal_difference, transfer
from helpers import tractions

from solver import Scene
from solver.mechanics.layer import Convolution, Modes

LOAD = (3.0, -2.0)
ORIGIN = (0.0, 0.0)


def thickness(scene):
    return scene.height * scene.width


# Elasticity


def residuals(scene, traction, step):
    """Largest residuals of div sigma = 0 (GPa/nm) and of Hooke's law (GPa) at some points, by central differences."""
    G, nu = scene.shear_modulus, scene.nu
    lame, worst = 2.0 * G * nu / (1.0 - 2.0 * nu), np.zeros(2)
    stencil = step * np.arange(-1.0, 2.0)
    for x, z in ((11.0, 9.0), (27.3, 14.0), (40.0, 21.0)):
        body = inside(scene, 0, traction, LOAD, x + stencil, z + stencil)
        (xx, zz, xz), (u_x, u_z) = body.stress, body.u

        def along_x(f):
            return (f[1, 2] - f[1, 0]) / (2.0 * step)

        def along_z(f):
            return (f[2, 1] - f[0, 1]) / (2.0 * step)

        e_xx, e_zz, e_xz = along_x(u_x), along_z(u_z), 0.5 * (along_z(u_x) + along_x(u_z))
        volume = lame * (e_xx + e_zz)
        div = along_x(xx) + along_z(xz), along_x(xz) + along_z(zz)
        hooke = volume + 2 * G * e_xx - xx[1, 1], volume + 2 * G * e_zz - zz[1, 1], 2 * G * e_xz - xz[1, 1]
        worst = np.maximum(worst, (np.abs(div).max(), np.abs(hooke).max()))
    return worst


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.45, 0.499])
@pytest.mark.parametrize("nodes", [24, 25])
def test_stress_is_in_equilibrium_and_obeys_hooke_at_the_order_of_the_difference(nodes, nu):
    """Central differences err by step^2: halved, a quarter is left, to (q step)^2/20 = 1e-3 of the next order."""
    scene = Scene(nodes=nodes, width=2.4 * nodes, height=0.5, nu=nu)
    coarse, fine = (residuals(scene, tractions(nodes), step) for step in (0.1, 0.05))
    assert coarse / fine == pytest.approx(4.0, rel=1e-3)
    # small beside stresses of 0.1 .. 1 GPa; Hooke's law makes 1/(1 - 2 nu) times the error of the volume of it
    assert fine[0] < 1e-5 and fine[1] < 1e-5 / (1.0 - 2.0 * nu)


@pytest.mark.parametrize("nodes", [64, 65])
@pytest.mark.parametrize("height", [0.01, 1.0, 100.0])
def test_surface_tractions_are_recovered(nodes, height):
    """sigma_xz = -T_x and sigma_zz = -T_z at every node, Nyquist's mode included, none outside the patch."""
    scene = Scene(nodes=nodes, width=2.4 * nodes, height=height)
    body = inside(scene, 17, tractions(20), LOAD, scene.x, [0.0])
    expected = np.zeros((2, nodes))
    expected[:, 17:37] = tractions(20)
    # sums of 33 modes of order one
    assert -body.stress[[2, 1], 0] == pytest.approx(expected, abs=1e-13)


@pytest.mark.parametrize("nodes", [64, 65])
@pytest.mark.parametrize("nu", [0.0, 0.45, 0.4999])
@pytest.mark.parametrize("height", [0.01, 1.0, 100.0])
def test_surface_moves_by_load_and_compliance(nodes, nu, height):
    """u = U + C T at every node as the solver has it, Nyquist's mode included, to round-off of the sums."""
    scene = Scene(nodes=nodes, width=2.4 * nodes, height=height, nu=nu)
    layer = Convolution(Modes.of(scene), nodes)
    layer.field[:] = tractions(nodes)
    layer.apply()
    u = inside(scene, 0, tractions(nodes), LOAD, scene.x, [0.0]).u[:, 0]
    expected = layer.product + np.array(LOAD)[:, None]
    assert u == pytest.approx(expected, abs=1e-13 * np.abs(expected).max())


def test_surface_inside_a_frame_is_the_surface_of_the_frame(frame):
    scene, last = frame
    nodes = scene.x[last.first : last.first + last.T.shape[1]]
    u = inside(scene, last.first, last.T, (last.U_x, -last.delta), nodes, [0.0]).u[:, 0]
    # the frame's residual is the distance of the two
    assert u == pytest.approx(last.u, abs=1.01 * scene.tolerance)


@pytest.mark.parametrize("height", [0.01, 0.3, 1.0, 100.0])
def test_layer_is_clamped_at_its_top(height):
    scene = Scene(nodes=64, width=160.0, height=height)
    body = inside(scene, 0, tractions(64), LOAD, scene.x, [thickness(scene)])
    assert (body.u == np.array(LOAD)[:, None, None]).all()


def test_uniform_traction_shears_and_compresses_the_layer_evenly():
    scene = Scene(nodes=16, width=40.0, nu=0.3)
    G, h, z = scene.shear_modulus, thickness(scene), np.linspace(0.0, 40.0, 5)
    body = inside(scene, 0, np.outer((0.5, 2.0), np.ones(16)), LOAD, [3.0], z)
    assert body.u[0, :, 0] == pytest.approx(3.0 + 0.5 * (h - z) / G, rel=1e-13, abs=0.0)
    assert body.u[1, :, 0] == pytest.approx(-2.0 + 2.0 * (h - z) * 0.4 / (1.4 * G), rel=1e-13, abs=0.0)
    # no lateral strain: sigma_xx = nu/(1-nu) sigma_zz
    assert body.stress[:, :, 0] == pytest.approx(
        np.outer((-2.0 * 0.3 / 0.7, -2.0, -0.5), np.ones(5)), rel=1e-13, abs=0.0
    )


def test_every_level_carries_the_force_on_the_surface():
    """Means over the cell of sigma_zz, sigma_xz do not change with z; sums over 64 points leave out no mode of 32."""
    scene = Scene(nodes=32, width=80.0, height=0.7)
    x, z = np.arange(64) * (80.0 / 64), np.linspace(0.0, thickness(scene), 9)
    body = inside(scene, 0, tractions(32), ORIGIN, x, z)
    T_x, T_z = tractions(32).mean(axis=1)
    assert body.stress[1].mean(axis=1) == pytest.approx(-T_z, abs=1e-14)
    assert body.stress[2].mean(axis=1) == pytest.approx(-T_x, abs=1e-14)


def test_mean_stress_is_the_trace_in_plane_strain():
    stress = np.array([1.0, 2.0, 7.0])
    assert mean_stress(stress, 0.3) == pytest.approx((1.0 + 2.0 + 0.3 * 3.0) / 3.0, rel=1e-15, abs=0.0)


def test_principal_difference_is_that_of_the_eigenvalues():
    xx, zz, xz = tractions(3)[0]
    low, high = np.linalg.eigvalsh([[xx, xz], [xz, zz]])
    assert principal_difference(np.array([xx, zz, xz])) == pytest.approx(high - low, rel=1e-14, abs=0.0)


# Half-plane under a Hertz pressure


def hertz(x, z, a):
    """sigma_xx, sigma_zz, sigma_xz per p0 (McEwen 1949; Johnson, Contact Mechanics, 1985, Eq. 4.49)."""
    root = np.sqrt((a * a - x * x + z * z) ** 2 + 4.0 * x * x * z * z)
    m = np.sqrt(0.5 * (root + (a * a - x * x + z * z)))
    n = np.sign(x) * np.sqrt(np.maximum(0.5 * (root - (a * a - x * x + z * z)), 0.0))
    part = (z * z + n * n) / (m * m + n * n)
    shear = -n * (m * m - z * z) / (m * m + n * n)
    return np.array([2.0 * z - m * (1.0 + part), -m * (1.0 - part), shear]) / a


def confinement(scene, a):
    """The bonded top forbids the mean strain along x that a free half-plane has: a uniform sigma_xx, per p0."""
    mean_pressure = 0.5 * np.pi * a / scene.width
    return mean_pressure * (1.0 - scene.nu / (1.0 - scene.nu))


def test_a_deep_layer_is_stressed_as_a_half_plane_under_hertz_pressure(pressed):
    """2e-3 p0: sampled at 128 intervals, the pressure's steep ends lack 7e-4 of the load; its images add 1e-4."""
    scene, first, T, a, middle = pressed
    across, down = np.array([-2.0, -1.2, -0.7, -0.2, 0.0, 0.5, 0.9, 1.6]) * a, np.linspace(0.1, 2.5, 13) * a
    body = inside(scene, first, T, ORIGIN, middle + across, down)
    expected = hertz(across[None, :], down[:, None], a)
    expected[0] += confinement(scene, a)
    assert np.abs(body.stress - expected).max() < 2e-3


def test_largest_shear_under_hertz_pressure_is_0_30_at_0_78_below_the_surface(pressed):
    """sigma_1 - sigma_2 = 0.60 p0; the uniform sigma_xx of the confinement, 1e-3 p0, is taken off."""
    scene, first, T, a, middle = pressed
    z = np.linspace(0.6, 1.0, 401) * a
    stress = inside(scene, first, T, ORIGIN, [middle], z).stress[:, :, 0]
    stress[0] -= confinement(scene, a)
    largest = 0.5 * principal_difference(stress)
    assert largest.max() == pytest.approx(0.300, abs=1e-3)
    assert z[largest.argmax()] / a == pytest.approx(0.786, abs=0.01)  # flat: 1e-4 of the value 0.01 away


# Floating point


def exact(q, z, h, G, nu):
    """`transfer` of one mode in 40 digits, (5, 2): four waves decaying from either side, fitted to both sides."""
    with mpmath.workdps(40):
        q, z, h, G, nu = (mpmath.mpf(float(v)) for v in (q, z, h, G, nu))
        kappa, lame = 3 - 4 * nu, 2 * G * nu / (1 - 2 * nu)

        def waves(z):
            n, t = q * z, q * (h - z)
            a, b = mpmath.exp(-n), mpmath.exp(-t)
            f, g = [a, n * a, b, t * b], [-a, -(n + kappa) * a, b, (t + kappa) * b]
            df, dg = [-a, a - n * a, b, t * b - b], [a, (n + kappa - 1) * a, b, (t + kappa - 1) * b]
            f_x, s_xz = [-v for v in f], [G * q * (v + w) for v, w in zip(df, g, strict=True)]
            s_xx = [q * (lame * w + (lame + 2 * G) * v) for v, w in zip(f_x, dg, strict=True)]
            s_zz = [q * ((lame + 2 * G) * w + lame * v) for v, w in zip(f_x, dg, strict=True)]
            return f, g, s_xx, s_zz, s_xz  # u_x/i, u_z, sigma_xx, sigma_zz, sigma_xz/i

        surface, top = waves(mpmath.mpf(0)), waves(h)
        system = mpmath.matrix([surface[4], surface[3], top[0], top[1]])
        by_x = mpmath.lu_solve(system, mpmath.matrix([1, 0, 0, 0]))  # T_x = i: sigma_xz/i = 1
        by_z = mpmath.lu_solve(system, mpmath.matrix([0, -1, 0, 0]))  # T_z = 1
        rows = [[sum(w * c for w, c in zip(row, by, strict=True)) for by in (by_x, by_z)] for row in waves(z)]
        # u_x = i f, sigma_xz alike, and T_x = 1 is -i times T_x = i: even is -f of T_x; for the others odd is g of T_x
        return np.array([(-x, z) if i in (0, 4) else (z, x) for i, (x, z) in enumerate(rows)], float)


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.45, 0.4999])
@pytest.mark.parametrize("y", [1e-6, 1e-3, 0.03, 0.5, 0.99, 1.01, 3.0, 20.0, 1e3, 1e5])
def test_modes_agree_with_forty_digits_at_any_depth(nu, y):
    """Down to e^-50 of the surface's; the round-off of exp(-q z) is q z times that of q z."""
    h, G = 25.0, 27.0
    for z in {0.0, h / 3, 0.9 * h, 0.999 * h, *(v * h / y for v in (0.01, 1.0, 10.0, 50.0) if v < y)}:
        computed = transfer(np.array([y / h]), np.array([z]), h, G, nu)[:, :, 0, 0]
        if y / h * z > 60.0:
            assert np.abs(computed).max() < 1e-20
            continue
        expected = exact(y / h, z, h, G, nu)
        allowed = 1e-14 + 4e-16 * y / h * z
        for part in (slice(0, 2), slice(2, 5)):
            assert np.abs(computed - expected)[part].max() <= allowed * np.abs(expected[part]).max()
        # an incompressible layer hardly gives way: its u_z is small beside u_x, and keeps its digits
        if z == 0.0:
            assert computed[1, 0] == pytest.approx(expected[1, 0], rel=1e-14, abs=0.0)


@pytest.mark.parametrize("nu", [0.0, 0.45, 0.4999])
@pytest.mark.parametrize("height", [0.01, 1.0, 100.0])
def test_stress_is_finite_and_bounded_in_the_most_extreme_layers(height, nu):
    """q h up to 5e6; tractions of some size cause no stress beyond a few times it (Gibbs: near the surface)."""
    scene = Scene(nodes=16384, width=16384 * 2.4, height=height, nu=nu)
    T, h = np.ones((2, 300)), thickness(scene)
    with np.errstate(over="raise", invalid="raise"):
        body = inside(scene, 100, T, LOAD, [0.0, 100.0, 900.0], np.array([0.0, 1e-9, 1e-3, 0.5, 1.0]) * h)
    assert np.isfinite(body.u).all() and np.abs(body.stress).max() < 5.0
