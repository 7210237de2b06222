"""Photographs of poses become meshes with the vertices of a template.

Stages, each of which leaves its result in the working folder:

    photographs/POSE    which of them are of use
    cameras/POSE        where each was taken from, and points of the surface
    placed              the neutral, brought to the template by landmarks
    frames/POSE         how a pose is brought to the neutral, the head where it was
    neutral             the template on the neutral's surface
    poses/POSE          the neutral moved into a pose, chained along the movement
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from elastomorph.capturing.landmarks.landmarks import Landmarks
from elastomorph.capturing.work.captured import Captured
from elastomorph.capturing.work.request import requested
from elastomorph.model.mesh import Mesh


def capture(
    photos: str | Path | Mapping[str, object],
    template: Mesh | str | Path | None = None,
    *,
    output: str | Path,
    neutral: str | None = None,
    landmarks: Landmarks | str | Path | None = None,
    distance: tuple[str, str, float] | str | None = None,
    rig: str = "walking",
    masks: str | Path | None = None,
    to: str = "poses",
    working: str | Path | None = None,
    cameras: str | Path | None = None,
    say: Callable[[str], None] = lambda _: None,
) -> Captured:
    """Poses of one topology from photographs, about 30 of each pose.

    Each stage leaves its result in the working folder with what it depended on: the same call goes
    on after any interruption, and makes again what has changed.

    Args:
        photos: A folder with a folder of photographs for each pose, or one with all of them, named
            by pose and number (``smile_01.jpg``); or pose → photographs. Poses are in the order of
            the movement.
        template: A mesh, its file, a rig (its neutral), or ``built-in``; not needed for cameras.
        output: Folder for ``POSE.obj``, ``confidence.npz`` and ``capture.json``; made if missing.
        neutral: Name of its pose; by default with "neutral" in its name, else the first.
        landmarks: On the template and in photographs of the neutral, or their file; by default
            ``landmarks.json`` in the folder of the photographs.
        distance: ``("a", "b", 8.9)``: how far two points are apart, clicked ones or the cameras of
            photographs, named as these, in the unit of the template, for the poses to have the
            subject's size and not the template's.
        rig: ``walking``: cameras stand elsewhere for each pose. ``fixed``: they stay, and names or
            numbers of photographs tell which took which.
        masks: Folder of masks named as the photographs, white where the face is.
        to: ``cameras``, ``neutral`` or ``poses``: what to stop after.
        working: Folder of what stages leave; ``.capture`` in the output by default.
        cameras: Where photographs were taken from, if another program found it: a folder with the
            text model of COLMAP or a file of Bundler (``.out``, its list beside it), or a folder
            with one of these for each pose, named as it, such as ``cameras`` of an output. They
            are taken as they are; cameras of poses without any are found.
        say: Told what is being done, with the time left.

    Raises:
        CaptureError: The photographs do not show what is needed; the message says what to do.
        FileError: A file cannot be read or written, or another process uses the working folder.
        ParameterError: An argument cannot be meant.
        MissingExtraError: The extra ``capture`` is not installed.
    """
    request = requested(
        photos,
        template,
        output=output,
        neutral=neutral,
        landmarks=landmarks,
        distance=distance,
        rig=rig,
        masks=masks,
        to=to,
        working=working,
        cameras=cameras,
    )
    from elastomorph.capturing.work.makers import Makers
    from elastomorph.capturing.work.outcome import made

    return made(request, Makers(), say)
