"""The surface of the neutral, in the vertices of a template."""
