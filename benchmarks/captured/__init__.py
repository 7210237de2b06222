"""Judges registered poses by the truth of rendered photographs; shares nothing with the package."""
