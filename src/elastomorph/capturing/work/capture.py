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
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.capturing.cameras.frames import Frame
from elastomorph.capturing.cameras.models import SolvedPose
from elastomorph.capturing.geometry import Similarity, Surface
from elastomorph.capturing.landmarks import Landmarks
from elastomorph.capturing.neutral import Painted
from elastomorph.capturing.photographs import Photographs, Views, compared
from elastomorph.capturing.tracking import Matches, consistent
from elastomorph.capturing.work.captured import Captured, textured, write_captured
from elastomorph.capturing.work.makers import Makers, Placed, Posed
from elastomorph.capturing.work.progress import Progress, StageSay
from elastomorph.capturing.work.registered import FLAGGED, Registered
from elastomorph.capturing.work.request import Request, requested
from elastomorph.capturing.work.stages import Made, WorkingFolder, content_digest, packed
from elastomorph.capturing.work.template import Template
from elastomorph.errors import CaptureError
from elastomorph.io.atomic import made_folder
from elastomorph.io.rig_cache import content_digests
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

    return made(request, Makers(), say)


# A capture from its first stage to its last, and what of it is handed out.
#
# The stages of a capture in their order, each with what it depends on.
#
# How well registered poses agree with what photographs show: surface and correspondence, apart.
#
# A mesh may slide along the skin and still lie on it everywhere, so that a small distance from
# the surface says nothing of where skin went. Both are measured by features of the photographs,
# whose places in space were found without the mesh.

Points = NDArray[np.float64]

_NEAR = 0.02
"""Of the extent: points farther off are of hair, clothes or the background."""
_FEWEST = 20


def surface_agreement(points: Points, surface: Surface, extent: float) -> dict[str, Any]:
    """How far (N, 3) points that photographs show are from a pose's surface, parts of its extent.

    Returns:
        ``points``, how many are near enough to be of the head; ``median`` and ``p95`` of their
        distances. Nothing where they are too few.
    """
    if len(points) < _FEWEST:
        return {}
    away = surface.closest(points).distances / extent
    return _spread(away[away < _NEAR], "points")


def skin_agreement(
    neutral: Surface, pose: Surface, matches: Matches, extent: float
) -> dict[str, Any]:
    """How far a pose has skin of the neutral from where photographs show it, parts of its extent.

    Each matched point of the neutral is held by the triangle it is nearest to, with its distance
    from it, and compared with its match where that triangle is in the pose. Matches that move
    unlike all around them are of other skin.

    Args:
        neutral: The surface of the neutral, (V, 3).
        pose: The same triangles in the pose, (V, 3).
        matches: Points of the skin in both, in their frame.
        extent: Of the face, in the same units.

    Returns:
        ``matches``, how many were compared; ``median`` and ``p95`` of the distances. Nothing where
        they are too few.
    """
    if len(matches) < _FEWEST:
        return {}
    held = neutral.closest(matches.neutral)
    lifted = np.einsum("ni,ni->n", matches.neutral - held.points, neutral.at(held, neutral.normals))
    expected = pose.at(held, pose.vertices) + lifted[:, None] * pose.at(held, pose.normals)
    near = held.distances < _NEAR * extent
    near[near] = consistent(matches.chosen(near), expected[near], extent)
    away = np.linalg.norm(expected - matches.pose, axis=1) / extent
    return _spread(away[near], "matches")


def _spread(away: Points, name: str) -> dict[str, Any]:
    if len(away) < _FEWEST:
        return {}
    middle, most = np.quantile(away, [0.5, 0.95])
    return {name: len(away), "median": float(middle), "p95": float(most)}


class Work:
    """A capture at work in a folder that is its own meanwhile."""

    def __init__(
        self,
        request: Request,
        makers: Makers,
        working: WorkingFolder,
        say: Callable[[str], None],
    ) -> None:
        self.request = request
        self.makers = makers
        self.working = working
        self.progress = Progress(say, _expected(request))
        self._made: dict[str, Made[Any]] = {}
        self._photographs: dict[str, Photographs] = {}

    def photographs(self, pose: str) -> Photographs:
        """Those of use of a pose."""
        if pose not in self._photographs:
            self._photographs[pose] = self._examined(pose)
        return self._photographs[pose]

    def _examined(self, pose: str) -> Photographs:
        files = self.request.poses[pose]
        masks = {file: self.request.masks[file] for file in files if file in self.request.masks}

        def examined(say: StageSay) -> Photographs:
            say(f"looking at the photographs of {pose}", 0.0)
            found = self.makers.photographs(pose, files, masks)
            # Results are to be the same wherever photographs lie.
            taken = [replace(p, path=Path(p.name), mask=None) for p in found.taken]
            return replace(found, taken=tuple(taken))

        depends = {
            "pose": pose,
            "files": _digests({file.name: file for file in files}),
            "masks": _digests({file.name: mask for file, mask in masks.items()}),
        }
        found: Photographs = self._stage(f"photographs/{pose}", depends, examined).read()
        here = {file.name: file for file in files}
        taken = [replace(p, path=here[p.name], mask=masks.get(here[p.name])) for p in found.taken]
        return replace(found, taken=tuple(taken))

    def cameras(self, pose: str) -> Made[SolvedPose]:
        """The cameras of a pose, in a frame and a unit of their own."""
        given = self.request.cameras.get(pose)
        if given is not None:
            return self._stage(
                f"cameras/{pose}",
                {
                    "photographs": self._digest_of_photographs(pose),
                    "given": content_digest(packed(given)),
                },
                lambda say: self.makers.given(self.photographs(pose), given, _naming(pose, say)),
            )
        if self.request.rig == "fixed":
            return self._of_rig(pose)
        neutral = self.request.neutral
        first = None if pose == neutral else self.cameras(neutral)
        depends = {
            "photographs": self._digest_of_photographs(pose),
            "like": None if first is None else first.digest,
        }
        return self._stage(
            f"cameras/{pose}",
            depends,
            lambda say: self.makers.cameras(
                self.photographs(pose), None if first is None else first.read(), _naming(pose, say)
            ),
        )

    def _of_rig(self, pose: str) -> Made[SolvedPose]:
        """Those of a pose, by cameras that were found from several poses together."""
        poses, neutral = self.request.poses, self.request.neutral
        whole: Made[Any] = (
            self.cameras(neutral)
            if neutral in self.request.cameras
            else self._stage(
                "rig",
                {each: self._digest_of_photographs(each) for each in poses} | {"neutral": neutral},
                lambda say: self.makers.rig(
                    {each: self.photographs(each) for each in poses}, neutral, _naming("rig", say)
                ),
            )
        )
        both = (neutral, pose)

        def made(say: StageSay) -> SolvedPose:
            found = whole.read()
            known: Mapping[str, SolvedPose] = (
                {neutral: found} if isinstance(found, SolvedPose) else found
            )
            if pose in known:
                return known[pose]
            shown = {each: self.photographs(each) for each in both}
            return self.makers.in_rig(shown, neutral, pose, known[neutral], _naming(pose, say))

        return self._stage(
            f"cameras/{pose}",
            {
                "rig": whole.digest,
                "both": [self._digest_of_photographs(each) for each in both],
            },
            made,
        )

    def placed(self) -> Made[Placed]:
        """The neutral's cameras brought to the template."""
        request, neutral = self.request, self.request.neutral
        cameras = self.cameras(neutral)
        depends = {
            "cameras": cameras.digest,
            "template": _digest(self.template),
            "vertices": dict(request.landmarks.vertices),
            "clicks": request.landmarks.photographs.get(neutral, {}),
            "distances": request.landmarks.distances,
        }
        return self._stage(
            "placed",
            depends,
            lambda say: self.makers.placed(
                cameras.read(), self.template, request.landmarks, neutral
            ),
        )

    def neutral(self) -> Made[Posed]:
        """The template on the surface of the neutral."""
        pose, placed = self.request.neutral, self.placed()
        depends = {
            "photographs": self._digest_of_photographs(pose),
            "cameras": self.cameras(pose).digest,
            "placed": placed.digest,
            "template": _digest(self.template),
            "vertices": dict(self.request.landmarks.vertices),
        }
        return self._stage(
            "neutral",
            depends,
            lambda say: self.makers.neutral(
                self.template,
                placed.read(),
                self.in_frame(pose),
                self.request.landmarks,
                self.views(pose),
                say,
            ),
        )

    def texture(self) -> Mapping[str, Painted]:
        """Material → its image by the photographs of the neutral; none without coordinates."""
        pose, mesh, neutral = self.request.neutral, self.template.mesh, self.neutral()
        if mesh.uv is None:
            return {}
        depends = {
            "neutral": neutral.digest,
            "photographs": self._digest_of_photographs(pose),
            "cameras": self.cameras(pose).digest,
            "placed": self.placed().digest,
            "template": _digest(self.template),
            "faces": [mesh.faces.indices, mesh.faces.offsets],
            "coordinates": [mesh.uv.coordinates, mesh.uv.corners],
            "materials": mesh.materials and [list(mesh.materials.names), mesh.materials.of_face],
        }
        files = {p.name: p.path for p in self.photographs(pose).taken}
        made: Made[Mapping[str, Painted]] = self._stage(
            "texture",
            depends,
            lambda say: self.makers.texture(
                self.template, neutral.read(), self.in_frame(pose).cameras, files, say
            ),
        )
        return made.read()

    def framed(self, pose: str) -> Made[Frame]:
        """How a pose is brought to the neutral in the frame of the template."""
        request = self.request
        cameras, neutral, placed = self.cameras(pose), self.neutral(), self.placed()
        depends = {
            "cameras": [self.cameras(request.neutral).digest, cameras.digest],
            "placed": placed.digest,
            "surface": neutral.digest,
            "vertices": dict(request.landmarks.vertices),
            "rig": request.rig,
        }

        def made(say: StageSay) -> Frame:
            say(f"bringing {pose} to the neutral", 0.0)
            stayed = request.rig == "fixed"
            solved = cameras.read()
            if stayed:  # in the unit of the neutral already: that of the template with it
                solved = _moved(solved, placed.read().similarity)
            return self.makers.framed(
                self.in_frame(request.neutral),
                solved,
                pose,
                neutral.read(),
                self.template,
                request.landmarks,
                stayed,
            )

        return self._stage(f"frames/{pose}", depends, made)

    def matches(self, pose: str) -> Matches:
        """Points of the neutral and of a pose that look the same, in the frame of the template."""
        ours, theirs = self.framed(pose).read().pairs.T
        neutral = self.in_frame(self.request.neutral)
        return Matches(neutral.points[ours], self.in_frame(pose).points[theirs])

    def tracked(self, pose: str) -> Made[Posed]:
        """The neutral moved into a pose."""
        neutral, before = self.request.neutral, self.request.chain[pose]
        start = self.neutral() if before == neutral else self.tracked(before)
        depends = {
            "neutral": self.neutral().digest,
            "before": start.digest,
            "cameras": [self.cameras(each).digest for each in (neutral, pose)],
            "placed": self.placed().digest,
            "frame": self.framed(pose).digest,
            "photographs": [self._digest_of_photographs(each) for each in (neutral, pose)],
        }

        def made(say: StageSay) -> Posed:
            say(f"{pose}: opening photographs", 0.0)
            vertices, matches = start.read().vertices, self.matches(pose)
            return self.makers.pose(
                self._reference, vertices, matches, self.views(pose), _naming(pose, say)
            )

        return self._stage(f"poses/{pose}", depends, made)

    def views(self, pose: str) -> Views:
        """The photographs of a pose, in the frame of the template."""
        photographs = self.photographs(pose)
        return Views(
            self.in_frame(pose).cameras,
            {p.name: p.path for p in photographs.taken},
            {p.name: p.mask for p in photographs.taken if p.mask is not None},
        )

    def in_frame(self, pose: str) -> SolvedPose:
        """Cameras and points of a pose, in the frame of the template where there is one."""
        solved = self.cameras(pose).read()
        if self.request.to == "cameras":
            return solved
        placed = self.placed().read().similarity
        if pose == self.request.neutral:
            return _moved(solved, placed)
        similarity = self.framed(pose).read().similarity
        first = placed.then(similarity) if self.request.rig == "fixed" else similarity
        return _moved(solved, first)

    @property
    def solved(self) -> list[str]:
        """The poses whose cameras are asked for."""
        return [self.request.neutral] if self.request.to == "neutral" else list(self.request.poses)

    @property
    def seconds(self) -> dict[str, float]:
        """Stage → seconds that it took, whenever it was made."""
        return {name: made.seconds for name, made in self._made.items()}

    @property
    def template(self) -> Template:
        """The template; there is one where more than cameras are asked for."""
        if self.request.template is None:
            raise CaptureError("a template is needed")
        return self.request.template

    @cached_property
    def _reference(self) -> Any:
        neutral = self.request.neutral
        return self.makers.reference(self.template, self.neutral().read(), self.views(neutral))

    def _digest_of_photographs(self, pose: str) -> list[object]:
        """What cameras and surfaces depend on of the photographs of a pose."""
        of_use = self.photographs(pose)
        masks = {p.name: p.mask for p in of_use.taken if p.mask is not None}
        return [[[p.name, p.digest, p.focal, p.lens] for p in of_use.taken], _digests(masks)]

    def _stage(
        self, name: str, depends: Mapping[str, object], make: Callable[[StageSay], Any]
    ) -> Made[Any]:
        if name not in self._made:
            say = self.progress.begun(name)
            made = self.working.made(name, depends, lambda: make(say), self.makers.version)
            self.progress.done(name, made.seconds, anew=made.anew)
            self._made[name] = made
        return self._made[name]


def _moved(solved: SolvedPose, similarity: Similarity) -> SolvedPose:
    cameras = tuple(camera.moved(similarity) for camera in solved.cameras)
    return replace(solved, cameras=cameras, points=similarity(solved.points))


def _naming(pose: str, say: StageSay) -> StageSay:
    return lambda text, part: say(f"{pose}: {text}", part)


def _digests(files: Mapping[str, Path]) -> dict[str, str]:
    """Of the contents of files, by name."""
    return dict(zip(files, content_digests(list(files.values())), strict=True))


def _digest(template: Template) -> list[object]:
    return [template.work.vertices, template.triangles]


def _expected(request: Request) -> dict[str, float]:
    """Stage → seconds that it takes on two cores, by the number of photographs."""
    counts = {pose: len(files) for pose, files in request.poses.items()}
    expected = {f"photographs/{pose}": 0.15 * count for pose, count in counts.items()}
    if request.rig == "fixed":
        expected["rig"] = 3.0 * sum(sorted(counts.values())[-4:])
    each = 1.0 if request.rig == "fixed" else 3.0
    solved = [request.neutral] if request.to == "neutral" else list(counts)
    expected |= {f"cameras/{pose}": each * counts[pose] for pose in solved}
    if request.to != "cameras":
        expected |= {"placed": 0.1, "neutral": 3.3 * counts[request.neutral]}
        if request.template is not None and request.template.mesh.uv is not None:
            expected["texture"] = 1.0 * counts[request.neutral]
    if request.to == "poses":
        expected |= {f"frames/{pose}": 5.0 for pose in request.chain}
        expected |= {f"poses/{pose}": 3.5 * counts[pose] for pose in request.chain}
    return expected


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
