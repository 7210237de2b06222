"""Bends the paths of a character in its own file."""
