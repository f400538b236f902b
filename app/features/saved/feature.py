"""A saved run: the page with one computed run, in an HTML file without a server. Needs stored."""

from typing import Any

from app import interface


class Feature(interface.Feature):
    """`Stage(result).save(path)` writes it, and notebooks show it."""

    ORDER = 2
    ALONE = True

    @classmethod
    def page_of(cls, result: Any, title: str) -> str:
        from app.features.saved import file  # needs the page, which needs all features

        return file.page_of(result, title)
