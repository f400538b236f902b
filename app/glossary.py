"""The terms that the page explains where they appear; static/glossary.html declares them."""

import re
from functools import cache
from pathlib import Path

FILE = Path(__file__).parent / "static" / "glossary.html"
TERM = re.compile(r'id="term-(\w+)" data-forms="([^"]+)"')


@cache
def forms() -> dict[str, str]:
    """Return {form of a word in the page: term}, the longest first."""
    found = {
        form.replace("~", " "): term
        for term, words in TERM.findall(FILE.read_text(encoding="utf-8"))
        for form in words.split()
    }
    return dict(sorted(found.items(), key=lambda item: -len(item[0])))
