"""The command line: one file a verb, no logic of its own."""

from elastomorph.cli.app import app, main

__all__ = ["app", "main"]
