"""The terms of the field that are explained where they appear; static/glossary.html declares them."""

import re
from functools import cache
from pathlib import Path

FILE = Path(__file__).parent / "static" / "glossary.html"
TERM = re.compile(r'id="term-(\w+)" data-forms="([^"]+)"')


@cache
def forms():
    """{form of a word, as it stands in the page: term}, the longest first."""
    found = {
        form.replace("~", " "): term
        for term, words in TERM.findall(FILE.read_text(encoding="utf-8"))
        for form in words.split()
    }
    return dict(sorted(found.items(), key=lambda item: -len(item[0])))
