"""A capture from its first stage to its last, and what of it is handed out."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from elastomorph.capturing.geometry.surface import Surface
from elastomorph.capturing.neutral.texture import Painted
from elastomorph.capturing.photographs.comparing import compared
from elastomorph.capturing.tracking.checks import skin_agreement, surface_agreement
from elastomorph.capturing.work.captured import Captured, textured, write_captured
from elastomorph.capturing.work.makers import Makers
from elastomorph.capturing.work.registered import FLAGGED, Registered
from elastomorph.capturing.work.request import Request
from elastomorph.capturing.work.stages import WorkingFolder
from elastomorph.capturing.work.work import Work
from elastomorph.io.atomic import made_folder

_OFTEN = 4  # photographs in which a vertex is well seen


def made(request: Request, makers: Makers, say: Callable[[str], None]) -> Captured:
    """All that was asked for, made where it is not there, and written."""
    made_folder(request.output)
    with WorkingFolder(request.working) as folder:
        captured = _captured_by(Work(request, makers, folder, say))
        say(f"writing {request.output}")
        write_captured(request.output, captured)
    return captured


def _captured_by(work: Work) -> Captured:
    request = work.request
    # What is cheap and may be wrong comes first, for all poses.
    for pose in request.poses:
        work.photographs(pose)
    remarks = compared({pose: work.photographs(pose) for pose in request.poses})
    work.cameras(request.neutral)
    if request.to != "cameras":
        work.placed()
    for pose in work.solved:
        work.cameras(pose)
    poses: dict[str, Registered] = {}
    textures: Mapping[str, Painted] = {}
    if request.to != "cameras":
        others = request.chain if request.to == "poses" else {}
        work.neutral()
        for pose in others:
            work.framed(pose)
        poses = {pose: _registered(work, pose) for pose in (request.neutral, *others)}
        textures = work.texture()
        poses = {
            pose: textured(poses[pose], request.neutral, textures)
            for pose in request.poses
            if pose in poses
        }
    return Captured(
        poses,
        {pose: work.in_frame(pose).cameras for pose in work.solved},
        {pose: {file.name: file for file in files} for pose, files in request.poses.items()},
        request.neutral,
        _figures(work, poses, remarks) | _of_textures(work, textures),
        {pose: work.in_frame(pose).points for pose in work.solved},
        textures,
    )


def _of_textures(work: Work, textures: Mapping[str, Painted]) -> dict[str, Any]:
    """How much of the skin is seen; a sentence where there is no texture."""
    if work.request.to == "cameras":
        return {}
    if work.template.mesh.uv is None:
        return {"texture": "the template has no texture coordinates, so there is no texture"}
    return {
        "texture": {
            name: {"side": len(own.image), "seen": float(own.seen[own.shown].mean())}
            for name, own in textures.items()
        }
    }


def _registered(work: Work, pose: str) -> Registered:
    """A pose with the vertices of the template as it was given."""
    made = work.neutral() if pose == work.request.neutral else work.tracked(pose)
    found = made.read()
    place = work.template.place
    # What is not known of the neutral is not known of what moves from there.
    confidence = np.minimum(found.confidence, work.neutral().read().confidence)
    confidence = np.clip(confidence, 0, 1)[place].astype(np.float32)
    figures = {"flagged": float((confidence < FLAGGED).mean()), **found.figures}
    figures |= _agreement(work, pose)
    return Registered.of(work.template.mesh, found.vertices[place], confidence, figures)


def _agreement(work: Work, pose: str) -> dict[str, Any]:
    """What is measured of a pose, ``surface`` and ``correspondence``, where it can be.

    Lengths are parts of the diameter of the template. ``seen`` is the share of its vertices that
    were found in four photographs or more.
    """
    extent, triangles = work.template.mesh.diameter, work.template.triangles
    still = Surface(work.neutral().read().vertices, triangles)
    moved, skin = still, dict[str, Any]()
    if pose != work.request.neutral:
        found = work.tracked(pose).read()
        moved = Surface(found.vertices, triangles)
        skin = skin_agreement(still, moved, work.matches(pose), extent)
        if "views" in found.measured:
            skin["seen"] = float((found.measured["views"] >= _OFTEN).mean())
    surface = surface_agreement(work.in_frame(pose).points, moved, extent)
    measured = {"surface": surface, "correspondence": skin}
    return {kind: own for kind, own in measured.items() if own}


def _figures(
    work: Work, poses: Mapping[str, Registered], remarks: Mapping[str, str]
) -> dict[str, Any]:
    """What was measured, pose by pose."""
    found: dict[str, Any] = {}
    for pose in work.solved:
        solved = work.cameras(pose).read()
        own: dict[str, Any] = {
            "photographs": len(work.request.poses[pose]),
            "cameras": len(solved.cameras),
            "points": len(solved.points),
            "reprojection": dict(solved.reprojection),
            "rejected": dict(solved.rejected),
            "remarks": [*([remarks[pose]] if pose in remarks else []), *solved.remarks],
        }
        if pose in poses:
            said = [*own["remarks"], *poses[pose].figures.get("remarks", ())]
            own |= {**poses[pose].figures, "remarks": said}
        if pose in poses and pose != work.request.neutral:
            frame = work.framed(pose).read()
            own["frame"] = {
                "rms": frame.rms,
                "rms_of_extent": frame.rms / poses[work.request.neutral].diameter,
                "agreeing": int(frame.agreeing.sum()),
            }
        found[pose] = own
    figures: dict[str, Any] = {"poses": found}
    if poses:
        placed = work.placed().read()
        figures["landmarks"] = dict(placed.residuals)
        figures["placed"] = dict(placed.figures)
    figures["seconds"] = work.seconds
    return figures
