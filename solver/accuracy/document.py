"""A report, written once: as text for a terminal, and as an HTML page without server or network."""

from collections.abc import Callable, Sequence
from html import escape
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from pandas import DataFrame

CSS = """
body { font: 15px/1.45 system-ui, sans-serif; color: #222; background: #fff; max-width: 1120px; margin: 24px auto }
h1 { font-size: 21px; margin: 0 0 4px }
h2 { font-size: 16px; margin: 22px 0 2px }
p { margin: 4px 0 }
table { border-collapse: collapse; margin: 6px 0 }
td, th { padding: 2px 12px 2px 0; text-align: left; vertical-align: top; font-variant-numeric: tabular-nums }
"""


class Section(NamedTuple):
    """A heading, a table of text, lines below it; and, on the page, figures side by side, which figures() makes."""

    title: str
    table: "DataFrame | None" = None
    lines: Sequence[str] = ()
    figures: Callable[[], list[Any]] = list  # of Bokeh


def text(title: str, sections: Sequence[Section]) -> str:
    """All but the figures, in lines."""
    parts = [title]
    for section in sections:
        table = [] if section.table is None else [section.table.to_string(index=False, justify="left")]
        parts += ["", *filter(None, [section.title]), *table, *section.lines]
    return "\n".join(parts)


def write_page(file: str | PathLike[str], title: str, sections: Sequence[Section]) -> None:
    """Write the page; raises OSError."""
    from bokeh.embed import components  # `run` does not need it
    from bokeh.layouts import row
    from bokeh.settings import settings

    # INLINE would add the widgets and the resources that other packages of this process have registered
    library = (Path(settings.bokehjs_path()) / "js" / "bokeh.min.js").read_text(encoding="utf-8")
    drawn = [section.figures() for section in sections]
    script, divisions = components([row(figures) for figures in drawn if figures])
    division, body = iter(divisions), []
    for section, figures in zip(sections, drawn, strict=True):
        table = "" if section.table is None else section.table.to_html(index=False, border=0)
        lines = "".join(f"<p>{escape(line)}</p>\n" for line in section.lines)
        heading = f"<h2>{escape(section.title)}</h2>\n" if section.title else ""
        body.append(f"{heading}{next(division) if figures else ''}{table}{lines}")
    page = (
        f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><title>{escape(title)}</title>\n'
        f"<style>{CSS}</style><script>{library}</script></head>\n"
        f"<body><h1>{escape(title)}</h1>\n{''.join(body)}\n{script}</body></html>\n"
    )
    Path(file).write_text(page, encoding="utf-8")
