"""Renders photographs of a head whose shape and motion are known."""
