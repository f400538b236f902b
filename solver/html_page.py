"""A report as an HTML page: Bokeh's figures and pandas' tables, everything inline, without server or network."""

from collections.abc import Iterable
from html import escape
from os import PathLike
from pathlib import Path
from typing import Any

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


def write_page(file: str | PathLike, title: str, *parts: Any) -> None:
    """Writes the parts, HTML text or Bokeh models, one below the other; raises OSError."""
    from bokeh.embed import components  # `run` does not need it
    from bokeh.settings import settings

    # INLINE would add the widgets and the resources that other packages of this process have registered
    library = (Path(settings.bokehjs_path()) / "js" / "bokeh.min.js").read_text(encoding="utf-8")
    script, figures = components([part for part in parts if not isinstance(part, str)])
    figures = iter(figures)
    body = "\n".join(part if isinstance(part, str) else next(figures) for part in parts)
    with open(file, "w", encoding="utf-8") as out:
        out.write(
            f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><title>{escape(title)}</title>\n'
            f"<style>{CSS}</style><script>{library}</script></head><body>\n{body}\n{script}</body></html>\n"
        )


def table(frame: Any, classes: str | None = None) -> str:
    """A DataFrame as an HTML table."""
    return frame.to_html(index=False, border=0, classes=classes)


def items(lines: Iterable[str]) -> str:
    """Lines of text as an HTML list in small print."""
    return f'<ul class="notes">{"".join(f"<li>{escape(line)}</li>" for line in lines)}</ul>'
