"""The sculptor of the built-in head: volumes, a layout of polygons on them, and what moves them."""
