"""Cameras and points from matches, by pycolmap: what is handed to it and what it hands back.

Incremental mapping finds cameras of which nothing is known but a focal length to start from;
triangulation and bundle adjustment refine those that are known roughly. Two threads add numbers in
no fixed order: results agree to about ten digits from one run to the next, and seeds are fixed.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.capturing.cameras.features import quiet_pycolmap
from elastomorph.capturing.cameras.matching import Pairs
from elastomorph.capturing.cameras.sparse import Lens, Shots, Sparse
from elastomorph.capturing.geometry.camera import Camera

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
