"""Hostile files for every reader: how they are made, read under measurement and judged."""
