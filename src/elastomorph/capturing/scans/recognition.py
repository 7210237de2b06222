"""Whether what a template was drawn onto is such a face: it lies closely on anything."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from elastomorph.capturing.geometry.similarity import fit_similarity
from elastomorph.capturing.scans.nonrigid import Elastic
from elastomorph.capturing.scans.trust import Trust
from elastomorph.errors import CaptureError

Points = NDArray[np.float64]

# A face of which the scan shows less than this was not found in it.
_SHOWN = 0.3
# Cosine between the normals of template and person, on average: above .97 for other people's faces
# and about .7 for balls and boxes.
_ALIKE = 0.8


def require_shown(trust: Trust, elastic: Elastic, name: str) -> None:
    """Refuse a scan that the template could not be drawn onto."""
    shown = float(trust.shown[elastic.outer].mean())
    if shown < _SHOWN:
        raise CaptureError(
            f"{name} shows {shown:.0%} of the template, expected at least {_SHOWN:.0%}: it is no"
            " such face, or its landmarks are not where the template has them"
        )


def require_alike(elastic: Elastic, vertices: Points, name: str) -> None:
    """Refuse a first scan that the template lies on, but as no face does."""
    laid = fit_similarity(elastic.rest[elastic.outer], vertices[elastic.outer])
    before = elastic.normals(elastic.rest) @ laid.rotation.T
    cosines = np.einsum("ij,ij->i", before, elastic.normals(vertices))
    alike = float(cosines[elastic.outer].mean())
    if alike < _ALIKE:
        raise CaptureError(
            f"{name} is not shaped like the template, whose normals had to turn by"
            f" {np.degrees(np.arccos(alike)):.0f}° on average: it is no such face, or its landmarks"
            " are not where the template has them"
        )
