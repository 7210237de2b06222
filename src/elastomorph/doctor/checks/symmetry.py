"""Left and right targets: are they mirror images, and on the side their names say?"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from elastomorph.doctor.checks.swapped import examine_swapped
from elastomorph.doctor.findings import Finding, finding
from elastomorph.doctor.mirror import Mirror
from elastomorph.doctor.side_names import SIDES, sided_pairs
from elastomorph.doctor.thresholds import Thresholds
from elastomorph.doctor.words import percent
from elastomorph.model.mesh import Mesh

__all__ = ["examine_names", "examine_symmetry"]


def examine_names(
    names: Mapping[str, str], sides: Sequence[tuple[str, str]] = SIDES
) -> list[Finding]:
    """Targets whose name says a side that has no other side.

    Args:
        names: File by name of the target.
        sides: How names tell sides.
    """
    pairs, alone = sided_pairs(names, sides)
    if not pairs:
        return []
    return [
        finding("missing-pair", names[name], "there is no target for the other side")
        for name in alone
    ]


def examine_symmetry(
    neutral: Mesh,
    targets: Mapping[str, Mesh],
    files: Mapping[str, str],
    mirror: Mirror,
    thresholds: Thresholds,
    sides: Sequence[tuple[str, str]] = SIDES,
    faulty: Mapping[str, Sequence[int]] | None = None,
) -> list[Finding]:
    """Compare the motions of each pair of targets.

    Args:
        neutral: The neutral.
        targets: Targets by name.
        files: File by name.
        mirror: The mirror images of the vertices of the neutral.
        thresholds: From where on to report.
        sides: How names tell sides.
        faulty: Vertices by name that have a finding of their own, so that they are left out.
    """
    found, pairs = [], sided_pairs(targets, sides)[0]
    scale = neutral.diameter or 1.0
    for left, right in pairs:
        mine = targets[left].vertices - neutral.vertices
        their = targets[right].vertices - neutral.vertices
        known = _compared(mirror, *((faulty or {}).get(name, ()) for name in (left, right)))
        off = np.linalg.norm(mirror.reflected(their[mirror.partner[known]]) - mine[known], axis=1)
        most = float(max(np.linalg.norm(mine, axis=1).max(), np.linalg.norm(their, axis=1).max()))
        worst = float(off.max(initial=0.0))
        if worst <= thresholds.asymmetry * most or worst <= thresholds.asymmetry_of_d * scale:
            continue
        vertex = int(known[int(off.argmax())])
        other = int(mirror.partner[vertex])
        message = (
            f"differs from the mirror image of {Path(files[right]).name} by up to "
            f"{percent(worst / scale)} of D ({percent(worst / most)} of its motion) at vertex "
            f"{vertex} (there {other})"
        )
        one_sided = worst > thresholds.one_sided * most
        found.append(
            finding(
                "asymmetric-pair",
                files[left],
                message,
                vertices=(vertex, other),
                severity="warning" if one_sided else None,
            )
        )
    return found + examine_swapped(neutral, targets, files, mirror, pairs)


def _compared(
    mirror: Mirror, faulty_left: Sequence[int], faulty_right: Sequence[int]
) -> NDArray[np.int64]:
    """The vertices of the left target that have a mirror image, neither of them faulty."""
    known = mirror.partner >= 0
    known[list(faulty_left)] = False
    at_fault = np.zeros(len(known), dtype=bool)
    at_fault[list(faulty_right)] = True
    known[at_fault[mirror.partner]] = False
    return np.flatnonzero(known)
