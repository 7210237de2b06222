"""A rig of cameras that stay where they are: solved once, from the features of several poses.

Cameras are found from the neutral; then features of several poses are put together, camera by
camera, matched only within a pose, and everything is adjusted at once: the cameras are the same,
and see more. A pose is then only triangulated. Rough points come from its strongest features, of
which only those near each other's epipolar lines are matched; they guide the matching of all
others.

Which photographs are from the same camera of a rig: those of one name or number in each pose.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from numpy.typing import NDArray

from elastomorph.capturing.cameras.cameras import Say, found_and_solved, refined
from elastomorph.capturing.cameras.exact import (
    Shots,
    Sparse,
    cloud,
    farthest_off,
    matched,
    misfits,
    reprojection,
)
from elastomorph.capturing.cameras.features import (
    Features,
    Pairs,
    compared,
    find_features,
    neighbours,
    off_lines,
    strongest,
)
from elastomorph.capturing.cameras.models import Given, SolvedPose
from elastomorph.capturing.geometry import Camera, nearest_to_lines
from elastomorph.capturing.photographs import Photograph, Photographs
from elastomorph.errors import CaptureError

LARGEST_SHARE = 0.5
"""Of the photographs of a pose: as many have to be from cameras that took the neutral."""


def same_cameras(poses: Mapping[str, Photographs], neutral: str) -> dict[str, dict[str, str]]:
    """Which photograph of the neutral is from the same camera: pose → photograph → that one's name.

    Args:
        poses: Photographs by pose.
        neutral: Name of the neutral.

    Raises:
        CaptureError: Photographs of a pose are not named or numbered as those of the neutral.
    """
    found = {}
    for key in (_stem, _number):
        named = {key(photograph): photograph.name for photograph in poses[neutral].taken}
        found = {
            pose: {
                photograph.name: named[key(photograph)]
                for photograph in photographs.taken
                if key(photograph) in named
            }
            for pose, photographs in poses.items()
        }
        if len(named) == len(poses[neutral].taken) and all(
            len(set(same.values())) == len(same) >= LARGEST_SHARE * len(poses[pose].taken)
            for pose, same in found.items()
        ):
            return found
    for pose, photographs in poses.items():
        if len(found[pose]) < LARGEST_SHARE * len(photographs.taken):
            raise CaptureError(
                f"pose '{pose}': its photographs are not named or numbered as those of "
                f"'{neutral}' ({photographs.taken[0].name}, {poses[neutral].taken[0].name}), so "
                "which camera took which is not known; name them alike, or leave out --rig fixed"
            )
    raise CaptureError("photographs of one pose have the same number; give each camera its own")


def _stem(photograph: Photograph) -> str:
    return photograph.path.stem.lower()


def _number(photograph: Photograph) -> str:
    numbers = re.findall(r"\d+", photograph.path.stem)
    return numbers[-1].lstrip("0") if numbers else photograph.path.stem.lower()


_STRONGEST = 1500
_MOST_POSES = 4  # more add little to what these say of the cameras
_OFF_LINE = 0.002  # focal lengths; rough points are only to guide
_OWN_LENSES = 0.985  # error with a lens a camera against one lens for all, to keep the former
_OWN_FROM = 500  # points that each camera must see for a lens of its own


def solve_rig(
    poses: Mapping[str, Photographs], neutral: str, *, say: Say = lambda text, part: None
) -> dict[str, SolvedPose]:
    """The neutral's cameras, solved from several poses together, and the neutral's points.

    Args:
        poses: Photographs by pose, by `examine`.
        neutral: Name of the neutral.
        say: Called with what is being done and the part of it that is done.

    Returns:
        The neutral, and each pose that helped to solve it, as `solve_in_rig` has that: the
        features of its photographs are at hand.

    Raises:
        CaptureError: Too few cameras are found, or names do not tell which is which.
    """
    same = same_cameras(poses, neutral)
    known, first = found_and_solved(poses[neutral], None, _part(say, 0.0, 0.4))
    others = [pose for pose in poses if pose != neutral]
    step = max(1, -(-len(others) // (_MOST_POSES - 1)))
    chosen = [neutral, *others[step - 1 :: step]]
    slots = [camera.name for camera in first.cameras]
    union = _Union(slots, [first.lenses[name] for name in slots])
    features = {neutral: [known[slot] for slot in slots]}
    with TemporaryDirectory(prefix="elastomorph-") as place:
        for number, pose in enumerate(chosen):
            said = _part(say, 0.4 + 0.3 * number / len(chosen), 0.3 / len(chosen))
            if pose != neutral:
                features[pose] = _features(_in_slots(poses[pose], same[pose], slots), said)
            union.add(features[pose], _matches(first.cameras, slots, features[pose], Path(place)))
        say("adjusting the rig", 0.7)
        sparse = union.adjusted(first.cameras, Path(place))
    cameras = tuple(camera for camera in sparse.cameras if camera is not None)
    points, descriptors = cloud(union.of_first(sparse), union.first)
    rig = replace(
        first,
        cameras=cameras,
        points=points,
        descriptors=descriptors,
        reprojection=reprojection(sparse, union.shots),
        remarks=(*first.remarks, *union.remarks),
    )
    found = {neutral: rig}
    for number, pose in enumerate(chosen[1:]):
        share = 0.2 / (len(chosen) - 1)
        said = _part(say, 0.8 + number * share, share)
        found[pose] = _before_rig(poses[pose], features[pose], rig, same[pose], said)
    return found


def solve_in_rig(
    photographs: Photographs,
    rig: SolvedPose,
    same: Mapping[str, str],
    *,
    say: Say = lambda text, part: None,
) -> SolvedPose:
    """A pose before cameras that are known: its points, and what each photograph says of them.

    Args:
        photographs: Of the pose.
        rig: By `solve_rig`.
        same: Photograph → that of the neutral from the same camera, by `same_cameras`.
        say: Called with what is being done and the part of it that is done.

    Raises:
        CaptureError: The photographs do not agree with the cameras.
    """
    slots = [camera.name for camera in rig.cameras]
    features = _features(_in_slots(photographs, same, slots), _part(say, 0.0, 0.8))
    return _before_rig(photographs, features, rig, same, _part(say, 0.8, 0.2))


def solve_with(
    photographs: Photographs, given: Given, *, say: Say = lambda text, part: None
) -> SolvedPose:
    """A pose before cameras that are given: its points, and what each photograph says of them.

    Args:
        photographs: Of the pose.
        given: Cameras of them by their names, which stay as they are; of two sets of them, those
            that most matches agree with.
        say: Called with what is being done and the part of it that is done.

    Raises:
        CaptureError: The photographs do not agree with the cameras.
    """
    none = np.zeros((0, 3)), np.zeros((0, 128), dtype=np.float32)
    taken = {photograph.name for photograph in photographs.taken}
    rigs = [SolvedPose(tuple(c for c in own if c.name in taken), *none, {}) for own in given]
    slots = [camera.name for camera in rigs[0].cameras]
    same = {name: name for name in slots}
    features = _features(_in_slots(photographs, same, slots), _part(say, 0.0, 0.8))
    with TemporaryDirectory(prefix="elastomorph-") as place:
        pairs = [_matches(rig.cameras, slots, features, Path(place)) for rig in rigs[1:] and rigs]
    counts = [sum(map(len, own.values())) for own in pairs] or [0]
    rig = rigs[int(np.argmax(counts))]
    return _before_rig(photographs, features, rig, same, _part(say, 0.8, 0.2))


def _before_rig(
    photographs: Photographs,
    features: Sequence[Features],
    rig: SolvedPose,
    same: Mapping[str, str],
    say: Say,
) -> SolvedPose:
    """A pose before cameras that are known, from the features of its photographs by camera."""
    slots = [camera.name for camera in rig.cameras]
    by_slot = _in_slots(photographs, same, slots)
    rejected = dict(photographs.rejected)
    for photograph in photographs.taken:
        if same.get(photograph.name) not in slots:
            rejected[photograph.name] = (
                "its camera was not found in the neutral"
                if rig.reprojection
                else "no camera of it is given"
            )
    names = [slot if (taken := by_slot[slot]) is None else taken.name for slot in slots]
    cameras: list[Camera | None] = [
        None if by_slot[slot] is None else replace(camera, name=name)
        for slot, camera, name in zip(slots, rig.cameras, names, strict=True)
    ]
    shots = Shots(names, [each.places for each in features], list(range(len(slots))))
    within = farthest_off(rig.cameras)
    usual = float(np.median(list(rig.reprojection.values()))) if rig.reprojection else None
    with TemporaryDirectory(prefix="elastomorph-") as place:
        pairs = _matches(cameras, names, features, Path(place))
        for last in (False, True):
            say("triangulating", 0.5 if last else 0.0)
            left = {k for k, camera in enumerate(cameras) if camera is not None}
            if len(left) < max(3, LARGEST_SHARE * len(photographs.taken)):
                raise CaptureError(_moved(photographs, len(left), rig))
            pairs = {pair: found for pair, found in pairs.items() if left.issuperset(pair)}
            sparse = refined(shots, cameras, pairs, Path(place), free="points", within=within)
            bad = misfits(sparse, shots, usual)
            if last or not bad:
                break
            rejected.update(bad)
            cameras = [None if c is None or c.name in bad else c for c in cameras]
    points, descriptors = cloud(sparse, features)
    lenses = {p.name: p.lens for p in photographs.taken}
    return SolvedPose(
        tuple(camera for camera in sparse.cameras if camera is not None),
        points,
        descriptors,
        reprojection(sparse, shots),
        rejected,
        lenses,
        photographs.remarks,
    )


class _Union:
    """Features of several poses, camera by camera, and matches within each."""

    def __init__(self, slots: Sequence[str], lenses: Sequence[str]) -> None:
        self.slots = slots
        keys = list(dict.fromkeys(lenses))
        self.lens_of = [keys.index(lens) for lens in lenses]
        self.first: list[Features] = []
        self.places: list[NDArray[np.float64]] = [np.zeros((0, 2)) for _ in slots]
        self.pairs: dict[tuple[int, int], list[NDArray[np.uint32]]] = {}
        self.remarks: list[str] = []

    @property
    def shots(self) -> Shots:
        """All features as if each camera had taken one photograph."""
        return Shots(self.slots, self.places, self.lens_of)

    def add(self, features: Sequence[Features], pairs: Pairs) -> None:
        """A pose more."""
        if not self.first:
            self.first = list(features)
        before = [len(places) for places in self.places]
        for (i, j), found in pairs.items():
            shift = np.array([before[i], before[j]], dtype=np.uint32)
            self.pairs.setdefault((i, j), []).append(found + shift)
        self.places = [
            np.concatenate([places, each.places])
            for places, each in zip(self.places, features, strict=True)
        ]

    def adjusted(self, cameras: Sequence[Camera], folder: Path) -> Sparse:
        """The cameras from all poses; each with a lens of its own where that explains more."""
        pairs = {pair: np.concatenate(found) for pair, found in self.pairs.items()}
        within = farthest_off(cameras)
        shots = self.shots
        one = refined(shots, cameras, pairs, folder, free="centres", within=within)
        seen = np.bincount(one.seen[:, 0], minlength=len(cameras))
        if seen.min() < _OWN_FROM or len(set(self.lens_of)) == len(cameras):
            return one
        self.lens_of = list(range(len(cameras)))
        own = refined(self.shots, one.cameras, pairs, folder, free="centres", within=within)
        if own.error < _OWN_LENSES * one.error:
            self.remarks.append("each camera has a lens of its own")
            return own
        self.lens_of = list(shots.lens_of)
        return one

    def of_first(self, sparse: Sparse) -> Sparse:
        """The points of the first pose alone."""
        counts = np.array([len(each) for each in self.first])
        mine = sparse.seen[:, 1] < counts[sparse.seen[:, 0]]
        points, owners = np.unique(sparse.owners[mine], return_inverse=True)
        return Sparse(
            sparse.cameras,
            sparse.points[points],
            sparse.errors[points],
            owners.astype(np.int64),
            sparse.seen[mine],
        )


def _moved(photographs: Photographs, left: int, rig: SolvedPose) -> str:
    whose = (
        "of the neutral; if cameras were moved, leave out --rig fixed"
        if rig.reprojection
        else "that are given; leave out --cameras to have them found"
    )
    return (
        f"pose '{photographs.pose}': {left} of {len(photographs.taken)} photographs agree with the "
        f"cameras {whose}"
    )


def _matches(
    cameras: Sequence[Camera | None],
    names: Sequence[str],
    features: Sequence[Features],
    folder: Path,
) -> Pairs:
    """Matches of all features of a pose before known cameras."""
    chosen = [each.chosen(strongest(each, _STRONGEST)) for each in features]
    looks = [each.unit for each in chosen]
    pairs: Pairs = {}
    for i, j in neighbours(cameras, looked_at(cameras)):
        one, other = cameras[i], cameras[j]
        if one is None or other is None:
            continue
        found = compared(looks[i], looks[j])
        off = off_lines(one, other, chosen[i].places[found[:, 0]], chosen[j].places[found[:, 1]])
        pairs[i, j] = found[off < _OFF_LINE]
    shots = Shots(names, [each.places for each in chosen], list(range(len(names))))
    within = 2 * farthest_off(cameras)
    rough = refined(shots, cameras, pairs, folder, free="points", within=within)
    return matched(rough, features) if len(rough.points) else {}


def looked_at(cameras: Sequence[Camera | None]) -> NDArray[np.float64]:
    """The point nearest to the axes of all cameras, (3,)."""
    known = [camera for camera in cameras if camera is not None]
    places = np.array([camera.position for camera in known])
    return nearest_to_lines(places, np.array([camera.rotation[2] for camera in known]))


def _in_slots(
    photographs: Photographs, same: Mapping[str, str], slots: Sequence[str]
) -> dict[str, Photograph | None]:
    """The photograph of each camera, None where the pose has none."""
    found = {same[p.name]: p for p in photographs.taken if p.name in same}
    return {slot: found.get(slot) for slot in slots}


def _features(by_slot: Mapping[str, Photograph | None], say: Say) -> list[Features]:
    """Features of the photograph of each camera, none where there is no photograph."""
    taken = [photograph for photograph in by_slot.values() if photograph is not None]
    text = f"features of {len(taken)} photographs"
    found = iter(find_features(taken, done=lambda done: say(text, done / len(taken))))
    none = Features(
        np.zeros((0, 2)), np.zeros((0, 4), dtype=np.float32), np.zeros((0, 128), dtype=np.uint8)
    )
    return [none if photograph is None else next(found) for photograph in by_slot.values()]


def _part(say: Say, start: float, share: float) -> Say:
    return lambda text, part: say(text, start + share * part)
