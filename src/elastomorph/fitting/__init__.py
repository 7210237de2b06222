"""Materials and loads from captured motion."""

from elastomorph.fitting.fit import fit
from elastomorph.fitting.results import CurveFit, Errors, Fit, Ratio

__all__ = ["CurveFit", "Errors", "Fit", "Ratio", "fit"]
