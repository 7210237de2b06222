"""Every method that a name stands for. A new one is a file beside this one, and a line here."""

from __future__ import annotations

from elastomorph.paths.arc import Arc
from elastomorph.paths.auto import Auto
from elastomorph.paths.beam import Beam
from elastomorph.paths.cosine import Cosine
from elastomorph.paths.ease import Ease
from elastomorph.paths.linear import Linear
from elastomorph.paths.method import Method
from elastomorph.paths.plate import Plate
from elastomorph.paths.rotation import Rotation

Method.known = (
    Linear,
    Cosine,
    Ease,
    Beam,
    Plate,
    Arc,
    Rotation,
    Auto,
)
