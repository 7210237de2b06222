"""Scans become meshes with the vertices of a template."""
