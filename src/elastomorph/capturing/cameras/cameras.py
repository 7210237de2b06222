"""Where the camera stood for each photograph of a pose, and what lens it had.

Features of all photographs are found once. The strongest of them are matched between all pairs and
give rough cameras (incremental mapping); then all features are matched where these cameras expect
them, triangulated, and cameras, lens and points are adjusted together. The centre of the lens is
adjusted too where the photographs fix it: photographs are cropped, and lenses sit a little off.

A small reprojection error alone proves nothing: a wrong lens can be made up for by wrong cameras.
So what was found is also held against what is known of photographs and lenses.

Cameras from matches whatever is known of the focal length: by EXIF, fixed, or found by trying.

Started from a focal length that is wrong by a third, mapping finds few cameras or none. Where EXIF
gives none, or few cameras are found with the one it gives, several are tried, from that of a phone
to that of a portrait lens; the one with which most cameras are found is taken, and among those the
one that leaves the smallest errors.

What solved cameras are held against beside their reprojection error.

Wrong lenses and wrong cameras can agree with each other to half a pixel. What gives them away is
what photographs of a head are like: the lens of EXIF, an axis near the middle of the photograph,
little distortion, cameras around the head that look at it, and points in front of them.

Cameras of photographs that mapping passed over, from the points that the others see.

Mapping goes from photograph to photograph by their strongest features. One of which only weaker
ones are found again, at the end of a ring or a little blurred, has all of its features compared
with the points themselves.

Cameras and points from matches, by pycolmap: what is handed to it and what it hands back.

Incremental mapping finds cameras of which nothing is known but a focal length to start from;
triangulation and bundle adjustment refine those that are known roughly. Two threads add numbers in
no fixed order: results agree to about ten digits from one run to the next, and seeds are fixed.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.capturing.cameras.exact import (
    Lens,
    Shots,
    Sparse,
    cloud,
    farthest_off,
    matched,
    misfits,
    reprojection,
    well_seen,
)
from elastomorph.capturing.cameras.features import (
    Features,
    Pairs,
    compared,
    find_features,
    quiet_pycolmap,
    seen_enlarged,
    strongest,
)
from elastomorph.capturing.cameras.models import SolvedPose
from elastomorph.capturing.geometry import Camera
from elastomorph.capturing.photographs import FEWEST, Photograph, Photographs
from elastomorph.errors import CaptureError

_MODEL = "SIMPLE_RADIAL"
_THREADS = 2
_SEED = 1
_FEWEST_MATCHES = 15
_LEAST_ANGLE = 1.5  # degrees between the rays to a point
_ROUNDS, _STEPS, _LAST_STEPS = 3, 8, 30


def verified(
    shots: Shots, lenses: Sequence[Lens], pairs: Pairs, *, known: bool
) -> tuple[Pairs, dict[tuple[int, int], Any]]:
    """Matches that one motion of the camera explains, and pycolmap's geometry of each pair.

    Args:
        shots: The photographs.
        lenses: Of them.
        pairs: Matches.
        known: Whether focal lengths are known at least roughly.
    """
    kept: Pairs = {}
    geometries: dict[tuple[int, int], Any] = {}
    with quiet_pycolmap() as pycolmap:
        options = pycolmap.TwoViewGeometryOptions()
        options.ransac.random_seed = _SEED
        cameras = [pycolmap_camera(pycolmap, k, lens, known=known) for k, lens in enumerate(lenses)]
        for (i, j), matches in pairs.items():
            if len(matches) < _FEWEST_MATCHES:
                continue
            geometry = pycolmap.estimate_two_view_geometry(
                cameras[shots.lens_of[i]],
                shots.places[i] + 0.5,
                cameras[shots.lens_of[j]],
                shots.places[j] + 0.5,
                matches,
                options,
            )
            inliers = np.asarray(geometry.inlier_matches, dtype=np.uint32).reshape(-1, 2)
            if len(inliers) >= _FEWEST_MATCHES:
                kept[i, j] = inliers
                geometries[i, j] = geometry
    return kept, geometries


def mapped(
    shots: Shots,
    lenses: Sequence[Lens],
    geometries: dict[tuple[int, int], Any],
    folder: Path,
    *,
    fixed: bool = False,
) -> Sparse | None:
    """Cameras found one after the other, from nothing but matches; None where none were.

    Args:
        shots: The photographs.
        lenses: Of them, to start from.
        geometries: Of pairs, by `verified`.
        folder: For files that are no longer needed afterwards.
        fixed: Keep the lenses as they are.
    """
    with quiet_pycolmap() as pycolmap:
        database = _written(pycolmap, shots, lenses, geometries, folder / "mapped.db")
        options = pycolmap.IncrementalPipelineOptions()
        options.num_threads = _THREADS
        options.random_seed = _SEED
        options.multiple_models = False
        options.extract_colors = False
        options.min_model_size = 3
        options.ba_refine_principal_point = False
        options.ba_refine_focal_length = not fixed
        options.ba_refine_extra_params = not fixed
        options.mapper.abs_pose_refine_focal_length = not fixed
        options.mapper.abs_pose_refine_extra_params = not fixed
        found = pycolmap.incremental_mapping(database, folder, folder, options)
        if not found:
            return None
        return _read(max(found.values(), key=lambda r: int(r.num_reg_images())), shots)


def refined(
    shots: Shots,
    cameras: Sequence[Camera | None],
    pairs: Pairs,
    folder: Path,
    *,
    free: str,
    within: float,
) -> Sparse:
    """Points triangulated from matches of known cameras, and both adjusted to each other.

    Args:
        shots: The photographs.
        cameras: Of them, roughly; None where unknown.
        pairs: Matches, found with these cameras.
        folder: For files that are no longer needed afterwards.
        free: What is adjusted beside the points: "centres" (lenses, their centres and cameras),
            "lenses" (without their centres), "cameras" or "points" (nothing else).
        within: Farthest that a feature may be from where its point is seen, px.
    """
    known = {shots.lens_of[k]: Lens.of(c) for k, c in enumerate(cameras) if c is not None}
    some = next(iter(known.values()))  # For lenses that took nothing of use
    lenses = [known.get(number, some) for number in range(max(shots.lens_of) + 1)]
    with quiet_pycolmap() as pycolmap:
        geometries = {pair: _geometry(pycolmap, m) for pair, m in pairs.items() if len(m)}
        database = _written(pycolmap, shots, lenses, geometries, folder / "refined.db")
        world = _reconstruction(pycolmap, shots, lenses, cameras)
        options = pycolmap.IncrementalPipelineOptions()
        options.num_threads = _THREADS
        options.random_seed = _SEED
        options.extract_colors = False
        world = pycolmap.triangulate_points(world, database, folder, folder, True, options)
        adjusting = _adjustment(pycolmap, free)
        adjusting.ceres.solver_options.max_num_iterations = _STEPS
        # Triangulation leaves what four pixels allow; wrong matches go before they can pull.
        for limit in np.geomspace(2.0 * within, within, _ROUNDS):
            _adjusted(pycolmap, world, adjusting)
            pycolmap.ObservationManager(world).filter_all_points3D(float(limit), _LEAST_ANGLE)
        adjusting.ceres.solver_options.max_num_iterations = _LAST_STEPS
        _adjusted(pycolmap, world, adjusting)
        world.update_point_3d_errors()
        return _read(world, shots)


def _adjusted(pycolmap: Any, world: Any, options: Any) -> None:
    # Its own bundle_adjustment writes to the terminal whatever it is told.
    config = pycolmap.BundleAdjustmentConfig()
    for number in world.reg_image_ids():
        config.add_image(number)
    config.fix_gauge(pycolmap.BundleAdjustmentGauge.TWO_CAMS_FROM_WORLD)
    pycolmap.create_default_bundle_adjuster(options, config, world).solve()


def _adjustment(pycolmap: Any, free: str) -> Any:
    options = pycolmap.BundleAdjustmentOptions()
    options.print_summary = False
    options.refine_focal_length = options.refine_extra_params = free in ("centres", "lenses")
    options.refine_principal_point = free == "centres"
    options.refine_rig_from_world = free != "points"
    options.ceres.loss_function_type = pycolmap.LossFunctionType.SOFT_L1
    options.ceres.solver_options.num_threads = _THREADS
    options.ceres.solver_options.function_tolerance = 1e-7
    return options


def pycolmap_camera(pycolmap: Any, number: int, lens: Lens, *, known: bool) -> Any:
    """A lens as pycolmap has it, counted from 1 there."""
    width, height = lens.size
    model = getattr(pycolmap.CameraModelId, _MODEL)
    camera = pycolmap.Camera.create_from_model_id(number + 1, model, lens.focal, width, height)
    camera.params = lens.parameters
    camera.has_prior_focal_length = known
    return camera


def _geometry(pycolmap: Any, matches: NDArray[np.uint32]) -> Any:
    """Of matches found along known epipolar lines: nothing is left to verify."""
    geometry = pycolmap.TwoViewGeometry()
    geometry.config = pycolmap.TwoViewGeometryConfiguration.CALIBRATED
    geometry.inlier_matches = matches
    return geometry


def _written(
    pycolmap: Any, shots: Shots, lenses: Sequence[Lens], geometries: dict[Any, Any], path: Path
) -> Path:
    """A new database of features and matches; photographs are counted from 1 there."""
    path.unlink(missing_ok=True)
    database = pycolmap.Database.open(path)
    try:
        with pycolmap.DatabaseTransaction(database):
            for k, lens in enumerate(lenses):
                camera = pycolmap_camera(pycolmap, k, lens, known=True)
                database.write_camera(camera, True)
                rig = pycolmap.Rig()
                rig.rig_id = k + 1
                rig.add_ref_sensor(camera.sensor_id)
                database.write_rig(rig, True)
            for k, name in enumerate(shots.names):
                number = shots.lens_of[k] + 1
                image = pycolmap.Image(name=name, camera_id=number, image_id=k + 1)
                database.write_image(image, True)
                frame = pycolmap.Frame()
                frame.frame_id = k + 1
                frame.rig_id = number
                frame.add_data_id(image.data_id)
                database.write_frame(frame, True)
                database.write_keypoints(k + 1, (shots.places[k] + 0.5).astype(np.float32))
            for (i, j), geometry in geometries.items():
                database.write_matches(i + 1, j + 1, geometry.inlier_matches)
                database.write_two_view_geometry(i + 1, j + 1, geometry)
    finally:
        database.close()
    return path


def _reconstruction(
    pycolmap: Any, shots: Shots, lenses: Sequence[Lens], cameras: Sequence[Camera | None]
) -> Any:
    world = pycolmap.Reconstruction()
    for k, lens in enumerate(lenses):
        world.add_camera_with_trivial_rig(pycolmap_camera(pycolmap, k, lens, known=True))
    for k, camera in enumerate(cameras):
        if camera is None:
            continue
        image = pycolmap.Image(name=shots.names[k], camera_id=shots.lens_of[k] + 1, image_id=k + 1)
        matrix = np.concatenate([camera.rotation, camera.translation[:, None]], axis=1)
        world.add_image_with_trivial_frame(image, pycolmap.Rigid3d(matrix))
    return world


def _read(world: Any, shots: Shots) -> Sparse:
    cameras: list[Camera | None] = [None] * len(shots.names)
    for number in world.reg_image_ids():
        image = world.images[number]
        taken = world.cameras[image.camera_id]
        focal, x, y, radial = taken.params
        matrix = image.cam_from_world().matrix()
        cameras[number - 1] = Camera(
            shots.names[number - 1],
            (int(taken.width), int(taken.height)),
            float(focal),
            np.array([x, y]) - 0.5,
            float(radial),
            np.array(matrix[:, :3]),
            np.array(matrix[:, 3]),
        )
    points, errors, owners, seen = [], [], [], []
    for k, number in enumerate(sorted(world.points3D)):
        point = world.points3D[number]
        points.append(point.xyz)
        errors.append(point.error)
        for element in point.track.elements:
            owners.append(k)
            seen.append((element.image_id - 1, element.point2D_idx))
    return Sparse(
        tuple(cameras),
        np.array(points, dtype=np.float64).reshape(-1, 3),
        np.array(errors, dtype=np.float64),
        np.array(owners, dtype=np.int64),
        np.array(seen, dtype=np.int64).reshape(-1, 2),
    )


_FEWEST, _LEAST_SHARE_LATE = 20, 0.25
_OFF = 0.003  # focal lengths


def found_late(
    sparse: Sparse, chosen: Sequence[Features], features: Sequence[Features], shots: Shots
) -> Sparse:
    """With the cameras of photographs that were passed over, where points say where they are.

    Args:
        sparse: Cameras and points.
        chosen: The features of each photograph that were mapped.
        features: All of them.
        shots: The photographs.
    """
    missing = [k for k, camera in enumerate(sparse.cameras) if camera is None]
    if not missing or not len(sparse.points):
        return sparse
    numbers = np.flatnonzero(well_seen(sparse))
    points, looks = cloud(sparse, chosen)
    cameras = list(sparse.cameras)
    owners, seen = [sparse.owners], [sparse.seen]
    for k in missing:
        lens = _lens(sparse, shots, k)
        pairs = compared(features[k].unit, looks)
        if lens is None or len(pairs) < _FEWEST:
            continue
        places = features[k].places[pairs[:, 0]]
        camera, agree = _placed(shots.names[k], lens, places, points[pairs[:, 1]])
        if camera is None or np.count_nonzero(agree) < max(_FEWEST, _LEAST_SHARE_LATE * len(pairs)):
            continue
        cameras[k] = camera
        mine = pairs[agree].astype(np.int64)
        owners.append(numbers[mine[:, 1]])
        seen.append(np.stack([np.full(len(mine), k), mine[:, 0]], axis=1))
    return replace(
        sparse, cameras=tuple(cameras), owners=np.concatenate(owners), seen=np.concatenate(seen)
    )


def _lens(sparse: Sparse, shots: Shots, photograph: int) -> Lens | None:
    for k, camera in enumerate(sparse.cameras):
        if camera is not None and shots.lens_of[k] == shots.lens_of[photograph]:
            return Lens.of(camera)
    return None


def _placed(
    name: str, lens: Lens, places: NDArray[np.float64], points: NDArray[np.float64]
) -> tuple[Camera | None, NDArray[np.bool_]]:
    """A camera that sees points at places, and which of them agree."""
    with quiet_pycolmap() as pycolmap:
        options = pycolmap.AbsolutePoseEstimationOptions()
        options.ransac.random_seed = 1
        options.ransac.max_error = _OFF * lens.focal
        camera = pycolmap_camera(pycolmap, 0, lens, known=True)
        found = pycolmap.estimate_and_refine_absolute_pose(places + 0.5, points, camera, options)
    if found is None:
        return None, np.zeros(len(places), dtype=bool)
    matrix = found["cam_from_world"].matrix()
    turn, shift = np.array(matrix[:, :3]), np.array(matrix[:, 3])
    camera_of = Camera(name, lens.size, lens.focal, lens.centre, lens.radial, turn, shift)
    return camera_of, np.asarray(found["inlier_mask"], dtype=bool)


_FEWEST_POINTS = 200
_WIDEST_ANGLE, _LEAST_SPAN = 60.0, 15.0  # degrees
_OFF_CENTRE, _CROPPED = 0.25, 0.04  # of the longer side
_MOST_DISTORTION = 0.35  # at the corner
_FOCAL_OFF = 0.12
_ERROR, _AT_SIZE = 1.2, 2000  # px mean in a photograph of this longer side


def require_plausible(pose: str, sparse: Sparse, given: int) -> None:
    """Refuse cameras that cannot be.

    Raises:
        CaptureError: And why.
    """
    cameras = [camera for camera in sparse.cameras if camera is not None]
    if len(cameras) < min(FEWEST, given) or len(sparse.points) < _FEWEST_POINTS:
        raise CaptureError(
            f"pose '{pose}': only {len(cameras)} cameras and {len(sparse.points)} points are "
            "found; take more photographs, closer to each other, of skin that is sharp"
        )
    span = spanned(sparse)
    if span < _LEAST_SPAN:
        raise CaptureError(
            f"pose '{pose}': all photographs are taken from within {span:.0f} degrees of each "
            "other; walk around the face, from one ear to the other"
        )
    for camera in cameras:
        longest = max(camera.size)
        off = camera.centre - (np.array(camera.size) - 1) / 2
        corner = float(np.hypot(*camera.size)) / 2 / camera.focal
        if abs(off).max() > _OFF_CENTRE * longest or abs(camera.radial) * corner**2 > (
            _MOST_DISTORTION
        ):
            raise CaptureError(
                f"pose '{pose}': no lens has what was found for {camera.name} (focal length "
                f"{camera.focal:,.0f} px, axis {abs(off).max():,.0f} px off the middle, distortion "
                f"{camera.radial:.2f}); give original photographs, neither cropped nor corrected, "
                "all with the same lens and zoom"
            )


def remarks_on(sparse: Sparse, taken: Sequence[Photograph]) -> Iterator[str]:
    """What is unusual in cameras that may be right."""
    told = set()
    for photograph, camera in zip(taken, sparse.cameras, strict=True):
        if camera is None or photograph.lens in told:
            continue
        told.add(photograph.lens)
        longest = max(camera.size)
        if photograph.focal and abs(camera.focal / photograph.focal - 1) > _FOCAL_OFF:
            yield (
                f"the focal length is {camera.focal:,.0f} px; the EXIF of {photograph.name} says "
                f"{photograph.focal:,.0f} px and was not followed"
            )
        off = camera.centre - (np.array(camera.size) - 1) / 2
        if abs(off).max() > _CROPPED * longest:
            yield (
                f"the axis of the lens is {off[0]:+.0f}, {off[1]:+.0f} px from the middle: the "
                "photographs may be cropped, or turned without their EXIF"
            )
    longest = max(max(photograph.size) for photograph in taken)
    limit = _ERROR * max(0.5, longest / _AT_SIZE)
    if sparse.error > limit:
        yield (
            f"features are {sparse.error:.2f} px from where they should be, {limit:.1f} px is "
            "usual: the face moved between photographs, or the focus changed"
        )
    span = spanned(sparse)
    if span < _WIDEST_ANGLE:
        yield f"the photographs span {span:.0f} degrees only; the sides of the face will lack"


def spanned(sparse: Sparse) -> float:
    """Largest angle between two cameras, seen from the middle of the points, in degrees."""
    middle: NDArray[np.float64] = np.median(sparse.points, axis=0)
    places = [camera.position for camera in sparse.cameras if camera is not None]
    away = np.array(places) - middle
    away /= np.linalg.norm(away, axis=1, keepdims=True)
    return float(np.degrees(np.arccos(np.clip(away @ away.T, -1.0, 1.0).min())))


# Focal lengths in longer sides of the photograph: 43, 28, 61, 86 and 122 mm on 35-mm film.
_LADDER = (1.2, 0.78, 1.7, 2.4, 3.4)
_ENOUGH = 0.9  # of the photographs that have something in common with others
# Matches of a photograph against those of the middle one; with fewer, blurred or of something else,
# no lens would place it.
_IN_COMMON = 0.25


@dataclass(frozen=True)
class Start:
    """What is known of a lens: its photographs' size, a focal length in px, and if that is sure."""

    size: tuple[int, int]
    focal: float | None
    lens: Lens | None = None  # Known already, and kept

    def as_lens(self, ratio: float) -> Lens:
        """The lens, with this focal length in longer sides where none is known."""
        if self.lens is not None:
            return self.lens
        return Lens.plain(self.size, self.focal or ratio * max(self.size))


def found_cameras(
    shots: Shots,
    starts: Sequence[Start],
    pairs: Pairs,
    folder: Path,
    say: Callable[[str], None],
) -> tuple[Sparse | None, float]:
    """The cameras that most photographs agree on, None where none are found, and how many would do.

    Args:
        shots: The photographs.
        starts: What is known of each lens.
        pairs: Matches of them.
        folder: For files that are no longer needed afterwards.
        say: Told what is tried.
    """
    known = all(start.lens or start.focal for start in starts)
    fixed = all(start.lens for start in starts)
    lenses = [start.as_lens(_LADDER[0]) for start in starts]
    kept, geometries = verified(shots, lenses, pairs, known=known)
    in_common = np.zeros(len(shots.names))
    for pair, matches in kept.items():
        in_common[list(pair)] += len(matches)
    enough = _ENOUGH * np.count_nonzero(in_common >= _IN_COMMON * np.median(in_common))
    best: Sparse | None = None
    if known:
        best = mapped(shots, lenses, geometries, folder, fixed=fixed)
        if fixed or (best is not None and best.found >= enough):
            return best, enough
    for ratio in _LADDER:
        say(f"trying a focal length of {ratio:g} times the longer side")
        # What EXIF says did not do, where it said anything.
        lenses = [Start(start.size, None, start.lens).as_lens(ratio) for start in starts]
        _, again = verified(shots, lenses, kept, known=True)
        best = _better(best, mapped(shots, lenses, again, folder))
    return best, enough


def _better(one: Sparse | None, other: Sparse | None) -> Sparse | None:
    """That with more cameras; of as many, that with smaller errors."""
    if one is None or other is None:
        return other if one is None else one

    def merit(sparse: Sparse) -> tuple[Any, ...]:
        return sparse.found, -sparse.error

    return max(one, other, key=merit)


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
