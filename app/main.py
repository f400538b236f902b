"""The script that `panel serve app` runs once per visitor."""

from app.page import open_page

open_page()
