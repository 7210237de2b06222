"""Performances in comma-separated text: takes of Live Link Face, or plain columns with a time."""

from elastomorph.io.performance.columns import (
    read_performance,
    read_performance_csv,
    write_performance_csv,
)
from elastomorph.io.performance.livelink import read_livelink

__all__ = ["read_livelink", "read_performance", "read_performance_csv", "write_performance_csv"]
