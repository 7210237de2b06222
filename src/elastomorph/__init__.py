"""Nonlinear blendshapes that run anywhere linear ones do."""
