"""Orbits of the jaw and of an eyelid (Figs. 1 and 2): where methods leave the true arc."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from elastomorph.draw.camera import Camera
from elastomorph.draw.graphs import dress, legend, new_figure, styles_for
from elastomorph.draw.materials import parts_of
from elastomorph.draw.pictures import Image
from elastomorph.draw.sheet import Face, face_sheet, scale_of
from elastomorph.evaluation.rigid_bodies import TIMES, Eyelid, Hinge
from elastomorph.model.mesh import Mesh, part_of
from elastomorph.model.morph import Morph

_VIEW = (55.0, 12.0)
_TRUE = "#9ad0b0"
_BESIDE = 0.2  # radians of the eyeball beyond the way of a lid


def hinge_faces(
    hinge: Hinge,
    morphs: Mapping[str, Morph],
    path: str | Path | None = None,
    *,
    time: float = 0.5,
    face: tuple[int, int] = (380, 300),
) -> Image:
    """What turns about the hinge, one picture a method, coloured by its distance from the true arc.

    Morphs are paths of the whole face by the labels of their methods; the time is t.
    """
    faces = []
    for morph in morphs.values():
        off = 100 * hinge.off(morph, time)
        caption = f"off the arc by up to {off.max():.3f} % of D"
        faces.append(Face(morph.at(time)[hinge.vertices], caption, off))
    words = f"distance from the hinge's true arc at t = {time:g}, % of D"
    return face_sheet(
        part_of(hinge.neutral, hinge.vertices),
        [faces],
        Camera.framing(np.stack([drawn.vertices for drawn in faces]), _VIEW, size=face),
        face,
        path,
        column_labels=list(morphs),
        scale=scale_of(faces, words),
    )


def hinge_graph(
    hinge: Hinge, morphs: Mapping[str, Morph], path: str | Path, unit: str = ""
) -> None:
    """The way of one vertex, seen along the hinge (a), and the distance from the arc over t (b)."""
    times = np.linspace(0.0, 1.0, 41)
    styles = styles_for(list(morphs))
    farthest = _farthest(hinge)
    start = hinge.neutral.vertices[farthest][None]
    axis, centre = hinge.screw.axis, hinge.screw.centre
    true = _seen(np.concatenate([hinge.screw.at(float(t), start) for t in times]), axis, centre)
    with new_figure(path, 11.0, 4.6) as figure:
        ways, gaps = figure.subplots(1, 2)
        ways.plot(*true.T, color=_TRUE, linewidth=9, label="true arc")
        marks = [int(np.argmin(np.abs(times - t))) for t in TIMES]
        for label, morph in morphs.items():
            line = styles[label].of(label)
            way = _seen(morph.at(times)[:, farthest], axis, centre)
            ways.plot(*way.T, marker="o", markevery=marks, ms=5, **line)
            off = [100 * float(hinge.off(morph, float(t)).max()) for t in times]
            gaps.plot(times, off, **line)
        ways.set_aspect("equal", adjustable="datalim")
        ways.set_title("(a) the farthest vertex, seen along the axis")
        ways.set_xlabel("dots at t = 0.25, 0.5 and 0.75")
        ways.set_ylabel(unit or "units of the rig")
        title = "(b) farthest from the arc, of all that turns"
        dress(gaps, title, "t", "% of D", whole_time=True)
        legend(figure, ways)


def eyelid_graph(
    lid: Eyelid, morphs: Mapping[str, Morph], path: str | Path, unit: str = ""
) -> None:
    """The way of a lid's edge over the eyeball, seen along its axis (a), and its height (b)."""
    times = np.linspace(0.0, 1.0, 41)
    styles = styles_for(list(morphs))
    every = {label: morph.at(times)[:, lid.vertex] for label, morph in morphs.items()}
    seen = {label: _seen(way, lid.axis, lid.centre) for label, way in every.items()}
    reach = np.concatenate([np.arctan2(way[:, 1], way[:, 0]) for way in seen.values()])
    angles = np.linspace(reach.min() - _BESIDE, reach.max() + _BESIDE, 91)
    with new_figure(path, 11.0, 4.6) as figure:
        ways, gaps = figure.subplots(1, 2)
        ball = lid.radius * np.stack([np.cos(angles), np.sin(angles)])
        ways.plot(*ball, color=_TRUE, linewidth=9, label="eyeball")
        marks = [int(np.argmin(np.abs(times - t))) for t in TIMES]
        for label, morph in morphs.items():
            line = styles[label].of(label)
            ways.plot(*seen[label].T, marker="o", markevery=marks, ms=5, **line)
            gaps.plot(times, 100 * lid.heights(morph, times), **line)
        ways.set_aspect("equal", adjustable="datalim")
        ways.set_title("(a) the edge of the lid, seen along its axis")
        ways.set_xlabel("dots at t = 0.25, 0.5 and 0.75")
        ways.set_ylabel(unit or "units of the rig")
        gaps.axhline(0.0, color=_TRUE, linewidth=9, zorder=1)
        dress(gaps, "(b) its height above the eyeball", "t", "% of D", whole_time=True)
        gaps.set_ylim(bottom=None)
        gaps.autoscale(axis="y")
        legend(figure, ways)


def looks_of(mesh: Mesh, vertices: NDArray[np.int64]) -> list[str]:
    """What vertices are (keys of `LOOKS`), such as teeth and gum; that of most vertices first."""
    counts = {}
    for name, numbers in parts_of(mesh).items():
        own = mesh.faces.indices[np.isin(mesh.faces.corner_faces, numbers)]
        count = len(np.intersect1d(own, vertices))
        if count and name not in ("skin", "hidden"):
            counts[name] = count
    return sorted(counts, key=lambda name: -counts[name])


def _farthest(hinge: Hinge) -> int:
    """The vertex of the rigid parts that is farthest from the axis."""
    arms = hinge.neutral.vertices[hinge.parts] - hinge.screw.centre
    across = arms - np.outer(arms @ hinge.screw.axis, hinge.screw.axis)
    return int(hinge.parts[np.linalg.norm(across, axis=1).argmax()])


def _seen(
    points: NDArray[np.float64], axis: NDArray[np.float64], centre: NDArray[np.float64]
) -> NDArray[np.float64]:
    """(N, 2) points as an eye on an axis sees them: forward to the right, up."""
    up = np.array([0.0, 1.0, 0.0]) - axis[1] * axis
    if np.linalg.norm(up) < 1e-6:  # a hinge that stands upright
        up = np.array([1.0, 0.0, 0.0]) - axis[0] * axis
    up /= np.linalg.norm(up)
    forward = np.cross(axis, up)
    forward *= 1.0 if forward[2] >= 0 else -1.0
    arms = points - centre
    return np.stack([arms @ forward, arms @ up], axis=1)
