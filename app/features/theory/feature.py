"""Theory: the model in nine equations, and a glossary, in a dialog."""

ORDER = 30
