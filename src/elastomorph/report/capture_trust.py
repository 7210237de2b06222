"""How far captured poses are to be trusted: in a sentence, in tables, and as a list of vertices."""

from __future__ import annotations

import json
import math
from base64 import b64encode
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastomorph.capturing.cameras.coverage import times_seen
from elastomorph.capturing.geometry.camera import Camera
from elastomorph.capturing.geometry.surface import Surface
from elastomorph.capturing.work.registered import FLAGGED, Registered
from elastomorph.evaluation.words import SPACE, counted
from elastomorph.model.mesh import Mesh
from elastomorph.report.document import Section

__all__ = ["Trust", "findings", "headline", "trust_section", "vertex_groups"]

_BEFORE = 0.005  # of D: part of the head that may stand before a vertex without hiding it


@dataclass(frozen=True, eq=False)
class Trust:
    """What is known of the vertices of a pose.

    Attributes:
        flagged: (V,) which are not to be trusted.
        seen: (V,) which some camera saw well enough to measure them.
    """

    flagged: NDArray[np.bool_]
    seen: NDArray[np.bool_]

    @classmethod
    def of(cls, mesh: Registered, cameras: Sequence[Camera]) -> Trust:
        """Of a pose and the cameras of its photographs, both in one frame."""
        surface = Surface(mesh.vertices, mesh.faces.triangles())
        return cls(mesh.flagged, times_seen(surface, cameras, _BEFORE * mesh.diameter) > 0)

    @property
    def unseen(self) -> int:
        """Flagged vertices that no camera saw."""
        return int((self.flagged & ~self.seen).sum())

    @property
    def doubtful(self) -> int:
        """Vertices that are flagged although cameras saw them."""
        return int((self.flagged & self.seen).sum())

    @property
    def trusted(self) -> int:
        """All others."""
        return int((~self.flagged).sum())

    @property
    def share(self) -> float:
        """Of what cameras saw, how much is to be trusted."""
        return self.trusted / max(self.trusted + self.doubtful, 1)


def headline(trust: Mapping[str, Trust]) -> str:
    """How many poses there are, and how much of what was seen is to be trusted."""
    shares = {pose: own.share for pose, own in trust.items()}
    worst = min(shares, key=lambda pose: shares[pose])
    vertices = f"{len(trust[worst].seen):,} vertices"
    poses = f"{counted(len(trust), 'pose')} of {vertices}{' each' if len(trust) > 1 else ''}"
    least = f", least in {worst}" if len({_percent(share) for share in shares.values()}) > 1 else ""
    return f"{poses}. Of what the cameras saw, {_span(shares.values())} can be trusted{least}."


def findings(trust: Mapping[str, Trust]) -> list[str]:
    """What is not to be trusted, and for which of two reasons."""
    unseen = {pose: own.unseen / len(own.seen) for pose, own in trust.items()}
    doubtful = {pose: own.doubtful / len(own.seen) for pose, own in trust.items()}
    found = []
    if any(unseen.values()):
        found.append(
            f"No camera saw {_span(unseen.values())} of the vertices, as on the back of a head or "
            "within the mouth. They were placed by what is around them."
        )
    if any(doubtful.values()):
        most = max(doubtful, key=lambda pose: doubtful[pose])
        found.append(
            f"{_span(doubtful.values())} of the vertices are doubtful although cameras saw them"
            f"{f', most in {most}' if len(trust) > 1 else ''}. The pictures pose by pose show "
            "where."
        )
    return found


def trust_section(poses: Mapping[str, Registered], trust: Mapping[str, Trust]) -> Section:
    """How many vertices of each pose are to be trusted, where the others are, and their list."""
    rows = [
        (
            pose,
            [
                f"{own.trusted:,}",
                f"{own.doubtful:,}",
                f"{own.unseen:,}",
                f"{_percent(own.share)}{SPACE}%",
            ],
        )
        for pose, own in trust.items()
    ]
    unseen, doubtful = (
        {
            pose: np.flatnonzero(own.flagged & (own.seen == seen)).tolist()
            for pose, own in trust.items()
        }
        for seen in (False, True)
    )
    listed = {"version": 1, "below": FLAGGED, "doubtful": doubtful, "unseen": unseen}
    text = json.dumps(listed, separators=(",", ":"), ensure_ascii=False)
    first = next(iter(poses.values()))
    content = {
        "rows": rows,
        "groups": _by_group(first, trust),
        "heads": ["Material" if first.groups is None else "Group", "Vertices", *poses],
        "least": f"{FLAGGED:g}",
        "link": f"data:application/json;base64,{b64encode(text.encode()).decode('ascii')}",
        "words": counted(
            sum(own.unseen + own.doubtful for own in trust.values()), "entry", "entries"
        ),
    }
    return Section("trust", "What can be trusted", content)


def _by_group(mesh: Mesh, trust: Mapping[str, Trust]) -> list[tuple[str, list[str]]]:
    """Doubtful vertices of each group in each pose, the worst group first; none of one group."""
    groups = vertex_groups(mesh)
    if len(groups) < 2:
        return []
    counts = {
        name: [int((own.flagged & own.seen & chosen).sum()) for own in trust.values()]
        for name, chosen in groups.items()
    }
    return [
        (name, [f"{groups[name].sum():,}", *(f"{count:,}" for count in counts[name])])
        for name in sorted(groups, key=lambda name: -max(counts[name]))
    ]


def vertex_groups(mesh: Mesh) -> dict[str, NDArray[np.bool_]]:
    """(V,) which vertices each group of a mesh has, or each material where there are no groups.

    A vertex of several is of the first; those of none are unnamed.
    """
    labels = mesh.groups if mesh.groups is not None else mesh.materials
    if labels is None:
        return {"whole mesh": np.ones(len(mesh.vertices), dtype=bool)}
    group = np.full(len(mesh.vertices), len(labels.names))
    of_corner = labels.of_face[mesh.faces.corner_faces]
    named = of_corner >= 0
    np.minimum.at(group, mesh.faces.indices[named], of_corner[named])
    names = [*labels.names, "unnamed"]
    return {name: group == k for k, name in enumerate(names) if (group == k).any()}


def _percent(share: float) -> str:
    """In whole per cent, or tenths of little; never rounded to all of it."""
    parts = 10 if share < 0.1 else 1
    return f"{math.floor(100 * parts * share) / parts:g}"


def _span(shares: Collection[float]) -> str:
    low, high = _percent(min(shares)), _percent(max(shares))
    return f"{low}{SPACE}%" if low == high else f"{low} to {high}{SPACE}%"
