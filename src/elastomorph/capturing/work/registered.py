"""Poses that were registered: meshes that know how far each vertex is to be trusted."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from elastomorph.errors import MeshError
from elastomorph.evaluation.confidence import LEAST
from elastomorph.model.mesh import Mesh, require_mesh
from elastomorph.model.polygons import Polygons
from elastomorph.numbers import as_numbers

FLAGGED = LEAST
"""Below this confidence the error of a vertex is expected to be above 0.5 % of D."""


class Registered(Mesh):
    """A pose with the vertices, polygons and labels of the template.

    Attributes:
        confidence: (V,) float32 in [0, 1], read-only; below 0.5 a vertex is flagged: its error is
            expected to be above 0.5 % of D.
        figures: What was measured while it was made, by name; numbers, texts, lists and mappings.
    """

    confidence: NDArray[np.float32]
    figures: Mapping[str, Any]

    def __init__(
        self,
        vertices: ArrayLike,
        faces: Polygons | ArrayLike | Sequence[Sequence[int]] = (),
        *,
        confidence: ArrayLike,
        figures: Mapping[str, Any] | None = None,
        **labels: Any,
    ) -> None:
        super().__init__(vertices, faces, **labels)
        own = _checked(confidence, len(self.vertices))
        vars(self).update(confidence=own, figures=dict(figures or {}))

    @classmethod
    def of(
        cls,
        template: Mesh,
        vertices: ArrayLike,
        confidence: ArrayLike,
        figures: Mapping[str, Any] | None = None,
    ) -> Registered:
        """The template at other positions.

        Args:
            template: Gives polygons, texture coordinates, materials and groups.
            vertices: (V, 3), in the units of the template.
            confidence: (V,) in [0, 1].
            figures: What was measured.

        Raises:
            MeshError: Another number of vertices or confidences, or a confidence out of [0, 1].
        """
        require_mesh(template, "template")
        moved = template.with_vertices(vertices)
        own = _checked(confidence, len(moved.vertices))
        copy = object.__new__(cls)
        vars(copy).update(vars(moved), confidence=own, figures=dict(figures or {}))
        return copy

    def measured(self, **more: Any) -> Registered:
        """The same with more figures."""
        return Registered.of(self, self.vertices, self.confidence, {**self.figures, **more})

    @property
    def flagged(self) -> NDArray[np.bool_]:
        """(V,) which vertices are not to be trusted: those of a confidence below 0.5."""
        return self.confidence < FLAGGED

    def __repr__(self) -> str:
        share = np.mean(self.flagged)
        return (
            f"Registered({len(self.vertices):,} vertices, {len(self.faces):,} polygons, "
            f"{share:.1%} flagged)"
        )


def _checked(confidence: ArrayLike, count: int) -> NDArray[np.float32]:
    """A read-only copy of (V,) numbers in [0, 1]."""
    own = as_numbers(confidence, "confidence").astype(np.float32)
    if own.shape != (count,):
        raise MeshError(f"confidence must have shape ({count},), found {own.shape}")
    if not ((own >= 0) & (own <= 1)).all():
        raise MeshError("confidence must be between 0 and 1")
    own.flags.writeable = False
    return own
