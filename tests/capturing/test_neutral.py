"""The neutral's surface from rendered photographs, against the truth."""

from dataclasses import replace

import numpy as np
import pytest
from photographed_head import Head, photographed_head

import elastomorph.capturing.neutral as module
from elastomorph.capturing.cameras.coverage import missing_cameras
from elastomorph.capturing.geometry import Similarity, Surface
from elastomorph.capturing.neutral import NeutralSurface, neutral_surface
from elastomorph.errors import CaptureError
from needs import extra

pytestmark = pytest.mark.photographs

extra("cv2", "capture")
extra("embreex", "capture")


def made(head: Head) -> NeutralSurface:
    return neutral_surface(
        head.views, head.cloud, head.template, head.triangles, head.landmarks, head.places
    )


@pytest.fixture(scope="module")
def head() -> Head:
    return photographed_head()


@pytest.fixture(scope="module")
def neutral(head) -> NeutralSurface:
    return made(head)


@pytest.fixture
def briefly(monkeypatch):
    """Photographs are compared once, at their coarsest: what changes nothing does so each time."""
    monkeypatch.setattr(module, "_ROUNDS", module._ROUNDS[:1])


@pytest.fixture(scope="module")
def rough(head) -> NeutralSurface:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "_ROUNDS", module._ROUNDS[:1])
        return made(head)


def distances(head: Head, vertices: np.ndarray) -> np.ndarray:
    """(V,) in % of D."""
    return head.surface.closest(vertices).distances / head.extent * 100


def seen(head: Head) -> np.ndarray:
    """(V,) which vertices three cameras see."""
    normals = Surface(head.true, head.triangles).normals
    count = np.zeros(len(head.true), dtype=int)
    for camera in head.cameras:
        count += head.surface.visible(
            camera, head.true, normals, least_cosine=0.3, tolerance=0.005 * head.extent
        )[0]
    return count >= 3


def test_what_photographs_show_is_on_the_true_surface(head, neutral):
    """A pixel is 0.25 % of D: what is measured is a fraction of it off, and most is measured."""
    covered = neutral.covered > 0
    off = distances(head, neutral.vertices)
    assert off[covered].mean() < 0.05
    assert np.percentile(off[covered], 95) < 0.12
    assert covered[seen(head)].mean() > 0.75
    before = distances(head, head.template)
    assert off[seen(head)].mean() < 0.15 * before[seen(head)].mean()
    assert off.mean() < 0.4 * before.mean()


def test_the_spread_tells_how_far_a_vertex_may_be_off(head, neutral):
    covered = neutral.covered > 0
    assert np.isinf(neutral.spread[~covered]).all()
    assert (neutral.covered[covered] >= 3).all()
    spread = neutral.spread[covered] / head.extent * 100
    assert (spread > 0).all()
    off = distances(head, neutral.vertices)[covered]
    calm = spread < np.median(spread)
    assert off[calm].mean() < off[~calm].mean()


def test_units_and_axes_change_nothing(head, rough, briefly):
    """The same world in metres and another axis up, the template in inches and lying."""
    upright = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
    move = Similarity(0.01, upright, np.array([0.05, -0.03, 0.02]))
    lying = Similarity(
        1 / 2.54, np.array([[0.0, 0, 1], [1, 0, 0], [0, 1, 0]]), np.array([1.0, 2, 3])
    )
    other = made(replace(head.moved(move), template=lying(head.template)))
    off = np.linalg.norm(move.inverse()(other.vertices) - rough.vertices, axis=1) / head.extent
    # Rays have seven digits: at the edge of what is seen one may pass that did not.
    assert np.median(off) < 1e-4
    assert np.percentile(off, 95) < 1e-3
    assert (other.covered == rough.covered).mean() > 0.95


def test_hair_and_background_do_not_move_the_skin(head, rough, briefly):
    """A thousand points two centimetres above the scalp, and a wall behind the head."""
    random = np.random.default_rng(3)
    normals = head.surface.normals
    top = np.flatnonzero(head.surface.vertices[:, 1] > head.places["nose_bridge"][1] + 4)
    hair = random.choice(top, 1000)
    hair_points = head.surface.vertices[hair] + normals[hair] * random.uniform(1.8, 3, (1000, 1))
    wall = random.uniform(-40, 40, (3000, 3))
    wall[:, 2] = -12
    other = made(replace(head, cloud=np.concatenate([head.cloud, hair_points, wall])))
    off = np.linalg.norm(other.vertices - rough.vertices, axis=1) / head.extent * 100
    assert np.percentile(off[rough.covered > 0], 99) < 0.02
    assert off.max() < 0.5


def ball(middle: np.ndarray, radius: float) -> tuple[np.ndarray, np.ndarray]:
    """A closed sphere of triangles."""
    from scipy.spatial import ConvexHull

    points = np.random.default_rng(0).normal(size=(200, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    triangles = ConvexHull(points).simplices
    normals = np.cross(*(points[triangles[:, k]] - points[triangles[:, 0]] for k in (1, 2)))
    inward = (normals * points[triangles[:, 0]]).sum(axis=1) < 0
    triangles[inward] = triangles[inward][:, ::-1]
    return middle + radius * points, triangles


def test_eyes_stay_round_and_behind_the_skin(head, rough, briefly):
    """Two balls behind the eyes of the template go with the face around them."""
    vertices, triangles, middles = [head.template], [head.triangles], []
    for side in ("left", "right"):
        inner, outer = (
            head.template[head.landmarks[f"{side}_eye_{end}"]] for end in ("inner", "outer")
        )
        middles.append((inner + outer) / 2 - [0, 0, 1.6])
        points, faces = ball(middles[-1], 1.2)
        triangles.append(faces + sum(map(len, vertices)))
        vertices.append(points)
    both = made(
        replace(head, template=np.concatenate(vertices), triangles=np.concatenate(triangles))
    )
    count = len(head.template)
    off = np.linalg.norm(both.vertices[:count] - rough.vertices, axis=1)
    assert np.percentile(off, 99) < 0.002 * head.extent
    assert (both.covered[count:] == 0).all()
    scale = np.ptp(rough.vertices, axis=0).max() / np.ptp(head.template, axis=0).max()
    for eye, side in zip(np.split(both.vertices[count:], 2), ("left", "right"), strict=True):
        middle = eye.mean(axis=0)
        radii = np.linalg.norm(eye - middle, axis=1)
        assert np.ptp(radii) < 0.15
        assert radii.mean() == pytest.approx(1.2 * scale, rel=0.1)
        corners = [rough.vertices[head.landmarks[f"{side}_eye_{e}"]] for e in ("inner", "outer")]
        behind = np.mean(corners, axis=0) - middle
        assert behind[2] == pytest.approx(1.6, abs=0.4)
        assert np.abs(behind[:2]).max() < 0.4


def test_landmarks_that_are_no_face_are_refused(head):
    few = {name: head.places[name] for name in ("nose_tip", "chin")}
    with pytest.raises(CaptureError, match="2 landmarks are also on the template"):
        made(replace(head, places=few))
    swapped = dict(head.landmarks)
    for name in [name for name in swapped if name.startswith("left")] + ["mouth_left"]:
        other = name.replace("left", "right")
        swapped[name], swapped[other] = swapped[other], swapped[name]
    with pytest.raises(CaptureError, match="mirrored face: left and right are the subject's own"):
        made(replace(head, landmarks=swapped))
    mixed = dict(zip(head.landmarks, np.roll(list(head.landmarks.values()), 5), strict=True))
    with pytest.raises(CaptureError, match="do not lie as on a face"):
        made(replace(head, landmarks={name: int(v) for name, v in mixed.items()}))


def test_photographs_of_something_else_are_refused(head):
    away = Similarity(1, np.eye(3), np.array([200.0, 0, 0]))
    views = [replace(view, camera=view.camera.moved(away)) for view in head.views]
    with pytest.raises(CaptureError, match="0 of 12 photographs show the face"):
        made(replace(head, views=views))


def test_what_a_mask_leaves_out_is_not_measured(head, briefly):
    masked = []
    for view in head.views:
        mask = np.ones(view.grey.shape, dtype=bool)
        mask[int(view.camera.project(head.places["nose_tip"])[0][1]) :] = False
        masked.append(replace(view, mask=mask))
    found = made(replace(head, views=masked))
    chin, bridge = (head.places[name] for name in ("chin", "nose_bridge"))
    near_chin = np.linalg.norm(found.vertices - chin, axis=1) < 2
    near_bridge = np.linalg.norm(found.vertices - bridge, axis=1) < 2
    assert (found.covered[near_chin] == 0).all()
    assert (found.covered[near_bridge] > 0).mean() > 0.8


def test_directions_that_few_cameras_see_are_asked_for(head):
    surface = Surface(head.true, head.triangles)
    marks = {name: surface.vertices[vertex] for name, vertex in head.landmarks.items()}
    said = missing_cameras(surface, head.cameras, marks)
    assert said is not None
    assert said.endswith("from under the chin")
    left = [camera for camera in head.cameras if camera.position[0] > 0]
    assert "the subject's right" in str(missing_cameras(surface, left, marks))
    assert "100% of the face" in str(missing_cameras(surface, [], marks))
    below = Similarity(
        1, np.array([[1.0, 0, 0], [0, 0.643, -0.766], [0, 0.766, 0.643]]), np.zeros(3)
    )
    turned = [replace(camera, **_turned(camera, below.rotation)) for camera in head.cameras]
    both = missing_cameras(surface, [*head.cameras, *turned], marks)
    assert both is None or "chin" not in both


def _turned(camera, turn):
    """The camera on the same ring, turned about the origin."""
    return {"rotation": camera.rotation @ turn.T}
