"""The page "Accuracy" in a browser: its sliders and entries, which all research pages have."""

from app.session.controls import CONTROLS

QUICK = "?lab=accuracy&nodes=64&width=160&radius=0.6&u_x_max=12&du_x=0.2&du_z=0.5&E=35"


HANDLES = """() => {
    const found = {}
    const visit = (root) => {
        for (const e of root.querySelectorAll("*")) {
            if (e.matches(".noUi-handle")) found[e.getAttribute("aria-label")] = e.getAttribute("aria-valuetext")
            if (e.shadowRoot) visit(e.shadowRoot)
        }
    }
    visit(document)
    return found
}"""


def test_sliders_and_entries_move_each_other_and_the_scene_with_names_that_come_back_when_rendered_again(visit):
    page = visit(QUICK, rests=False)
    are = f"(wanted) => JSON.stringify(({HANDLES})()) === JSON.stringify(wanted)"
    positions = {control.name: control.positions for control in CONTROLS}
    nearest = min(positions["E"], key=lambda E: abs(E - 35))
    shown = {"Press depth δ/δ₀": "0", "Friction / adhesion φₜ/φₙ": "1", "Stiffness E (GPa)": f"{nearest:g}"}
    page.wait_for_function(are, arg=shown)
    page.get_by_role("slider", name="Friction / adhesion").press("ArrowRight")
    value = f"{positions['phi_ratio'][positions['phi_ratio'].index(1.0) + 1]:g}"  # those of the experiment
    page.locator(f"a[href*='phi_ratio={value}']").wait_for()
    entries = [page.get_by_role("textbox", name=name) for name in ("Friction / adhesion", "Stiffness")]
    assert [entry.input_value() for entry in entries] == [value, "35"]
    shown["Friction / adhesion φₜ/φₙ"] = value
    stiffest = shown["Stiffness E (GPa)"] = f"{positions['E'][-1]:g}"
    entries[1].fill(stiffest)
    entries[1].press("Enter")
    page.locator(f"a[href*='E={stiffest}']").wait_for()
    page.wait_for_function(are, arg=shown)
    page.get_by_role("slider", name="Press depth").press("ArrowRight")
    shown["Press depth δ/δ₀"] = "0.01"
    page.wait_for_function(are, arg=shown)
    page.evaluate(
        """() => [...Bokeh.documents[0]._all_models.values()].filter(({ end, step }) => end > 100 && step === 1)
            .forEach((slider) => Bokeh.index.find_one(slider).rerender())"""
    )
    page.wait_for_function(are, arg=shown)
