"""A lost server: the page plays on, and is as it was once the server answers."""

PAGE = True
ORDER = 90
