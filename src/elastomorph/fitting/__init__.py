"""Materials, loads and paths from captured motion."""

from elastomorph.fitting.fit import fit
from elastomorph.fitting.learning import Learned, PathErrors, learn
from elastomorph.fitting.results import CurveFit, Errors, Fit, Ratio

__all__ = ["CurveFit", "Errors", "Fit", "Learned", "PathErrors", "Ratio", "fit", "learn"]
