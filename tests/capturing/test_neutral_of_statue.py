"""The neutral's surface from real photographs: a statue whose head is 60 pixels wide.

Cameras and points are the reference that comes with the photographs (Bundler's format).
"""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import elastomorph as em
from elastomorph.capturing.geometry import Camera, Surface, View, open_view
from elastomorph.capturing.landmarks import triangulated
from elastomorph.capturing.neutral import neutral_surface
from needs import extra
from small_head import head as small_head
from small_head import landmarks

extra("cv2", "capture")
extra("embreex", "capture")

pytestmark = [pytest.mark.realdata, pytest.mark.photographs]

SIZE = (728, 1092)
FRONT = ("IMG_3029.JPG", "IMG_3031.JPG", "IMG_3033.JPG")
# Landmark → (x, y) in each of the three photographs, as clicked; None where it is not seen.
CLICKS = {
    "nose_tip": ((305.5, 83.5), (334, 76), (347.5, 76.5)),
    "nose_bridge": ((311, 77.5), (333.5, 71.5), (341.5, 72)),
    "right_nostril": ((305.5, 89.5), (330, 83), (341, 82.5)),
    "left_nostril": ((313.5, 88.5), (339, 83), (349.5, 83.5)),
    "right_eye_outer": (None, (320, 77.5), (324.5, 76.5)),
    "right_eye_inner": (None, (330.5, 75), (337, 74.5)),
    "left_eye_inner": ((315.5, 80), (338.5, 74.5), None),
    "left_eye_outer": ((328, 81), (349, 77), None),
    "mouth_right": ((304.8, 97), (328.5, 91), (339, 91)),
    "mouth_left": ((318, 96.3), (342.5, 91.5), (352, 92)),
    "upper_lip": ((308.5, 93.5), (334.5, 86.5), (346, 87)),
    "lower_lip": ((308, 99), (334.5, 92.2), (345.5, 92.8)),
    "chin": ((306, 107.5), (334, 101), (346, 101.5)),
    "right_jaw": (None, (314.5, 101), (313, 99)),
    "left_jaw": ((341, 104), (357, 103), None),
}


def bundler(folder: Path) -> tuple[list[Camera], np.ndarray]:
    """Cameras and points; its cameras look along −z with y up, and lie on their side."""
    names = (folder / "ordered_filenames.txt").read_text().split()[1:]
    lines = (folder / "cameras.out").read_text().splitlines()[1:]
    cameras, points = (int(word) for word in lines[0].split())
    rows = [np.array(line.split(), dtype=float) for line in lines[1 : 1 + 5 * cameras]]
    flip = np.array([[0.0, -1, 0], [-1, 0, 0], [0, 0, -1]])
    found = []
    for name, five in zip(names, np.arange(5 * cameras).reshape(-1, 5), strict=True):
        focal, first, second = rows[five[0]]
        turn = np.array([rows[row] for row in five[1:4]])
        # One radial term for two, the same where the head is: a twelfth from the centre, squared.
        middle = (np.array(SIZE) - 1) / 2
        radial = first + second / 12
        camera = Camera(name, SIZE, focal, middle, radial, flip @ turn, flip @ rows[five[4]])
        found.append(camera)
    after = lines[1 + 5 * cameras :]
    return found, np.array([line.split() for line in after[: 3 * points : 3]], dtype=float)


def test_a_head_takes_the_shape_of_a_statue(data_dir: Path) -> None:
    folder = data_dir / "photos" / "saharov32"
    if not folder.is_dir():
        pytest.skip(f"needs the photographs of a statue, not found in {folder}")
    cameras, points = bundler(folder)
    clicks = {
        name: {mark: places[k] for mark, places in CLICKS.items() if places[k] is not None}
        for k, name in enumerate(FRONT)
    }
    by_name = {camera.name: camera for camera in cameras}
    places, residuals = triangulated(clicks, by_name)
    assert max(residuals.values()) < 2
    views: list[View] = [open_view(camera, folder / camera.name) for camera in cameras]
    head = small_head()
    triangles = head.faces.triangles()
    marks = landmarks()
    found = neutral_surface(views, points, head.vertices, triangles, marks, places)
    surface = Surface(found.vertices, triangles)
    front = by_name["IMG_3031.JPG"]
    shown = surface.visible(
        replace(front, radial=0.0),
        surface.vertices,
        surface.normals,
        least_cosine=0.3,
        tolerance=0.01 * head.diameter,
    )[0]
    extent = em.Mesh(found.vertices).diameter
    face = np.min(
        [np.linalg.norm(found.vertices - place, axis=1) for place in places.values()], axis=0
    )
    assert (found.covered[shown & (face < 0.1 * extent)] > 0).mean() > 0.4
    # What pairs of photographs say differs by less than what one of their pixels shows.
    pixel = np.linalg.norm(front.position - places["nose_tip"]) / front.focal
    assert np.median(found.spread[found.covered > 0]) < pixel
    for name, vertex in marks.items():
        pixel = front.project(found.vertices[vertex])[0]
        assert np.linalg.norm(front.distorted(pixel) - CLICKS[name][1]) < 4
