"""A report as a page of its own: Bokeh's figures and pandas' tables, everything inline, no server, no network."""

from html import escape
from pathlib import Path

CSS = """
body { font: 15px/1.45 system-ui, sans-serif; color: #222; background: #fff; max-width: 1120px; margin: 24px auto }
h1 { font-size: 21px; margin: 0 0 4px }
h2 { font-size: 16px; margin: 22px 0 2px }
code { background: #f2f2f2; padding: 2px 5px }
table { border-collapse: collapse; margin: 6px 0 }
td, th { padding: 2px 12px 2px 0; text-align: right; vertical-align: top; font-variant-numeric: tabular-nums }
td:first-child, th:first-child, .words td { text-align: left }
.meaning { font-weight: 600 }
.notes { color: #555; font-size: 13px }
"""


def write_page(file, title, *parts):
    """Write parts, HTML text or Bokeh models, one below the other; raises OSError."""
    from bokeh.embed import components  # which a caller of `run` does not need
    from bokeh.settings import settings

    # as INLINE, but without the widgets, and without what other packages in this process register with it
    library = (Path(settings.bokehjs_path()) / "js" / "bokeh.min.js").read_text(encoding="utf-8")
    script, places = components([part for part in parts if not isinstance(part, str)])
    places = iter(places)
    body = "\n".join(part if isinstance(part, str) else next(places) for part in parts)
    with open(file, "w", encoding="utf-8") as out:
        out.write(
            f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><title>{escape(title)}</title>\n'
            f"<style>{CSS}</style><script>{library}</script></head><body>\n{body}\n{script}</body></html>\n"
        )


def table(frame, classes=None):
    """A DataFrame as an HTML table."""
    return frame.to_html(index=False, border=0, classes=classes)


def items(lines):
    """Lines of text as an HTML list in small print."""
    return f'<ul class="notes">{"".join(f"<li>{escape(line)}</li>" for line in lines)}</ul>'
