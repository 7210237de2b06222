"""Materials and loads from captured motion."""

from elastomorph.fit.fit import fit
from elastomorph.fit.results import CurveFit, Errors, Fit, Ratio

__all__ = ["CurveFit", "Errors", "Fit", "Ratio", "fit"]
