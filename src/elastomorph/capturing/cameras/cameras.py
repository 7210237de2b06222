"""Where the camera stood for each photograph of a pose, and what lens it had.

Features of all photographs are found once. The strongest of them are matched between all pairs and
give rough cameras (incremental mapping); then all features are matched where these cameras expect
them, triangulated, and cameras, lens and points are adjusted together. The centre of the lens is
adjusted too where the photographs fix it: photographs are cropped, and lenses sit a little off.

A small reprojection error alone proves nothing: a wrong lens can be made up for by wrong cameras.
So what was found is also held against what is known of photographs and lenses.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from elastomorph.capturing.cameras.exact import cloud, farthest_off, matched, misfits, reprojection
from elastomorph.capturing.cameras.features import Features, find_features, seen_enlarged
from elastomorph.capturing.cameras.focal import Start, found_cameras
from elastomorph.capturing.cameras.late import found_late
from elastomorph.capturing.cameras.matching import Pairs, compared, strongest
from elastomorph.capturing.cameras.plausible import remarks_on, require_plausible
from elastomorph.capturing.cameras.reconstruction import refined
from elastomorph.capturing.cameras.solved import SolvedPose
from elastomorph.capturing.cameras.sparse import Lens, Shots, Sparse
from elastomorph.capturing.geometry.camera import Camera
from elastomorph.capturing.photographs.photographs import FEWEST, Photograph, Photographs
from elastomorph.errors import CaptureError

# Called with what is being done and the part of it that is done, from 0 to 1.
Say = Callable[[str, float], None]

_STRONGEST, _STRONGEST_AGAIN = 1500, 4000
_LEAST_SHARE = 0.6  # of the photographs; where fewer agree, which of them are right is not known
_CENTRE_FROM = 10  # photographs of a lens that were found; fewer do not fix its centre


def solve_pose(
    photographs: Photographs, *, like: SolvedPose | None = None, say: Say = lambda text, part: None
) -> SolvedPose:
    """The cameras of one pose.

    Args:
        photographs: By `examine`.
        like: A pose solved before: lenses that took it too are kept as they were found there.
        say: Called with what is being done and the part of it that is done.

    Raises:
        CaptureError: Too few cameras are found, or what is found cannot be.
        FileError: A photograph is no longer there.
        MissingExtraError: pycolmap is not installed.
    """
    return found_and_solved(photographs, like, say)[1]


def found_and_solved(
    photographs: Photographs, like: SolvedPose | None, say: Say
) -> tuple[dict[str, Features], SolvedPose]:
    """The features of each photograph by its name, and what `solve_pose` makes of them."""
    taken = photographs.taken
    finder = _Finder(photographs, like, say)
    with TemporaryDirectory(prefix="elastomorph-") as place:
        folder = Path(place)
        sparse = finder.rough(folder)
        rejected = dict(photographs.rejected)
        sparse = finder.exact(sparse, folder, rejected)
    require_plausible(photographs.pose, sparse, len(taken))
    remarks = (*photographs.remarks, *remarks_on(sparse, taken))
    solved = _solved(sparse, finder.features, taken, rejected, remarks, finder.shots)
    return dict(zip(finder.shots.names, finder.features, strict=True)), solved


class _Finder:
    """The photographs of one pose on their way to cameras."""

    def __init__(self, photographs: Photographs, like: SolvedPose | None, say: Say) -> None:
        self.photographs = photographs
        self.taken = photographs.taken
        self.say = say
        self.starts, lens_of = _starts(self.taken, like)
        self.lens_of = lens_of
        self.features = self._features(fine=False)

    @property
    def shots(self) -> Shots:
        """The photographs with all of their features."""
        names = [photograph.name for photograph in self.taken]
        return Shots(names, [features.places for features in self.features], self.lens_of)

    def _features(self, *, fine: bool) -> list[Features]:
        count = len(self.taken)
        text = f"features of {count} photographs"
        self.say(text, 0.0)
        return find_features(
            self.taken, fine=fine, done=lambda done: self.say(text, 0.4 * done / count)
        )

    def rough(self, folder: Path) -> Sparse:
        """Cameras from the strongest features; from more of them where few cameras are found."""
        best: Sparse | None = None
        before: list[int] = []
        finer = not all(map(seen_enlarged, self.taken))
        for most, fine in (
            (_STRONGEST, False),
            (_STRONGEST_AGAIN, False),
            *([(_STRONGEST_AGAIN, True)] if finer else []),
        ):
            again = self._features(fine=True) if fine else self.features
            counts = [min(most, len(each)) for each in again]
            if counts == before and not fine:
                continue  # the same features would give the same cameras
            before = counts
            sparse, enough = self._mapped(again, most, folder)
            if sparse is not None and (best is None or sparse.found > best.found):
                best, self.features = sparse, again
            if best is not None and best.found >= enough:
                break
        if best is None or self._too_few(best.found):
            raise CaptureError(_no_overlap(self.photographs, 0 if best is None else best.found))
        return best

    def _too_few(self, found: int) -> bool:
        return found < max(FEWEST, _LEAST_SHARE * len(self.taken))

    def _mapped(
        self, features: list[Features], most: int, folder: Path
    ) -> tuple[Sparse | None, float]:
        chosen = [each.chosen(strongest(each, most)) for each in features]
        looks = [each.unit for each in chosen]
        count = len(looks)
        pairs: Pairs = {}
        for i in range(count):
            self.say("comparing photographs", 0.4 + 0.2 * i / count)
            for j in range(i + 1, count):
                pairs[i, j] = compared(looks[i], looks[j])
        names = [photograph.name for photograph in self.taken]
        shots = Shots(names, [each.places for each in chosen], self.lens_of)
        self.say("finding cameras", 0.6)
        found, enough = found_cameras(
            shots, self.starts, pairs, folder, lambda text: self.say(text, 0.6)
        )
        return None if found is None else found_late(found, chosen, features, shots), enough

    def _free(self, cameras: Sequence[Camera | None]) -> str:
        """What the photographs that were found fix."""
        if all(start.lens for start in self.starts):
            return "cameras"
        found = Counter(lens for c, lens in zip(cameras, self.lens_of, strict=True) if c)
        return "centres" if min(found.values()) >= _CENTRE_FROM else "lenses"

    def exact(self, rough: Sparse, folder: Path, rejected: dict[str, str]) -> Sparse:
        """All features matched where the cameras expect them, and everything adjusted."""
        cameras = rough.cameras
        within = farthest_off(cameras)
        for k, camera in enumerate(cameras):
            if camera is None:
                rejected[self.taken[k].name] = (
                    "too little of it is found in the other photographs: no overlap, blur, or "
                    "another subject"
                )
        self.say("matching all features", 0.75)
        pairs = matched(rough, self.features)
        self.say("adjusting cameras", 0.85)
        free = self._free(cameras)
        sparse = refined(self.shots, cameras, pairs, folder, free=free, within=within)
        bad = misfits(sparse, self.shots)
        if bad:
            rejected.update(bad)
            cameras = tuple(
                None if camera is None or camera.name in bad else camera
                for camera in sparse.cameras
            )
            numbers = {k for k, camera in enumerate(cameras) if camera is not None}
            if self._too_few(len(numbers)):
                raise CaptureError(_no_overlap(self.photographs, len(numbers)))
            pairs = {pair: found for pair, found in pairs.items() if numbers.issuperset(pair)}
            if (fixed := self._free(cameras)) != free:  # a centre moved on the word of the others
                left = zip(rough.cameras, cameras, strict=True)
                free, cameras = fixed, tuple(None if c is None else own for own, c in left)
            sparse = refined(self.shots, cameras, pairs, folder, free=free, within=within)
        return sparse


def _starts(taken: Sequence[Photograph], like: SolvedPose | None) -> tuple[list[Start], list[int]]:
    """What is known of each lens, and the lens of each photograph."""
    known: dict[str, Lens] = {}
    if like is not None:
        for camera in like.cameras:
            known.setdefault(like.lenses.get(camera.name, ""), Lens.of(camera))
    keys = list(dict.fromkeys(photograph.lens for photograph in taken))
    starts = []
    for key in keys:
        mine = [photograph for photograph in taken if photograph.lens == key]
        focals = [photograph.focal for photograph in mine if photograph.focal is not None]
        focal = float(np.median(focals)) if focals else None
        starts.append(Start(mine[0].size, focal, known.get(key)))
    return starts, [keys.index(photograph.lens) for photograph in taken]


def _no_overlap(photographs: Photographs, found: int) -> str:
    return (
        f"pose '{photographs.pose}': the cameras of {found} of {len(photographs.taken)} "
        "photographs are found; neighbouring photographs must show the same skin from directions "
        "at most 20 degrees apart, sharp, and of one subject that holds still"
    )


def _solved(
    sparse: Sparse,
    features: Sequence[Features],
    taken: Sequence[Photograph],
    rejected: dict[str, str],
    remarks: tuple[str, ...],
    shots: Shots,
) -> SolvedPose:
    cameras: list[Camera] = [camera for camera in sparse.cameras if camera is not None]
    points, descriptors = cloud(sparse, features)
    return SolvedPose(
        tuple(cameras),
        points,
        descriptors,
        reprojection(sparse, shots),
        rejected,
        {p.name: p.lens for p, camera in zip(taken, sparse.cameras, strict=True) if camera},
        remarks,
    )
