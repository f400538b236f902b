"""Draw the small pictures of the row of experiments, from the solver's own runs.

    python docs/row.py

Writes an SVG for each preset that the row shows, NAME.svg in app/features/presets/row: the friction over the
displacement of the top
(the load over the depth where nothing slides), and the contact area below it, each to a scale of its own.
The page includes them as text, so its style sheets colour them.
"""

import itertools
from pathlib import Path

from solver import load_path
from solver.presets import presets
from solver.run.load_steps import lifts

PLACE = Path(__file__).parents[1] / "app" / "features" / "presets" / "row"
WIDE, HIGH, EDGE = 240, 128, 6  # units of a picture, whole numbers: a quarter of a pixel of the page
BAND = 0.4  # of the height, for the area


def curves(scene):
    """(along, force, area): F over U_x, or L over delta, of a run after its approach, where slips begin as well."""
    load, force = ("delta", "L_bar") if lifts(scene) else ("U_x", "F_bar")
    rows = []
    for frame in load_path(scene):
        if frame.stage != "approach":
            rows += [(slip.load, getattr(slip, force), slip.A_bar) for slip in frame.slips]
            rows.append((getattr(frame, load), getattr(frame, force), frame.A_bar))
    return zip(*rows, strict=True)


def path(points):
    """A path through points, in steps from one to the next; a level stretch is one step."""
    whole = [(round(x), round(y)) for x, y in points]
    inner = zip(whole, whole[1:], whole[2:], strict=False)
    kept = [whole[0], *(b for a, b, c in inner if not a[1] == b[1] == c[1]), whole[-1]]
    steps = [(b[0] - a[0], b[1] - a[1]) for a, b in itertools.pairwise(kept)]
    return f"M{kept[0][0]} {kept[0][1]}l" + " ".join(f"{dx} {dy}" for dx, dy in steps if (dx, dy) != (0, 0))


def picture(along, force, area):
    """The SVG of curves; the area of a path that goes one way only."""
    low, high, largest = min(0.0, *force), max(0.0, *force), max(area) or 1.0
    start, length = min(along), (max(along) - min(along)) or 1.0
    x = [EDGE + (value - start) / length * (WIDE - 2 * EDGE) for value in along]
    y = [HIGH - EDGE - (value - low) / ((high - low) or 1.0) * (HIGH - 2 * EDGE) for value in (0.0, *force)]
    top = [HIGH * (1.0 - BAND * value / largest) for value in area]
    one_way = all(a <= b for a, b in itertools.pairwise(along))
    filled = f'<path class="area" d="{path(zip(x, top, strict=True))}V{HIGH}H{EDGE}Z"/>' if one_way else ""
    zero = f'<path class="zero" d="M0 {round(y[0])}H{WIDE}"/>'
    curve = f'<path class="force" d="{path(zip(x, y[1:], strict=True))}"/>'
    return f'<svg class="picture" viewBox="0 0 {WIDE} {HIGH}" aria-hidden="true">{filled}{zero}{curve}</svg>\n'


def main():
    PLACE.mkdir(exist_ok=True)
    for preset in presets().values():
        if preset.short:
            (PLACE / f"{preset.name}.svg").write_text(picture(*curves(preset.scene)), encoding="utf-8")


if __name__ == "__main__":
    main()
