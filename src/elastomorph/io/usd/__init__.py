"""Universal Scene Description: rigs as UsdSkel blend shapes with in-betweens.

Needs usd-core (``pip install 'elastomorph[usd]'``).
"""

from elastomorph.io.usd.reader import read_usd
from elastomorph.io.usd.writer import BlendShapeReport, UsdReport, write_usd

__all__ = ["BlendShapeReport", "UsdReport", "read_usd", "write_usd"]
