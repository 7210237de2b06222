"""Performances in files: takes of Live Link Face, plain columns, arrays, clips of glTF."""

from elastomorph.io.performance.columns import read_performance_csv, write_performance_csv
from elastomorph.io.performance.files import read_performance, write_performance
from elastomorph.io.performance.livelink import read_livelink

__all__ = [
    "read_livelink",
    "read_performance",
    "read_performance_csv",
    "write_performance",
    "write_performance_csv",
]
