"""Faces by number: what a recipe says, and the columns of any face."""
