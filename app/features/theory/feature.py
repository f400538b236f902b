"""Theory: the model in nine equations, and a glossary, in a dialog."""

ORDER = 30
PAGE = True  # its texts are files of this server
