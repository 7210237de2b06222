"""Universal Scene Description: rigs as UsdSkel blend shapes with in-betweens.

Needs usd-core (``pip install 'elastomorph[usd]'``).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from elastomorph._lazy import lazy_names

if TYPE_CHECKING:
    from elastomorph.io.usd.reader import read_usd
    from elastomorph.io.usd.writer import BlendShapeReport, UsdReport, write_usd

__all__ = ["BlendShapeReport", "UsdReport", "read_usd", "write_usd"]

__getattr__ = lazy_names(
    __name__,
    {"reader": ("read_usd",), "writer": ("BlendShapeReport", "UsdReport", "write_usd")},
)
