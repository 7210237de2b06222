"""Paths from a neutral to a target, one file a method."""

from elastomorph.paths.interpolate import interpolate, prepare
from elastomorph.paths.method import METHODS, Method
from elastomorph.paths.through import through

__all__ = ["METHODS", "Method", "interpolate", "prepare", "through"]
