"""A measured profile: a file becomes the surface, after questions about what it does not say. Needs drawer."""
