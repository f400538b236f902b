"""The page of the interface law in Chromium."""

import numpy as np
import pytest

from solver import Scene, release_rates, simulate
from solver.mechanics import cohesive_law

thorough = pytest.mark.thorough


DRAWN = {  # page: condition that its result is drawn
    "law": "(charts.law_shear_map?.parts.stick.x.length > 50 && document.getElementById('law-stick').textContent)",
    "load": "(parseInt(document.getElementById('load-count').textContent) > 0)",
    "matters": "(document.querySelectorAll('#matters-bars button').length > 5)",
    "regimes": "document.getElementById('regimes-text').textContent.includes(' points')",  # its first tile
}


def test_edges_on_the_toughness_are_those_of_the_solver(visit):
    """Within the rounding of the fields that a browser receives."""
    page = visit("?page=law&k=180")
    frame = simulate(Scene(u_x_max=8.0)).frames[180]
    for label, edge in zip(("trailing", "leading"), release_rates(frame), strict=True):
        part = f"charts.law_toughness?.parts.{label}"
        page.wait_for_function(f"() => {part}?.x.length && punch.drawn === 180")
        shown = page.evaluate(f"() => [{part}.y[0], {part}.x[0]]")
        assert shown == pytest.approx([edge.J, np.degrees(edge.psi)], rel=5e-3)


def test_the_law_is_that_of_the_solver(look):
    """The browser draws it from the law that its states follow: maps, where sticking ends, and both curves."""
    scene = Scene(phi_ratio=0.3, law="xu-needleman")
    page = look("?page=law&phi_ratio=0.3&law=xu-needleman&u_x_max=4")
    page.wait_for_function(f"() => {DRAWN['law']}")
    for name, sign, part in (("shear", -1.0, 0), ("normal", 1.0, 1)):
        shown = page.evaluate(
            """(name) => {
                const { x, wide, y, high, columns, rows, values } = charts[`law_${name}_map`].parts.map
                return { x, wide, y, high, columns, rows, values: [...values] }
            }""",
            name,
        )
        values = np.reshape(shown["values"], (shown["rows"], shown["columns"]))
        s = shown["x"] + shown["wide"] * (np.arange(shown["columns"]) + 0.5) / shown["columns"]
        gap = shown["y"] + shown["high"] * (np.arange(shown["rows"]) + 0.5) / shown["rows"]
        expected = sign * cohesive_law.traction(scene, *np.meshgrid(s, gap))[part]
        np.testing.assert_allclose(values, expected, rtol=1e-4, atol=1e-5 * np.abs(expected).max())
        assert shown["x"] == -0.5 * scene.spacing and shown["y"] == -scene.delta_n
    s, rise = page.evaluate("(({ x, y }) => [[...x], [...y]])(charts.law_shear_law.parts.law)")
    expected = -cohesive_law.traction(scene, np.array(s), 0.0)[0] * scene.delta_t / scene.phi_t
    np.testing.assert_allclose(rise, expected, atol=1e-5)
    gap, pull = page.evaluate("(({ x, y }) => [[...x], [...y]])(charts.law_normal_law.parts.law)")
    over = cohesive_law.traction(scene, 0.0, np.array(gap))[1] / cohesive_law.traction(scene, 0.0, scene.delta_n)[1]
    np.testing.assert_allclose(pull, -over / np.e, atol=1e-9)


@thorough
def test_nodes_lie_on_the_curve_of_the_interface_law_and_stick_before_its_peak(look):
    page = look("?page=law")
    page.wait_for_function(f"() => {DRAWN['law']}")
    distance, stuck, slipping, peak = page.evaluate(
        """() => {
            const { law, stick, slip } = charts.law_shear_law.parts
            const at = (s) => {
                const part = (s - law.x[0]) / (law.x[1] - law.x[0]), i = Math.min(Math.floor(part), law.x.length - 2)
                return law.y[i] + (part - i) * (law.y[i + 1] - law.y[i])
            }
            const shown = [...stick.x.keys()].filter((i) => stick.y[i] === stick.y[i]), { abs, exp, max, min } = Math
            const gap = charts.law_normal_law.parts.stick.x // a rounded traction is divided by exp(-gap)
            const off = (i) => abs(stick.y[i] - at(stick.x[i])) * exp(-gap[i])
            return [shown.length > 0.8 * stick.x.length && max(...shown.map(off)),
                max(...stick.x.map(abs)), min(...slip.x.map(abs)), abs(law.x[law.y.indexOf(max(...law.y))])]
        }"""
    )
    assert 0.0 < distance < 0.03  # u_x comes to packing.CLOSE, twice, and tractions to packing.FINE
    assert stuck <= peak < slipping and 0.5 < peak < 0.71  # 1/sqrt(2) for one spring, less for a lattice


@thorough
def test_maps_of_the_law_have_a_scale_and_a_legend_for_their_nodes(look):
    page = look("?page=law")
    page.wait_for_function(f"() => {DRAWN['law']}")
    for name in ("shear", "normal"):
        high = float(page.inner_text(f"#law_{name}_map-high").strip("+ GPa"))
        assert high == pytest.approx(
            page.evaluate(f"charts.law_{name}_map.parts.map.limits[1]"), rel=0.05
        )  # two digits
    assert "past the peak" in page.inner_text("#law")
    style = "getComputedStyle(document.querySelector('.key .{}')).backgroundColor"
    assert page.evaluate(style.format("stick")) != page.evaluate(style.format("repulsive"))
    numbers = [int(page.inner_text(f"#law-{state}")) for state in ("stick", "slip", "open")]
    assert sum(numbers) == page.evaluate("punch.run.frame(punch.drawn).x.length")
    assert numbers[-1] == page.evaluate("charts.punch.parts.free.x.length")
    right = page.evaluate("[...charts.law_shear_map.parts.map.values].filter((_, i) => i % 160 === 159)")
    assert min(right) > 0.0  # up to half a spacing ahead of a site the law pulls back
