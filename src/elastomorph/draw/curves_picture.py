"""The curves of a face drawn on it, neighbours in different colours (Fig. 5)."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from elastomorph.curves import CurveNetwork, require_curves_of
from elastomorph.draw.camera import View, camera_for, drawn_vertices
from elastomorph.draw.pictures import Image, written
from elastomorph.draw.sheet import Style
from elastomorph.draw.stage import Lines, Stage
from elastomorph.model.mesh import Mesh

PALETTE = (
    np.array(
        [
            (31, 100, 200),
            (230, 97, 0),
            (0, 135, 75),
            (200, 30, 60),
            (120, 70, 190),
            (0, 160, 200),
            (205, 155, 0),
            (215, 60, 150),
            (90, 60, 40),
            (90, 150, 20),
        ]
    )
    / 255
)
"""Colours told apart from each other and from clay."""
CLOSED_WIDER = 1.8


def curves_picture(
    mesh: Mesh,
    curves: CurveNetwork,
    path: str | Path | None = None,
    *,
    view: View = "front",
    size: tuple[int, int] = (900, 1125),
    width: float = 1.6,
) -> Image:
    """Draw the curve network of a mesh on its surface, closed curves wider.

    Size and the width of the lines are in pixels; view and path as for `render`.
    """
    style = Style(lines=network_lines(mesh, curves, width))
    with Stage(mesh, camera_for(mesh, view, size=size), size=size) as stage:
        return written(style.draw(stage, mesh.vertices), path)


def network_lines(mesh: Mesh, curves: CurveNetwork, width: float = 1.6) -> tuple[Lines, Lines]:
    """The open curves of a network, and its closed ones in wider lines.

    Left out are curves of one vertex, and those on parts that are not drawn.
    """
    require_curves_of(curves, len(mesh.vertices), mesh.name)
    colours = curve_colours(mesh, curves)
    shown = np.zeros(len(mesh.vertices), dtype=bool)
    shown[drawn_vertices(mesh)] = True
    kinds = []
    for closed in (False, True):
        chosen = [
            number
            for number, curve in enumerate(curves)
            if curve.closed == closed and len(curve) > 1 and shown[curve.vertices].all()
        ]
        paths = [np.append(curves[n].vertices, curves[n].vertices[: int(closed)]) for n in chosen]
        kinds.append(Lines(paths, colours[chosen], width * (CLOSED_WIDER if closed else 1.0)))
    return kinds[0], kinds[1]


def curve_colours(mesh: Mesh, curves: CurveNetwork) -> NDArray[np.float64]:
    """(C, 3) colours such that curves joined by an edge of the mesh differ where they can.

    The curves choose in order, each the colour that its neighbours use least, and among those the
    one that the whole network has used least.
    """
    sides = curves.curve_of[mesh.edges]
    sides = sides[(sides[:, 0] != sides[:, 1]) & (sides >= 0).all(axis=1)]
    sides = np.concatenate([sides, sides[:, ::-1]])
    sides = sides[np.argsort(sides[:, 0], kind="stable")]
    starts = np.searchsorted(sides[:, 0], np.arange(len(curves) + 1))
    chosen = np.full(len(curves), -1)
    used = np.zeros(len(PALETTE))
    for number in range(len(curves)):
        near = chosen[sides[starts[number] : starts[number + 1], 1]]
        beside = np.bincount(near[near >= 0], minlength=len(PALETTE))
        chosen[number] = int(np.lexsort((used, beside))[0])
        used[chosen[number]] += len(curves[number])
    return PALETTE[chosen] if len(curves) else np.zeros((0, 3))
