"""Rendered photographs agree with the truth that is written beside them."""

from __future__ import annotations

import io
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image, ImageOps

from elastomorph.capturing.landmarks import LANDMARKS, read_landmarks
from elastomorph.model.polygons import Polygons
from needs import extra
from small_head import head, recorded_motion

extra("cv2", "capture")
extra("embreex", "capture")

from photographs.backdrop import Backdrop  # noqa: E402
from photographs.cameras import Lens, Spread, around  # noqa: E402
from photographs.exif import equivalent  # noqa: E402
from photographs.film import Film, developed  # noqa: E402
from photographs.noise import Spots, ValueNoise  # noqa: E402
from photographs.rendering import Scene  # noqa: E402
from photographs.sessions import Session, photograph  # noqa: E402
from photographs.skin import SKIN, Skin  # noqa: E402
from photographs.subdivision import refined  # noqa: E402
from photographs.subjects import subject  # noqa: E402
from photographs.truth import Truth  # noqa: E402
from render_photographs import options, session_of  # noqa: E402

pytestmark = pytest.mark.photographs

LENS = Lens.of_size(150, 200, radial=-0.12)
TINY = Session(count=2, size=(90, 120), poses=2)


@pytest.fixture(scope="module")
def person():
    return subject("small")


def scene(person, vertices, strength=1.0):
    return Scene(person.surface, vertices, Skin(0, strength), Backdrop())


def shots(person, lens=LENS, count=3):
    return around(lens, count, Spread(distance=person.distance, aim=person.aim), 7)


def test_what_a_pixel_sees_projects_back_to_it(person):
    """Within what single precision of rays leaves, through the distortion of the lens."""
    vertices = person.surface.rest
    here = scene(person, vertices)
    for shot in shots(person):
        seen = here.seen(shot)
        down, across = np.nonzero(seen.triangle >= 0)
        assert 0.1 < len(down) / seen.triangle.size < 0.9
        corners = vertices[person.surface.triangles[seen.triangle[down, across]]]
        points = np.einsum("nc,nca->na", seen.weights[down, across], corners)
        pixels = shot.project(points)
        np.testing.assert_allclose(pixels, np.stack([across, down], axis=1), atol=2e-3)


def test_directions_undo_the_distortion():
    grid = np.stack(np.meshgrid(np.arange(150), np.arange(200)), axis=-1)
    np.testing.assert_allclose(LENS.pixels(LENS.directions().astype(float)), grid, atol=1e-4)


def test_samples_of_a_pixel_lie_around_its_middle():
    samples = LENS.directions(2).reshape(200, 2, 150, 2, 3).mean(axis=(1, 3))
    np.testing.assert_allclose(samples, LENS.directions(), atol=1e-6)


def test_cameras_look_at_the_head_upright_and_along_their_axis(person):
    spread = Spread(jitter=0, distance=50, aim=person.aim)
    for shot in around(LENS, 9, spread):
        np.testing.assert_allclose(shot.rotation @ shot.rotation.T, np.eye(3), atol=1e-12)
        assert np.linalg.det(shot.rotation) == pytest.approx(1)
        inside = shot.rotation @ np.array(person.aim) + shot.translation
        np.testing.assert_allclose(inside, [0, 0, 50], atol=1e-9)
        above = shot.project(np.array(person.aim) + [0.0, 1.0, 0.0])
        assert above[1] < LENS.centre[1]  # y of a photograph runs down


def test_the_texture_moves_with_the_vertices(person):
    """Brightness through skin, divided by that of plain skin, agrees at vertices of two poses."""
    rest = person.surface.rest
    spread = Spread(rings=(0.0,), jitter=0, distance=22.0, aim=(0.0, -2.0, 1.0))
    (shot,) = around(replace(LENS, size=(450, 600), focal=780, centre=(225, 300)), 1, spread)
    shot = replace(shot, rotation=np.diag([1.0, -1.0, -1.0]), position=np.array([0.0, -2.0, 40.0]))
    moved = rest + np.sin(rest[:, [1, 2, 0]] / 6) * [1.5, 1.0, 0.5]
    cheek = (np.abs(rest[:, 0]) < 5) & (rest[:, 1] < -2) & (rest[:, 2] > 6) & (rest[:, 1] > -6)
    patterns = []
    for vertices in (rest, moved):
        here = scene(person, vertices)
        light = [here.photograph(shot)]
        here.skin = Skin(0, 0)
        light.append(here.photograph(shot))
        ratio = (light[0] / light[1])[:, :, 1]
        x, y = np.rint(shot.project(vertices[cheek])).astype(int).T
        patterns.append(ratio[y, x])
    assert np.corrcoef(*patterns)[0, 1] > 0.8
    assert np.corrcoef(patterns[0], np.roll(patterns[1], 40))[0, 1] < 0.3


def test_strength_none_leaves_blotches_only():
    points = np.random.default_rng(0).uniform(-9, 9, (4000, 3)).astype(np.float32)
    kinds, tints = np.full(4000, SKIN, np.int8), np.zeros((4000, 2), np.float32)
    none, half, whole = (Skin(3, s).colours(points, kinds, tints)[0] for s in (0, 0.5, 1))
    near = points + np.float32(0.05)  # blotches are 2.5 wide and hardly change over this
    step = np.abs(Skin(3, 0).colours(near, kinds, tints)[0] - none).mean()
    assert step < 0.1 * np.abs(Skin(3, 1).colours(near, kinds, tints)[0] - whole).mean()
    assert np.abs(half - none).mean() == pytest.approx(np.abs(whole - none).mean() / 2, rel=0.1)


def test_noise_is_smooth_and_repeats_for_a_seed():
    points = np.random.default_rng(0).uniform(-20, 20, (5000, 3)).astype(np.float32)
    for make in (lambda seed: ValueNoise([seed], 1.0), lambda seed: Spots([seed], 1.0)):
        values = make(1)(points)
        np.testing.assert_array_equal(values, make(1)(points))
        assert np.abs(values).max() <= 1 < 50 * np.abs(values - make(2)(points)).max()
        step = make(1)(points + np.float32(1e-3)) - values
        # The steepest of both is a spot of radius 0.2: 6/0.2² · r e^(-6 r²/0.2²) ≤ 11 a cell.
        assert np.abs(step).max() < 1e-3 * np.sqrt(3) * 2 * 11


def test_orientation_is_turned_back_and_the_focal_length_read_from_exif(person):
    light = scene(person, person.surface.rest).photograph(shots(person)[1])
    upright = picture(developed(light, LENS, Film(noise=0), np.random.default_rng(0)))
    for orientation in (3, 6, 8):
        film = Film(noise=0, orientation=orientation)
        stored = picture(developed(light, LENS, film, np.random.default_rng(0)))
        exif = stored.getexif()
        assert (exif[0x010F], exif[0x0110]) == ("Elastomorph", "Renderer 1")
        assert exif[0x0112] == orientation
        inner = exif.get_ifd(0x8769)
        assert (inner[0xA002], inner[0xA003]) == stored.size
        assert inner[0xA405] == round(equivalent(LENS.focal, LENS.size))
        sensor = inner[0x920A] / LENS.focal * np.hypot(*LENS.size)
        assert float(sensor) == pytest.approx(9.8, rel=1e-3)
        turned = np.asarray(ImageOps.exif_transpose(stored), dtype=float)
        assert turned.shape == (200, 150, 3)
        assert np.abs(turned - np.asarray(upright, dtype=float)).mean() < 1.5  # JPEG's own blocks
    bare = picture(developed(light, LENS, Film(exif=False), np.random.default_rng(0)))
    assert not bare.getexif()


def picture(jpeg):
    return Image.open(io.BytesIO(jpeg))


def test_noise_and_blur_are_as_strong_as_they_say():
    flat = np.full((400, 300, 3), 0.2, np.float32)
    flat[:, 150:] = 0.4
    lens = Lens.of_size(300, 400)
    film = Film(noise=0.02, exposure=0, quality=100, blur=0)
    values = np.asarray(picture(developed(flat, lens, film, np.random.default_rng(1)))) / 255.0
    grey = values[:, :140].mean(axis=2)  # JPEG keeps brightness whole, and colour not
    assert grey.std() == pytest.approx(0.02 / np.sqrt(3), rel=0.2)
    soft = replace(film, noise=0, blur=15)  # 3 px here
    edge = np.asarray(picture(developed(flat, lens, soft, np.random.default_rng(1)))) / 255.0
    slope = np.diff(edge[200, :, 1]).max() / (edge[200, 290, 1] - edge[200, 10, 1])
    assert slope == pytest.approx(1 / (3 * np.sqrt(2 * np.pi)), rel=0.15)


def test_the_same_seed_gives_the_same_bytes(tmp_path):
    one = replace(TINY, poses=1)
    for number, session in enumerate((one, one, replace(one, seed=1))):
        photograph(session, tmp_path / str(number))
    first, again, other = ((tmp_path / str(k) / "p00" / "01.jpg").read_bytes() for k in range(3))
    assert first == again != other


def test_the_truth_is_read_as_it_was_written(tmp_path, person):
    truth = photograph(TINY, tmp_path)
    read = Truth.load(tmp_path / "truth.npz")
    assert read.files == truth.files == ("00.jpg", "01.jpg")
    for name in ("p00", "p01"):
        np.testing.assert_array_equal(read.vertices[name], truth.vertices[name])
        points = read.vertices[name][:50]
        np.testing.assert_allclose(
            read.in_neutral(name, read.in_world(name, points)), points, atol=1e-12
        )
        for mine, its in zip(read.cameras[name], truth.cameras[name], strict=True):
            assert mine.lens == its.lens
            np.testing.assert_array_equal(mine.project(points), its.project(points))
    assert np.linalg.norm(read.vertices["p01"] - read.vertices["p00"], axis=1).max() > 2
    np.testing.assert_array_equal(read.in_world("p00", points), points)
    assert (tmp_path / "poses_true" / "p01.obj").exists()
    np.testing.assert_array_equal(read.of_template, person.of_template)


def test_a_fixed_rig_stays_and_a_walker_does_not(person):
    fixed, walking = (replace(TINY, rig=rig) for rig in ("fixed", "walking"))
    positions = {
        rig.rig: [[shot.position for shot in rig.shots(pose, person)] for pose in (0, 1)]
        for rig in (fixed, walking)
    }
    np.testing.assert_array_equal(*positions["fixed"])
    assert np.abs(np.subtract(*positions["walking"])).max() > 0.1


def test_the_template_is_the_face_of_somebody_else(person):
    own = person.surface.rest[person.of_template]
    assert len(person.template.vertices) == len(own) < len(head().vertices)
    apart = np.linalg.norm(person.template.vertices - own, axis=1)
    assert 0.2 < apart.mean() < 1.0
    begun = person.poses("smile", np.array([0.0]))[0]
    np.testing.assert_allclose(begun, person.surface.rest, rtol=1e-6, atol=1e-12)


def test_subdivision_of_a_cube_is_that_worked_by_hand():
    """A corner goes to (F + 2 E) / 3 with F = 1/3 and E = 2/3 of it: 5/9."""
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
    faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    matrix, quads = refined(Polygons.of(faces), 8)
    new = matrix @ corners
    assert new.shape == (8 + 12 + 6, 3)
    assert len(quads) == 24
    np.testing.assert_allclose(new[:8], corners * 5 / 9)
    edges = np.abs(new[8:20])
    np.testing.assert_allclose(np.sort(edges, axis=1), np.tile([0, 0.75, 0.75], (12, 1)))
    np.testing.assert_allclose(np.abs(new[20:]).sum(axis=1), 1)
    normals = np.cross(
        new[[q[1] for q in quads]] - new[[q[0] for q in quads]],
        new[[q[3] for q in quads]] - new[[q[0] for q in quads]],
    )
    outward = np.einsum("na,na->n", normals, new[[q[0] for q in quads]])
    assert (outward > 0).all() or (outward < 0).all()


def test_subdivision_keeps_a_flat_sheet_flat_and_its_border_straight():
    grid = np.array([[x, y, 0.0] for y in range(4) for x in range(4)])
    faces = [
        [4 * y + x, 4 * y + x + 1, 4 * y + x + 5, 4 * y + x + 4] for y in range(3) for x in range(3)
    ]
    matrix, _ = refined(Polygons.of(faces), 16)
    np.testing.assert_allclose(matrix.sum(axis=1), 1)
    new = matrix @ grid
    np.testing.assert_allclose(new[5], grid[5])  # an inner vertex of an even grid stays
    assert new[1].tolist() == [1, 0, 0]
    assert np.abs(new[:, 2]).max() == 0


def test_the_command_line_describes_a_session():
    chosen = options(
        [
            "out",
            "--small",
            "--poses",
            "3",
            "--size",
            "60",
            "80",
            "--rings",
            "-35",
            "8",
            "--noise",
            "0.1",
            "--no-exif",
        ]
    )
    session = session_of(chosen)
    assert (session.poses, session.size, session.rings) == (3, (60, 80), (-35.0, 8.0))
    assert session.count == 12  # of the small case
    assert session.film == Film(noise=0.1, exif=False)


def test_clicks_lie_on_landmarks_that_are_seen(tmp_path, person):
    """Within four standard deviations of a click; each landmark of the middle in two or more."""
    session = replace(TINY, poses=1, count=15, size=(60, 80))
    truth = photograph(session, tmp_path)
    read = read_landmarks(tmp_path / "landmarks.json")
    assert set(read.vertices) == set(LANDMARKS)
    often = dict.fromkeys(LANDMARKS, 0)
    for file, places in read.photographs["p00"].items():
        camera = truth.cameras["p00"][truth.files.index(file)]
        for name, place in places.items():
            vertex = truth.of_template[read.vertices[name]]
            true = camera.project(truth.vertices["p00"][vertex])
            assert np.abs(np.array(place) - true).max() < 4 * 3 * 80 / 2000
            often[name] += 1
    assert min(often.values()) >= 2


def test_a_head_that_sways_is_where_its_cameras_say(tmp_path, person):
    """Skin differs from the backdrop where the true vertices are projected, and only there."""
    truth = photograph(replace(TINY, poses=1, sway=6.0), tmp_path)
    vertices = truth.vertices["p00"]
    for file, camera in zip(truth.files, truth.cameras["p00"], strict=True):
        values = np.asarray(picture((tmp_path / "p00" / file).read_bytes())).astype(int)
        skin = values[:, :, 0] - values[:, :, 2] > 25
        x, y = camera.project(vertices).T
        inside = (x > 0) & (x < 89) & (y > 0) & (y < 119)
        covered = np.zeros((120, 90), bool)
        covered[np.rint(y[inside]).astype(int), np.rint(x[inside]).astype(int)] = True
        assert (skin & covered).sum() > 0.85 * (skin | covered).sum()


def test_a_face_that_drifts_is_another_in_each_photograph(person):
    session = replace(TINY, drift=0.1)
    times = [session.time(1, shot) for shot in range(50)]
    assert len(set(times)) > 10
    assert min(times) > 0.5
    assert max(times) == 1
    assert TINY.time(1, 0) == 1.0


def test_the_recorded_movement_passes_through_its_frames(person):
    """The recorded motion, moved as its neutral was to other proportions."""
    frames = recorded_motion().frames
    at = person.poses("recorded", np.array([0.0, 0.5, 1.0]))
    for found, number in zip(at, (0, 5, 10), strict=True):
        np.testing.assert_allclose(found, person.refine @ person.frames[number], atol=1e-12)
    apart = np.linalg.norm(person.frames[10] - person.frames[0], axis=1)
    original = np.linalg.norm(frames[10] - frames[0], axis=1)
    assert np.corrcoef(apart, original)[0, 1] > 0.99
