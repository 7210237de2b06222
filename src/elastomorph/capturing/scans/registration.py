"""Scans of any topology become meshes with the vertices of a template.

The first scan, the neutral, makes the template that person; every other pose starts from there.

How far each vertex of a registered scan is to be trusted, and what says so.

The error of a vertex is estimated in two parts. Across the surface it is what the scan shows: the
distance to it, or where the scan shows nothing, how far the next vertex is at which it does. Along
the surface a scan without colours shows nothing: there the error grows with how far the vertex has
moved, less beside landmarks, and less where a rig's expressions say how skin moves.

Photographs of scans with colours, by cameras that nobody had to hold.

The same cameras look at the neutral's scan and at a pose's. What the neutral shows in its pictures
is then followed in those of the pose, so that correspondence comes from the skin.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.capturing.cameras.frames import paired
from elastomorph.capturing.geometry import (
    Camera,
    Similarity,
    Surface,
    View,
    fit_similarity,
    robust_rigid,
)
from elastomorph.capturing.landmarks import Landmarks, read_landmarks
from elastomorph.capturing.scans.correspondence import ScanPoints
from elastomorph.capturing.scans.expressions import Expressions
from elastomorph.capturing.scans.nonrigid import ADAPT, FINISH, FOLLOW, Elastic, Held
from elastomorph.capturing.scans.placing import (
    Marks,
    Placed,
    placed_at,
    placed_first,
    placed_next,
    stillness,
)
from elastomorph.capturing.scans.registered_files import (
    Face,
    digest_of,
    keep_pose,
    read_face,
    read_registered,
    write_figures,
)
from elastomorph.capturing.scans.scans import Scan, Skin, mesh_in, read_scan
from elastomorph.capturing.tracking import Matches, Reference, TrackedPose, confidences, follow
from elastomorph.capturing.work.registered import Registered
from elastomorph.errors import CaptureError, FormatError, ParameterError, warn
from elastomorph.model.mesh import Mesh, require_mesh, require_same_topology
from elastomorph.rig import Rig

Points = NDArray[np.float64]

# Cameras, chosen among this many directions, each this many extents away.
_CAMERAS, _DIRECTIONS, _AWAY = 18, 150, 2.5
# Pixels that the extent is long at, and how much room is left around it.
_PIXELS, _ROOM = 1100.0, 1.1
# Points of the skin in each picture, and fewest in both that a pose is begun by.
_FEATURES, _FEWEST = 1500, 60
# Least cosine at which a camera sees a vertex well.
_WELL = 0.45


def cameras_around(elastic: Elastic, wanted: Points) -> list[Camera]:
    """Cameras by which every vertex of the skin is seen well by several.

    Args:
        elastic: a face.
        wanted: (V,) how much each vertex counts.
    """
    vertices, normals = elastic.rest, elastic.normals(elastic.rest)
    skin = elastic.outer
    middle = np.average(vertices[skin], axis=0, weights=wanted[skin])
    ways = _sphere(_DIRECTIONS)
    seen = np.maximum(normals[skin] @ ways.T - _WELL, 0)
    times = np.zeros(np.count_nonzero(skin))
    found: list[Camera] = []
    for _ in range(_CAMERAS):
        best = int((seen * (wanted[skin] / (1 + times) ** 2)[:, None]).sum(axis=0).argmax())
        times += seen[:, best] > 0
        seen[:, best] = 0
        found.append(_looking(middle, ways[best], elastic.size, f"{len(found):02d}"))
    return found


def photographed(camera: Camera, surface: Surface, skin: Skin) -> View:
    """What a camera sees of a scan, as bright as its own colours."""
    import cv2

    hits = surface.seen(camera)
    colour = skin.at(hits.triangles, hits.weights)
    grey: Any = cv2.cvtColor(colour, cv2.COLOR_RGB2GRAY)
    return View(camera, grey, hits.met)


@dataclass(frozen=True, eq=False)
class Shown:
    """A neutral that can be followed.

    Attributes:
        reference: it and its virtual photographs.
        surface: of its scan.
    """

    reference: Reference
    surface: Surface


def shown_neutral(elastic: Elastic, neutral: Placed, wanted: Points) -> Shown | None:
    """The neutral as its virtual photographs show it; None where its scan has no colours."""
    if neutral.scan.skin is None:
        return None
    cameras = cameras_around(elastic, wanted)
    views = [photographed(camera, neutral.surface, neutral.scan.skin) for camera in cameras]
    return Shown(Reference(elastic.rest, elastic.triangles, views), neutral.surface)


def followed(neutral: Shown, pose: Placed, skin: Skin, start: Points) -> TrackedPose:
    """The vertices of the neutral in virtual photographs of a pose.

    Args:
        neutral: what is followed.
        pose: the scan of the pose.
        skin: its colours.
        start: (V, 3) as its surface alone has it.
    """
    before = neutral.reference.views
    views = [photographed(view.camera, pose.surface, skin) for view in before]
    found = [
        _alike(one, neutral.surface, other, pose.surface)
        for one, other in zip(before, views, strict=True)
    ]
    points = [np.concatenate(each) for each in zip(*found, strict=True)]
    matches = Matches(*points) if len(points[0]) >= _FEWEST else None
    return follow(neutral.reference, views, start=start, matches=matches)


def _alike(one: View, first: Surface, other: View, second: Surface) -> tuple[Points, Points]:
    """Points of two scans that look alike to one camera (SIFT)."""
    (pixels, own), (goals, there) = _features(one), _features(other)
    pairs = paired(own, there)
    starts, ends = (
        _lifted(view.camera, surface, at[some])
        for view, surface, at, some in (
            (one, first, pixels, pairs[:, 0]),
            (other, second, goals, pairs[:, 1]),
        )
    )
    met = np.isfinite(starts).all(axis=1) & np.isfinite(ends).all(axis=1)
    return starts[met], ends[met]


def _features(view: View) -> tuple[Points, NDArray[np.float32]]:
    """(N, 2) pixels and (N, 128) descriptors of length 1."""
    import cv2

    mask: Any = None if view.mask is None else view.mask.astype(np.uint8)
    finder: Any = getattr(cv2, "SIFT_create")(_FEATURES, contrastThreshold=0.015)  # noqa: B009
    found, described = finder.detectAndCompute(view.grey, mask)
    if described is None:
        return np.zeros((0, 2)), np.zeros((0, 128), dtype=np.float32)
    lengths = np.maximum(np.linalg.norm(described, axis=1, keepdims=True), 1e-12)
    return np.array([own.pt for own in found]), (described / lengths).astype(np.float32)


def _lifted(camera: Camera, surface: Surface, pixels: Points) -> Points:
    """(N, 3) points of a surface at pixels; infinite where there is none."""
    ways = camera.through(pixels)
    depths = surface.cast(camera.position, ways).depths
    with np.errstate(invalid="ignore"):
        return np.asarray(camera.position + depths[:, None] * ways)


def _looking(middle: Points, way: Points, size: float, name: str) -> Camera:
    """A camera in a direction that looks at the middle of the face."""
    away = _AWAY * size
    forward = -way
    side = np.cross([0.0, 1.0, 0.0] if abs(way[1]) < 0.9 else [0.0, 0.0, 1.0], forward)
    side /= np.linalg.norm(side)
    rotation = np.stack([side, np.cross(forward, side), forward])
    pixels = round(_ROOM * _PIXELS)
    return Camera(
        name,
        (pixels, pixels),
        _PIXELS * _AWAY,
        np.full(2, (pixels - 1) / 2),
        0.0,
        rotation,
        -rotation @ (middle + away * way),
    )


def _sphere(count: int) -> Points:
    """(count, 3) directions, spread evenly (a Fibonacci spiral)."""
    number = np.arange(count)
    z = 1 - 2 * (number + 0.5) / count
    angle = number * np.pi * (3 - np.sqrt(5))
    across = np.sqrt(1 - z**2)
    return np.stack([across * np.cos(angle), across * np.sin(angle), z], axis=1)


# Reach of a point that says where a vertex is, in parts of the extent, and least cosine.
_NEAR, _SAME = 0.006, 0.7
# Error a length away from what the scan shows, in parts of that length.
_UNSEEN = 0.12
# Slide along the surface in parts of the movement: plain, beside a landmark, by a rig's
# expressions, and of what these leave over.
_SLIDE, _AT_LANDMARK, _BY_RIG, _LEFT = 0.9, 0.28, 0.15, 1.0
# How far a landmark helps, in parts of the extent.
_HELPS = 0.06


@dataclass(frozen=True, eq=False)
class Trust:
    """What is known of a registered scan, vertex by vertex.

    Attributes:
        distance: (V,) to the scan, in parts of the extent.
        shown: (V,) whether the scan shows it: no hole, border or hidden place.
        confidence: (V,) in [0, 1].
    """

    distance: Points
    shown: NDArray[np.bool_]
    confidence: Points

    def figures(self, extent_unit: float) -> dict[str, Any]:
        """Numbers over all vertices; distances in % of the extent, which is in template units."""
        own = 100 * self.distance[self.shown]
        return {
            "extent": extent_unit,
            "surface_mean": float(own.mean()) if len(own) else None,
            "surface_p95": float(np.percentile(own, 95)) if len(own) else None,
            "shown": float(self.shown.mean()),
            "flagged": float((self.confidence < 0.5).mean()),
        }


def trusted(
    elastic: Elastic,
    vertices: Points,
    scan: ScanPoints,
    along: Points,
) -> Trust:
    """The confidence of a template drawn onto a scan.

    Args:
        elastic: the template.
        vertices: (V, 3) where it is drawn to.
        scan: in the same place and size.
        along: (V,) error expected along the surface, in parts of the extent.
    """
    size = elastic.size
    found = elastic.matches(vertices, scan, _NEAR)
    distance = found.distances / size
    shown = elastic.outer & ~found.border & (found.cosines > _SAME) & (distance < _NEAR)
    unseen = _way(elastic, vertices, np.flatnonzero(shown)) / size
    across = np.where(shown, distance, _UNSEEN * unseen)
    error = np.hypot(elastic.deformation.smoothed(across, 2), along)
    return Trust(distance, shown, confidences(error, 1.0))


def slide(
    elastic: Elastic, vertices: Points, neutral: Points, held: Held, expected: Points | None
) -> Points:
    """(V,) error expected along the surface where nothing was followed on it.

    Args:
        elastic: the template.
        vertices: (V, 3) where it is drawn to.
        neutral: (V, 3) where it was.
        held: landmarks.
        expected: (V, 3) where a rig's expressions put it, if there is a rig.
    """
    moved = np.linalg.norm(vertices - neutral, axis=1)
    if expected is not None:
        left = np.linalg.norm(vertices - expected, axis=1)
        return elastic.deformation.smoothed(_BY_RIG * moved + _LEFT * left, 2) / elastic.size
    far = np.full(len(vertices), np.inf)
    if len(held.vertices):
        far = _way(elastic, vertices, held.vertices) / elastic.size
    share = _AT_LANDMARK + (_SLIDE - _AT_LANDMARK) * (1 - np.exp(-((far / _HELPS) ** 2)))
    return elastic.deformation.smoothed(share * moved, 2) / elastic.size


def _way(elastic: Elastic, vertices: Points, start: NDArray[np.integer]) -> Points:
    """(V,) length of the way along edges to the nearest of some vertices; the extent at most."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import dijkstra

    if not len(start):
        return np.full(len(vertices), elastic.size)
    first, second = elastic.deformation.edges.T
    lengths = np.maximum(np.linalg.norm(vertices[first] - vertices[second], axis=1), 1e-12)
    count = len(vertices)
    graph = coo_array((lengths, (first, second)), shape=(count, count)).tocsr()
    found = dijkstra(graph, directed=False, indices=start, min_only=True)
    return np.asarray(np.minimum(found, elastic.size), dtype=np.float64)


Say = Callable[[str], None]
Source = str | Path | Mesh

# What says how the skin has moved along itself.
THE_TEMPLATE, BY_SURFACE, BY_LANDMARKS, BY_RIG, FOLLOWED = (
    *("of the template", "by the surface alone", "by landmarks", "by the rig's expressions"),
    "by the skin's colours",
)
# Confidence of vertices by which the head is held still, the fewest, and how far they are off, in
# parts of the extent, from rough to fine.
_SURE, _ENOUGH, _STILL = 0.9, 100, (0.01, 0.003, 0.001)
# Weight of a landmark beside a point of the scan where nothing else tells what moved along it.
_HELD = 10.0
# The same where the template becomes a person, and beside what the rig says.
_ADAPTED, _KEPT = 0.3, 0.1
# Doubt of the head's place that is said, in % of D on average.
_MOVED = 0.25
# Confidence from which on a vertex that was followed is known.
_KNOWN = 0.5
# A face of which the scan shows less than this was not found in it.
_SHOWN = 0.3
# Cosine between the normals of template and person, on average: above .97 for other people's faces
# and about .7 for balls and boxes.
_ALIKE = 0.8


@dataclass(frozen=True, eq=False)
class Person:
    """The template as one person, whom all scans show.

    Attributes:
        face: the template.
        elastic: at rest at the person's own neutral.
        expressions: of the template's rig, on this person.
        placing: what brought the scan that it was made from to its place, if it is known.
        still: (V,) how much each vertex tells where the head is; 0 where the scan shows nothing.
        clicked: vertex of a landmark → how far beside it the landmark is on the neutral's scan.
        shown: what of it can be followed, if its scan has colours.
    """

    face: Face
    elastic: Elastic
    expressions: Expressions | None
    placing: Similarity | None
    still: Points
    clicked: Mapping[int, Points]
    shown: Shown | None = None


def register(
    scan: Source,
    template: Source | Rig,
    *,
    landmarks: str | Path | Landmarks | None = None,
    neutral: Source | None = None,
    texture: bool = True,
    say: Say = lambda _: None,
) -> Registered:
    """A scan as a mesh with the vertices, polygons and labels of a template.

    Args:
        scan: A file (.obj with .mtl and images, .ply, .glb, …) or a mesh of any topology, in any
            unit, turned anyhow; with holes, noise and other things around the face.
        template: A mesh or a rig, or the file, folder or name (``built-in``) of one. The
            expressions of a rig say how skin moves along itself, which no surface does.
        landmarks: A file as 'elastomorph landmarks' writes it, or what it holds: vertices of the
            template, and points of the scan under the name of its file. Without any, the scan is
            laid over what is expected, which is believed only where it is clear.
        neutral: The same person's neutral as this function gave it, or its file; or a scan of it
            in any topology, which is registered first, and whose colours are followed. Without it
            the scan is the neutral, and the template becomes that person.
        texture: Whether colours of the scan are used where it has them.
        say: Told what is being done.

    Returns:
        The pose in the units and the place of the template, with (V,) `confidence` in [0, 1] and
        `figures`: how the scan was laid, how far it is from the surface, and what the confidence
        was computed from.

    Raises:
        FileError: A file is missing or cannot be read.
        CaptureError: The scan shows no such face, or where it is cannot be told.
        MissingExtraError: The extra ``capture`` is not installed.
    """
    own, marks = _prepared(template, landmarks)
    if neutral is None:
        return _first(own, read_scan(scan, texture=texture), marks, say)[0]
    person = neutral_person(own, neutral, marks, texture, say)
    found = read_scan(scan, texture=texture)
    pose = _next(person, found, marks, None, say)
    _warn({str(scan) if not isinstance(scan, Mesh) else scan.name: pose})
    return pose


def register_all(
    scans: Sequence[Source] | Mapping[str, Source],
    template: Source | Rig,
    *,
    landmarks: str | Path | Landmarks | None = None,
    neutral: str | None = None,
    texture: bool = True,
    output: str | Path | None = None,
    done: Callable[[str, Registered], object] = lambda name, pose: None,
    say: Say = lambda _: None,
) -> dict[str, Registered]:
    """The poses of one person from scans, each placed and begun by the one before.

    Args:
        scans: Files or meshes, in the order of the movement; poses are called by the names of the
            files without suffix, or by the names given.
        template: As for `register`.
        landmarks: As for `register`; later scans need none.
        neutral: Which pose is the neutral; by default the one with "neutral" in its name, else the
            first.
        texture: Whether colours of the scans are used where they have them.
        output: A folder in which each pose is kept as soon as it is finished. What an earlier call
            left there of the same scans, template and landmarks is not made again.
        done: Called with each pose as it is finished, also with one that was there.
        say: Told what is being done.

    Returns:
        Pose → registered mesh, in the order given.

    Raises:
        FileError: A file is missing or cannot be read.
        CaptureError: A scan shows no such face, or where it is cannot be told.
        ParameterError: No scan, two of one name, or no such neutral.
        MissingExtraError: The extra ``capture`` is not installed.
    """
    named = _named(scans)
    first = _which(list(named), neutral)
    own, marks = _prepared(template, landmarks)
    kept = {} if output is None else read_registered(output, own.mesh)
    found: dict[str, Registered] = {}
    order = [first, *(name for name in named if name != first)]
    given = digest_of(own.vertices, own.triangles, marks.vertices, texture, version("elastomorph"))
    if own.expressions is not None:
        given = digest_of(given, own.expressions.names, own.expressions.deltas)
    try:
        for number, name in enumerate(order, 1):
            say(f"{name}: reading ({number} of {len(order)})")
            scan = read_scan(named[name], texture=texture)
            made_of = digest_of(given, *scan.content(), marks.on(scan.name))
            pose = kept.get(name)
            if pose is not None and pose.figures.get("made_of") != made_of:
                pose = None
            if name == first:
                # Poses are of this neutral, and of no other.
                given, there = made_of, pose
                pose, person = _first(own, scan, marks, say, there)
                anew = there is None
            elif anew := pose is None:
                pose = _next(person, scan, marks, found[order[number - 2]], say)
            assert pose is not None
            pose = pose.measured(made_of=made_of)
            if anew and output is not None:
                keep_pose(output, name, pose)
            found[name] = pose
            done(name, pose)
    finally:
        if output is not None and found:
            write_figures(output, found)
    _warn({name: own for name, own in found.items() if name != first})
    return {name: found[name] for name in named}


def neutral_person(face: Face, neutral: Source, marks: Marks, texture: bool, say: Say) -> Person:
    """The person of a neutral: one that was registered before, or a scan."""
    if not isinstance(neutral, str | Path):
        require_mesh(neutral, "the neutral")
    mesh = mesh_in(neutral)
    alike = len(mesh.vertices) == len(face.mesh.vertices) and mesh.faces == face.mesh.faces
    if alike or isinstance(mesh, Registered):
        return known_person(face, mesh, marks)
    say(f"{mesh.name}: reading")
    return _first(face, read_scan(mesh, texture=texture), marks, say)[1]


def known_person(face: Face, neutral: Mesh, marks: Marks) -> Person:
    """The person of a neutral that was registered before."""
    require_mesh(neutral, "the neutral")
    require_same_topology(face.mesh, neutral)
    elastic = Elastic(face.vertices, face.triangles, face.size, face.skin)
    expressions = face.expressions
    if expressions is not None:
        expressions = expressions.transferred(neutral.vertices[face.first], elastic)
    placing = None
    if isinstance(neutral, Registered) and "placing" in neutral.figures:
        placing = placing_of(neutral)
    own = elastic.with_rest(neutral.vertices[face.first])
    still = stillness(own, expressions, marks)
    if isinstance(neutral, Registered):
        still = still * ~neutral.flagged[face.first]
    return Person(face, own, expressions, placing, still, {})


def placing_of(pose: Registered) -> Similarity:
    """What brought the scan of a pose to its place."""
    known = pose.figures["placing"]
    return Similarity(known["scale"], np.array(known["rotation"]), np.array(known["shift"]))


def wanted_at(elastic: Elastic, expressions: Expressions | None) -> Points:
    """(V,) how much each vertex is to be looked at: what expressions move most of all."""
    wanted = np.ones(len(elastic.rest))
    if expressions is not None:
        moved = np.linalg.norm(expressions.deltas, axis=2).max(axis=0)
        wanted[moved > 0.005 * elastic.size] = 5.0
    return wanted


def _first(
    face: Face, scan: Scan, marks: Marks, say: Say, kept: Registered | None = None
) -> tuple[Registered, Person]:
    """The neutral, which makes the template a person; or as an earlier run has left it."""
    elastic = Elastic(face.vertices, face.triangles, face.size, face.skin)
    if kept is not None:
        placed = placed_at(scan, placing_of(kept), marks, elastic, elastic.rest)
        vertices = kept.vertices[face.first]
    else:
        say(f"{scan.name}: finding the face")
        placed = placed_first(scan, marks, elastic)
        say(f"{scan.name}: adapting the template")
        start = elastic.rest
        if placed.sure == 1:
            start = elastic.at_landmarks(start, placed.held)
        vertices = elastic.drawn(start, placed.points, ADAPT, placed.held, _ADAPTED * placed.sure)
    trust = trusted(elastic, vertices, placed.points, np.zeros(len(vertices)))
    require_shown(trust, elastic, scan.name)
    require_alike(elastic, vertices, scan.name)
    expressions = face.expressions
    if expressions is not None:
        expressions = expressions.transferred(vertices, elastic)
    own = elastic.with_rest(vertices)
    say(f"{scan.name}: looking at its colours")
    shown = shown_neutral(own, placed, wanted_at(own, expressions))
    held, still = placed.held, stillness(own, expressions, marks) * trust.shown
    clicked = dict(zip(held.vertices.tolist(), held.places - vertices[held.vertices], strict=True))
    person = Person(face, own, expressions, placed.similarity, still, clicked, shown)
    return _registered(person, vertices, trust, placed, THE_TEMPLATE, {}), person


def _next(
    person: Person,
    scan: Scan,
    marks: Marks,
    pose: Registered | None,
    say: Say,
) -> Registered:
    """A further pose, begun from the one before if there is one."""
    elastic, neutral = person.elastic, person.elastic.rest
    expected, before, known = neutral, person.placing, dict[str, float]()
    if pose is not None:
        expected, before = pose.vertices[person.face.first], placing_of(pose)
        known = pose.figures.get("expressions", {})
    say(f"{scan.name}: finding the head")
    placed = placed_next(scan, marks, elastic, expected, before, person.still)
    off = [person.clicked.get(int(own), np.zeros(3)) for own in placed.held.vertices]
    # Where the neutral was clicked beside a vertex, so is the pose.
    placed = replace(placed, held=placed.held.without(off))
    figures: dict[str, Any] = {}
    by_rig = None
    if person.expressions is None:
        say(f"{scan.name}: drawing the neutral onto it")
        # Landmarks of this scan say more than where the pose before has been.
        if len(placed.held.vertices):
            start = elastic.at_landmarks(neutral, placed.held)
        else:
            start = max(neutral, expected, key=lambda own: elastic.explained(own, placed.points))
        vertices = elastic.drawn(start, placed.points, FOLLOW, placed.held, _HELD)
    else:
        say(f"{scan.name}: fitting the rig's expressions")
        fit = person.expressions.fitted(
            neutral, elastic, placed.points, placed.held, known, person.still > 0
        )
        by_rig = person.expressions.posed(neutral, np.array(list(fit.weights.values())))
        figures["expressions"] = {n: round(x, 4) for n, x in fit.weights.items() if x > 1e-3}
        vertices = elastic.with_rest(by_rig).drawn(
            by_rig, placed.points, FINISH, placed.held, _KEPT * fit.sure
        )
    unsure = placed.unsure(vertices) / elastic.size
    along = np.hypot(slide(elastic, vertices, neutral, placed.held, by_rig), unsure)
    figures["head"] = {
        "doubt_degrees": placed.doubt,
        "doubt_mean": 100 * float(unsure[elastic.outer].mean()),
    }
    trust = trusted(elastic, vertices, placed.points, along)
    require_shown(trust, elastic, scan.name)
    if person.shown is not None and placed.scan.skin is not None:
        say(f"{scan.name}: following the skin")
        tracked = followed(person.shown, placed, placed.scan.skin, vertices)
        return _tracked(person, tracked, placed, figures)
    figures["slide_mean"] = 100 * float(along[elastic.outer].mean())
    by = (
        BY_RIG
        if by_rig is not None
        else (BY_LANDMARKS if len(placed.held.vertices) else BY_SURFACE)
    )
    return _registered(person, vertices, trust, placed, by, figures)


def _tracked(
    person: Person, tracked: TrackedPose, placed: Placed, figures: dict[str, Any]
) -> Registered:
    """The pose by the skin's colours."""
    elastic, skin = person.elastic, person.elastic.outer
    # What was not followed well is bent from the neutral, not from where the surface drew it.
    known = np.where(tracked.confidence > _KNOWN, tracked.confidence, 0.0)
    vertices = elastic.completed(tracked.vertices, known**2)
    trust = trusted(elastic, vertices, placed.points, np.zeros(len(skin)))
    # Vertices that were followed tell more exactly than surfaces what of the head is still.
    sure = skin & (tracked.confidence > _SURE)
    still = Similarity.identity()
    if np.count_nonzero(sure) > _ENOUGH:
        reaches = tuple(part * elastic.size for part in _STILL)
        still = robust_rigid(vertices[sure], elastic.rest[sure], reaches)
    spread = tracked.spread[skin & np.isfinite(tracked.spread)]
    figures["views_median"] = float(np.median(tracked.views[skin]))
    figures["spread_mean"] = 100 * float(spread.mean()) / elastic.size if len(spread) else None
    both = replace(trust, confidence=np.minimum(trust.confidence, tracked.confidence))
    placed = replace(placed, similarity=placed.similarity.then(still))
    return _registered(person, still(vertices), both, placed, FOLLOWED, figures)


def _registered(
    person: Person,
    vertices: Points,
    trust: Trust,
    placed: Placed,
    correspondence: str,
    more: Mapping[str, Any],
) -> Registered:
    """The pose with what was measured."""
    moved = placed.similarity
    figures = {
        "scan": Path(placed.scan.name).name,
        "placing": {
            "scale": moved.scale,
            "rotation": moved.rotation.tolist(),
            "shift": moved.shift.tolist(),
        },
        "landmarks": len(placed.held.vertices),
        "correspondence": correspondence,
        **trust.figures(person.face.size),
        **more,
    }
    place = person.face.place
    return Registered.of(person.face.mesh, vertices[place], trust.confidence[place], figures)


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


def _prepared(
    template: Source | Rig, landmarks: str | Path | Landmarks | None
) -> tuple[Face, Marks]:
    """The template and the landmarks, read and checked against each other."""
    found = read_landmarks(landmarks) if isinstance(landmarks, str | Path) else landmarks
    if found is None:
        found = Landmarks()
    if not isinstance(found, Landmarks):
        raise ParameterError(
            f"landmarks are a file or what read_landmarks gives, found {type(landmarks).__name__}"
        )
    face = read_face(template)
    where = str(landmarks) if isinstance(landmarks, str | Path) else "landmarks"
    marks = Marks(face.vertices_of(found.vertices, where), found.points, where)
    if marks.points and not marks.vertices:
        raise FormatError(
            where,
            "it says where landmarks are on scans, but not on the template: place them with"
            " 'elastomorph landmarks --template'",
        )
    return face, marks


def _named(scans: Sequence[Source] | Mapping[str, Source]) -> dict[str, Source]:
    """The scans by the names of their poses."""
    if isinstance(scans, str | Path | Mesh):
        raise ParameterError("expected scans, a list of them or by name; one is for register")
    if isinstance(scans, Mapping):
        pairs = list(scans.items())
    else:
        pairs = [(Path(each.name if isinstance(each, Mesh) else each).stem, each) for each in scans]
    if not pairs:
        raise ParameterError("there is no scan to register")
    found = dict(pairs)
    if len(found) < len(pairs):
        names = [name for name, _ in pairs]
        twice = next(name for name in names if names.count(name) > 1)
        raise ParameterError(f"two scans are called {twice}: poses are named by their files")
    return found


def _which(names: list[str], neutral: str | None) -> str:
    """The name of the neutral."""
    if neutral is None:
        return next((name for name in names if "neutral" in name.lower()), names[0])
    own = Path(neutral).stem if neutral not in names else neutral
    if own not in names:
        raise ParameterError(f"no scan is called {neutral}: there are {', '.join(names)}")
    return own


def _warn(poses: Mapping[str, Registered]) -> None:
    """Say what scans without colours do not tell, and where the head may have moved."""
    blind = {n: own for n, own in poses.items() if own.figures["correspondence"] != FOLLOWED}
    heads = {name: pose.figures["head"] for name, pose in blind.items()}
    if doubted := [name for name, head in heads.items() if head["doubt_mean"] > _MOVED]:
        worst = max(doubted, key=lambda name: heads[name]["doubt_mean"])
        more = f", and those of {len(doubted) - 1} more by less" if len(doubted) > 1 else ""
        warn(
            f"{worst}: its head may be turned by {heads[worst]['doubt_degrees']:.1f}° otherwise,"
            f" which moves skin by {heads[worst]['doubt_mean']:.2f} % of D{more}: too little of it"
            " is still, or is known to be; a rig as the template, or landmarks of eyes and nose,"
            " say what is"
        )
    if blind:
        more = f" and {len(blind) - 1} more" if len(blind) > 1 else ""
        warn(
            f"{next(iter(blind))}{more}: correspondence along the surface was not measured, for the"
            " scans have no colours to follow; a surface distance says nothing about"
            " correspondence, so do not compare paths of such poses with each other"
        )
