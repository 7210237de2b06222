"""Cameras of other programs: pycolmap reads what is written, and what it writes is read."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from spotted import cameras as spotted_cameras

import elastomorph as em
from elastomorph.capturing.cameras.fixed_rig import solve_with
from elastomorph.capturing.cameras.models import (
    given_cameras,
    write_bundler,
    write_colmap,
)
from elastomorph.capturing.geometry import Camera
from elastomorph.capturing.photographs import examine, find_poses, read_upright
from elastomorph.errors import CaptureError, FileError, FormatError
from needs import extra

extra("pycolmap", "capture")

import pycolmap  # noqa: E402

SIZE = (750, 1000)
CAMERAS = spotted_cameras(7)
POINTS = np.random.default_rng(2).normal(size=(40, 3)) * 6
STATUE = Path(os.environ.get("ELASTOMORPH_DATA", "../shared/data")) / "photos" / "saharov32"


def photographs(
    folder: Path, count: int = 7, size: tuple[int, int] = SIZE
) -> dict[str, list[Path]]:
    """Files of a pose that are as large as they should be."""
    folder.mkdir(parents=True, exist_ok=True)
    files = [folder / f"{k:02d}.jpg" for k in range(count)]
    for file in files:
        Image.new("L", size).save(file)
    return {folder.name: files}


def centred() -> list[Camera]:
    """Cameras as Bundler can have them."""
    return [replace(camera, centre=(np.array(SIZE) - 1) / 2) for camera in CAMERAS]


def assert_same(found: Camera, true: Camera, tolerance: float = 1e-12) -> None:
    assert (found.name, found.size) == (true.name, true.size)
    for name in ("focal", "radial", "centre", "rotation", "translation"):
        expected = getattr(true, name)
        np.testing.assert_allclose(getattr(found, name), expected, rtol=tolerance, atol=tolerance)


def seen_by_pycolmap(model: object, name: str, points: np.ndarray) -> np.ndarray:
    """(N, 2) pixels of points, their centres at integers."""
    image = next(each for each in model.images.values() if Path(each.name).name == name)  # type: ignore[attr-defined]
    camera = model.cameras[image.camera_id]  # type: ignore[attr-defined]
    matrix = image.cam_from_world().matrix()
    local = points @ matrix[:, :3].T + matrix[:, 3]
    return np.array(camera.img_from_cam(local)) - 0.5


def test_pycolmap_reads_what_is_written(tmp_path: Path) -> None:
    """An independent reader puts every point on the same pixel, distortion and all."""
    write_colmap(tmp_path / "model", CAMERAS, POINTS)
    model = pycolmap.Reconstruction(tmp_path / "model")
    assert (model.num_reg_images(), model.num_points3D()) == (7, 40)
    assert len(model.cameras) == 1  # they share one lens
    for camera in CAMERAS:
        ours = camera.distorted(camera.project(POINTS)[0])
        np.testing.assert_allclose(seen_by_pycolmap(model, camera.name, POINTS), ours, atol=1e-8)
    found = np.array([model.points3D[k + 1].xyz for k in range(40)])
    np.testing.assert_array_equal(found, POINTS)


@pytest.mark.parametrize(
    ("model", "values", "within"),
    [
        ("SIMPLE_PINHOLE", [1300, 390, 460], 1e-8),
        ("PINHOLE", [1300, 1300, 390, 460], 1e-8),
        ("PINHOLE", [1300, 1300.8, 390, 460], 0.5),
        ("SIMPLE_RADIAL", [1300, 390, 460, -0.04], 1e-8),
        ("RADIAL", [1300, 390, 460, -0.04, 0.0], 1e-8),
        ("RADIAL", [1300, 390, 460, -0.12, 0.03], 0.5),
        ("OPENCV", [1300, 1300.5, 390, 460, -0.1, 0.03, 2e-4, -1e-4], 0.5),
    ],
)
def test_models_that_pycolmap_writes_are_read(
    tmp_path: Path, model: str, values: list[float], within: float
) -> None:
    """Points are on the same pixels, as nearly as one radial term can have them."""
    there = pycolmap.Reconstruction()
    kind = getattr(pycolmap.CameraModelId, model)
    lens = pycolmap.Camera.create_from_model_id(1, kind, 1300.0, *SIZE)
    lens.params = values
    there.add_camera_with_trivial_rig(lens)
    for k, camera in enumerate(CAMERAS, start=1):
        image = pycolmap.Image(name=f"smile/{camera.name}", camera_id=1, image_id=k)
        matrix = np.concatenate([camera.rotation, camera.translation[:, None]], axis=1)
        there.add_image_with_trivial_frame(image, pycolmap.Rigid3d(matrix))
    (tmp_path / "model").mkdir()
    there.write_text(tmp_path / "model")
    poses = photographs(tmp_path / "smile")
    found = given_cameras(tmp_path / "model", poses, "smile", fixed=False)["smile"][0]
    assert [camera.name for camera in found] == [camera.name for camera in CAMERAS]
    for camera in found:
        ours = camera.distorted(camera.project(POINTS)[0])
        theirs = seen_by_pycolmap(there, camera.name, POINTS)
        inside = camera.inside(theirs)
        assert inside.sum() > 20
        off = np.linalg.norm(ours - theirs, axis=1)[inside]
        assert off.max() < within
        assert within < 0.1 or off.max() > 1e-3


@pytest.mark.parametrize("write", [write_colmap, write_bundler])
def test_what_is_written_is_read_as_it_was(tmp_path: Path, write: Callable[..., None]) -> None:
    place = tmp_path / ("model" if write is write_colmap else "model.out")
    true = CAMERAS if write is write_colmap else centred()
    write(place, true, POINTS)
    found = given_cameras(place, photographs(tmp_path / "smile"), "smile", fixed=False)["smile"][0]
    for camera, expected in zip(found, true, strict=True):
        assert_same(camera, expected)


def test_bundlers_files_say_what_its_manual_says(tmp_path: Path) -> None:
    """p = −P₀₁ / P₂ of P = R X + t, at f r(p) p from the middle, y upwards."""
    write_bundler(tmp_path / "model.out", centred(), POINTS)
    lines = (tmp_path / "model.out").read_text().splitlines()
    assert lines[:2] == ["# Bundle file v0.3", "7 40"]
    for k, camera in enumerate(centred()):
        (f, k1, k2), *rows = (list(map(float, row.split())) for row in lines[2 + 5 * k : 7 + 5 * k])
        local = POINTS @ np.array(rows[:3]).T + rows[3]
        p = -local[:, :2] / local[:, 2:]
        far = (p**2).sum(axis=1, keepdims=True)
        theirs = f * (1 + k1 * far + k2 * far**2) * p
        ours = camera.distorted(camera.project(POINTS)[0]) - (np.array(SIZE) - 1) / 2
        np.testing.assert_allclose(theirs * [1, -1], ours, atol=1e-9)


def test_bundlers_files_have_the_axis_in_the_middle(tmp_path: Path) -> None:
    with pytest.raises(CaptureError, match=r"00\.jpg is 45\.0 px off the middle"):
        write_bundler(tmp_path / "model.out", CAMERAS, POINTS)
    assert not list(tmp_path.iterdir())


OPENCV = "1 OPENCV 750 1000 1300 1300 375 500 {}\n"
LENS = "1 SIMPLE_RADIAL 750 1000 1300 375 500 -.04\n"
IMAGE = "{0} 1 0 0 0 0 0 50 1 {0:02d}.jpg\n\n"
ALL = "".join(map(IMAGE.format, range(7)))
REFUSED = [
    ("1 FULL_OPENCV 750 1000 1 1 1 1 0 0 0 0 0 0 0 0\n", ALL, "line 1: lenses of the model FULL"),
    ("1 OPENCV_FISHEYE 750 1000 1 1 1 1 0 0 0 0\n", ALL, "undistort the photographs, or"),
    (OPENCV.format("-.3 .9 0 0"), ALL, r"one radial term is \d+\.\d px off the distortion of 00"),
    (OPENCV.format("0 0 .01 0"), ALL, r"one radial term is \d+\.\d px off"),
    (OPENCV.replace("1300 1300", "1300 1390").format("0 0 0 0"), ALL, "one radial term is"),
    (LENS.replace("750 1000", "1000 750"), ALL, "1000 × 750 pixels there and 750 × 1000 here"),
    (LENS.replace("1300", "-1300"), ALL, "line 1: expected CAMERA_ID MODEL"),
    (LENS.replace("1300", "nan"), ALL, "line 1: expected CAMERA_ID MODEL"),
    (LENS.replace("-.04", ""), ALL, "line 1: expected CAMERA_ID MODEL"),
    (LENS.replace("-.04", "-.04 0"), ALL, "line 1: expected CAMERA_ID MODEL"),
    (LENS, ALL.replace("1 0 0 0 0 0 50 1 05", "1 0 0 0 0 0 50 2 05"), "line 11: expected IMAGE_ID"),
    (LENS, ALL.replace("6 1 0 0 0", "6 0 0 0 0"), "line 13: expected IMAGE_ID"),
    (LENS, ALL.replace("4 1 0 0 0 0", "4 1 0 0 0 x"), "line 9: expected IMAGE_ID"),
    (LENS, "7 1 0 0\n\n", "line 1: expected IMAGE_ID QW QX QY QZ"),
    (LENS, ALL.replace(".jpg", ".png"), r"cameras of other photographs, such as 00\.png"),
    (LENS, "".join(map(IMAGE.format, range(5))), "of 5, at least 6 are needed"),
    (LENS, "", "there are no cameras in it"),
]


@pytest.mark.parametrize(("lenses", "images", "message"), REFUSED)
def test_models_that_cannot_be_are_refused(
    tmp_path: Path, lenses: str, images: str, message: str
) -> None:
    poses = photographs(tmp_path / "smile")
    (tmp_path / "model").mkdir()
    (tmp_path / "model" / "cameras.txt").write_text(lenses)
    (tmp_path / "model" / "images.txt").write_text(images)
    with pytest.raises(em.ElastomorphError, match=message) as caught:
        given_cameras(tmp_path / "model", poses, "smile", fixed=False)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda text: text[:300], "expected '# Bundle file v0.3'"),
        (lambda text: text.replace("7 40", "seven 40"), "expected '# Bundle file v0.3'"),
        (lambda text: text.replace("1300.0", "inf"), "expected '# Bundle file v0.3'"),
        (lambda text: text.replace("0.9", "5.9"), "expected '# Bundle file v0.3'"),
        (lambda text: "", "expected '# Bundle file v0.3'"),
    ],
)
def test_damaged_files_of_bundler_are_refused(
    tmp_path: Path, change: Callable[[str], str], message: str
) -> None:
    poses = photographs(tmp_path / "smile")
    file = tmp_path / "model.out"
    write_bundler(file, centred(), POINTS)
    file.write_text(change(file.read_text()))
    with pytest.raises(FormatError, match=message):
        given_cameras(file, poses, "smile", fixed=False)


def test_the_list_of_a_file_of_bundler(tmp_path: Path) -> None:
    """Any list beside it that names as many; cameras that were not found have no focal length."""
    poses = photographs(tmp_path / "smile")
    file, own = tmp_path / "model.out", tmp_path / "model.list.txt"
    write_bundler(file, centred(), POINTS)
    text = file.read_text().splitlines()
    text[2:7] = ["0 0 0", *["0 0 0"] * 4]
    file.write_text("\n".join(text))
    names = [f".\\smile\\{camera.name} 0 1300.5" for camera in CAMERAS]
    own.rename(tmp_path / "names.txt").write_text("\n".join(["7", *names]))
    (tmp_path / "LINK.txt").write_text("seven lines\n" * 7)
    found = given_cameras(file, poses, "smile", fixed=False)["smile"][0]
    assert [camera.name for camera in found] == [camera.name for camera in CAMERAS[1:]]
    (tmp_path / "others.txt").write_text("\n".join(names))
    with pytest.raises(FormatError, match=r"2 lists beside it .* model\.list\.txt"):
        given_cameras(file, poses, "smile", fixed=False)
    (tmp_path / "others.txt").rename(own)
    assert len(given_cameras(file, poses, "smile", fixed=False)["smile"][0]) == 6
    for list_file in tmp_path.glob("*.txt"):
        list_file.unlink()
    with pytest.raises(FormatError, match="0 lists beside it"):
        given_cameras(file, poses, "smile", fixed=False)


def test_each_pose_gets_its_own(tmp_path: Path) -> None:
    poses = photographs(tmp_path / "photos" / "neutral") | photographs(
        tmp_path / "photos" / "smile"
    )
    place = tmp_path / "cameras"
    moved = [replace(camera, translation=camera.translation + 1) for camera in CAMERAS]
    write_colmap(place / "neutral", CAMERAS, POINTS)
    found = given_cameras(place, poses, "neutral", fixed=False)
    assert list(found) == ["neutral"]  # those of the others are found
    write_bundler(place / "smile.out", centred(), POINTS)
    found = given_cameras(place, poses, "neutral", fixed=False)
    assert_same(found["smile"][0][3], centred()[3])
    write_colmap(place / "smile", moved, POINTS)
    found = given_cameras(place, poses, "neutral", fixed=False)
    assert_same(found["smile"][0][3], moved[3])
    assert_same(found["neutral"][0][3], CAMERAS[3])
    assert list(given_cameras(place, poses, "neutral", fixed=True)) == ["neutral"]
    with pytest.raises(CaptureError, match=r"00\.jpg is a photograph of several poses"):
        given_cameras(place / "smile", poses, "neutral", fixed=False)
    assert list(given_cameras(place / "smile", poses, "neutral", fixed=True)) == ["neutral"]
    both = [replace(c, name=f"neutral/{c.name}") for c in CAMERAS]
    both += [replace(c, name=f"deep/smile/{c.name}") for c in moved]
    write_colmap(tmp_path / "both", both, POINTS)
    found = given_cameras(tmp_path / "both", poses, "neutral", fixed=False)
    assert_same(found["smile"][0][5], moved[5])
    assert_same(found["neutral"][0][5], CAMERAS[5])
    with pytest.raises(FileError, match="there are no cameras in it"):
        given_cameras(tmp_path / "photos", poses, "neutral", fixed=False)


@pytest.mark.parametrize("orientation", [1, 3, 6, 8])
@pytest.mark.parametrize("sized", [True, False])
def test_cameras_of_photographs_as_they_are_stored(
    tmp_path: Path, orientation: int, sized: bool
) -> None:
    """A point is on the pixel that is there when the photograph is turned upright.

    Where sizes do not tell stored ones from upright ones, both are handed on.
    """
    stored = [replace(c, radial=0.0) for c in (CAMERAS if sized else centred())]
    (tmp_path / "smile").mkdir()
    exif = Image.Exif()
    exif[274] = orientation
    for camera in stored:
        spot = np.rint(camera.project(POINTS[0])[0]).astype(int)
        pixels = np.zeros(SIZE[::-1], dtype=np.uint8)
        pixels[spot[1], spot[0]] = 255
        Image.fromarray(pixels).save(tmp_path / "smile" / camera.name, exif=exif, quality=100)
    place = tmp_path / ("model" if sized else "model.out")
    (write_colmap if sized else write_bundler)(place, stored, POINTS)
    poses = find_poses(tmp_path / "smile")
    found = given_cameras(place, poses, "smile", fixed=False)["smile"]
    alike = not sized or orientation == 3
    assert len(found) == (2 if alike and orientation != 1 else 1)
    for camera in found[0]:
        upright = read_upright(tmp_path / "smile" / camera.name, grey=True)
        assert upright.shape[::-1] == camera.size
        bright = np.array(np.unravel_index(upright.argmax(), upright.shape))[::-1]
        np.testing.assert_allclose(camera.project(POINTS[0])[0], bright, atol=0.51)
        assert np.linalg.det(camera.rotation) == pytest.approx(1)
    for camera, other in zip(found[-1], stored, strict=True):
        if len(found) == 2 and orientation == 3:
            assert_same(camera, other)


@pytest.mark.slow
@pytest.mark.realdata
@pytest.mark.skipif(not STATUE.is_dir(), reason="needs the photographs of saharov32")
def test_cameras_of_a_real_statue() -> None:
    """Photographs agree with cameras that others solved, once the file is read rightly."""
    (paths,) = find_poses(STATUE).values()
    given = given_cameras(STATUE / "cameras.out", {"statue": paths}, "statue", fixed=False)
    lines = (STATUE / "cameras.out").read_text().splitlines()
    points = np.array([line.split() for line in lines[162::3]], dtype=np.float64)
    seen = [np.array(line.split()[1:], dtype=np.float64).reshape(-1, 4) for line in lines[164::3]]
    off = []
    # The program solved pixels as they are stored; x to the right and y up from their middle.
    for k, camera in enumerate(given["statue"][0]):
        rows = [(point, x, y) for point, row in enumerate(seen) for c, _, x, y in row if c == k]
        which, x, y = np.array(rows).T
        ours = camera.distorted(camera.project(points[which.astype(int)])[0])
        upright = np.stack([-y, -x], axis=1) + (np.array(camera.size) - 1) / 2  # orientation 8
        off.append(np.median(np.linalg.norm(ours - upright, axis=1)))
    assert max(off) < 0.4
    solved = solve_with(examine("statue", paths[:12]), given["statue"])
    assert len(solved.cameras) == 12
    assert len(solved.points) > 1000
    assert np.mean(list(solved.reprojection.values())) < 0.6
