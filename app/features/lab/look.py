"""The look of the research pages: colours and type of the experiment, and charts that fill the window."""

import re

from bokeh.themes import Theme

from app.assets import STATIC

TEXT = "14px"  # Panel and Bokeh have 11 to 13 px
# of charts beside each other where there is room for two, which grow where the window leaves more below the sliders
CHART = {"flex": "1 1 420px", "min-height": "calc(100vh - 23rem)"}
HEADING = {"flex-wrap": "wrap", "align-items": "center", "gap": "0 12px"}
CSS = """
:root { %s }
body {
    margin: 0; padding: 4px 8px; background: var(--page); color: var(--text);
    font-family: system-ui, "Segoe UI", Roboto, "Helvetica Neue", Arial, sans-serif;
    --background-color: var(--page); --surface-color: var(--card); --border-color: var(--grid);
    --panel-background-color: var(--page); --panel-on-background-color: var(--text);
    --panel-surface-color: var(--card); --panel-on-surface-color: var(--text);
}
"""


def colours(dark: bool) -> dict[str, str]:
    """Return {name: colour} of the experiment's style sheet, such as {"page": "#ffffff", ...}."""
    blocks = re.findall(r":root(?:\[data-theme=\"dark\"\])? \{(.*?)\}", (STATIC / "style.css").read_text(), re.DOTALL)
    found = [dict(re.findall(r"--([\w-]+): (#\w+)", block)) for block in blocks[:2]]
    return found[0] | (found[1] if dark else {})


def css(dark: bool) -> str:
    """Return the styles of a page."""
    names = "; ".join(f"--{name}: {colour}" for name, colour in colours(dark).items())
    return CSS % f"{names}; color-scheme: {'dark' if dark else 'light'}"


def theme(dark: bool) -> Theme:
    """Return the theme of Bokeh's charts."""
    of = colours(dark)
    text = {f"{part}_text_color": of["text"] for part in ("axis_label", "major_label")}
    lines = dict.fromkeys(("axis_line_color", "major_tick_line_color", "minor_tick_line_color"), of["soft"])
    plain = {"background_fill_color": of["page"]}
    return Theme(
        json={
            "attrs": {
                "Plot": plain | {"border_fill_color": of["page"], "outline_line_color": of["grid"]},
                "Grid": {"grid_line_color": of["grid"]},
                "Axis": text | lines | {"axis_label_text_font_style": "normal"},
                "Legend": plain | {"label_text_color": of["text"], "border_line_color": None},
                "ColorBar": plain | {"major_label_text_color": of["text"], "title_text_color": of["text"]},
                "Title": {"text_color": of["text"]},
            }
        }
    )
