"""The animations of a document with the weights of bends, so that its clips play bent."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from elastomorph.bending.additions import Additions
from elastomorph.bending.keys import Columns
from elastomorph.io.gltf.container import GltfFile


class ClipEdit:
    """The animations of a document that weights of bends are added to."""

    def __init__(self, file: GltfFile, document: dict[str, Any], additions: Additions) -> None:
        self._file, self._document, self._additions = file, document, additions
        self.clips = 0
        self.added_keys = 0
        self.error = 0.0

    def extend(self, columns: Mapping[int, Columns], tolerance: float) -> None:
        """Extend every channel of weights of the meshes that got bends."""
