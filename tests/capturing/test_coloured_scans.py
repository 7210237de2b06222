"""Scans with colours, in images or at vertices: register follows the skin by them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import elastomorph as em
from elastomorph.errors import CaptureError, ElastomorphWarning, MeshError
from needs import extra

extra("embreex", "capture")
cv2 = extra("cv2", "capture")

from painted import paint  # noqa: E402
from small_scans import in_single_steps, marked, middle, posed, rig, scanned  # noqa: E402

from elastomorph.capturing.geometry import Similarity, Surface  # noqa: E402
from elastomorph.capturing.scans.nonrigid import Elastic  # noqa: E402
from elastomorph.capturing.scans.placing import Marks, placed_next  # noqa: E402
from elastomorph.capturing.scans.registered_files import read_face  # noqa: E402
from elastomorph.capturing.scans.registration import neutral_person  # noqa: E402
from elastomorph.capturing.scans.scans import read_scan  # noqa: E402
from elastomorph.model.mesh import FaceLabels, Material, Texture, UVMap  # noqa: E402  # noqa: E402
from elastomorph.model.surface import triangulate  # noqa: E402

pytestmark = pytest.mark.photographs

SMILE = {"jawOpen": 0.25, "mouthSmile_L": 0.7}


def surface_of(face: np.ndarray) -> Surface:
    return Surface(face, triangulate(rig().neutral)[0].astype(np.int64))


def painted(rest: np.ndarray) -> np.ndarray:
    """(N,) grey of a painted skin at points of the head at rest."""
    return np.clip(np.round(paint(3)((rest - middle()) / 12)), 0, 255).astype(np.uint8)


def as_ply(path: Path, mesh: em.Mesh, face: np.ndarray) -> Path:
    """A scan with colours at its vertices."""
    surface = surface_of(face)
    grey = painted(surface.at(surface.closest(mesh.vertices), posed()))
    corners = mesh.faces.triangles()
    names = "\n".join(f"property uchar {name}" for name in ("red", "green", "blue"))
    head = (
        f"ply\nformat binary_little_endian 1.0\nelement vertex {len(grey)}\nproperty double x\n"
        f"property double y\nproperty double z\n{names}\nelement face {len(corners)}\n"
        "property list uchar int vertex_indices\nend_header\n"
    )
    rows = np.zeros(len(grey), np.dtype([("place", "<f8", 3), ("colour", "u1", 3)]))
    rows["place"], rows["colour"] = mesh.vertices, grey[:, None]
    faces = np.zeros(len(corners), np.dtype([("count", "u1"), ("corners", "<i4", 3)]))
    faces["count"], faces["corners"] = 3, corners
    path.write_bytes(head.encode() + rows.tobytes() + faces.tobytes())
    return path


def as_glb(path: Path, mesh: em.Mesh, face: np.ndarray, wide: int = 1024) -> Path:
    """A scan with an image, by the direction from the middle of the head."""
    around, up = np.meshgrid(
        2 * np.pi * (np.arange(wide) + 0.5) / wide, 1.35 - 2.3 * (np.arange(512) + 0.5) / 512
    )
    ways = np.stack([np.sin(around) * np.cos(up), np.sin(up), np.cos(around) * np.cos(up)], -1)
    surface = surface_of(face)
    hits = surface.cast(middle() + 40 * ways, -ways)
    picture = np.full(hits.met.shape, 90, np.uint8)
    picture[hits.met] = painted(surface.at(hits, posed())[hits.met])
    own = mesh.vertices - middle()
    own = own / np.linalg.norm(own, axis=1, keepdims=True)
    corners = mesh.faces.triangles()
    u = (np.arctan2(own[:, 0], own[:, 2]) / (2 * np.pi) % 1.0)[corners]
    # Triangles across the border of the image go on beyond it, where it is repeated.
    u[(np.ptp(u, axis=1) > 0.5)[:, None] & (u < 0.5)] += 1
    v = (np.arcsin(own[:, 1])[corners] - (1.35 - 2.3)) / 2.3
    uv = UVMap(np.stack([u, v], -1).reshape(-1, 2), np.arange(corners.size, dtype=np.int32))
    image = cv2.imencode(".png", picture)[1].tobytes()
    looks = {"skin": Material(texture=Texture(image, "skin.png"))}
    labels = FaceLabels(("skin",), np.zeros(len(corners), np.int32))
    dressed = em.Mesh(mesh.vertices, corners, uv, labels, appearance=looks)
    em.write(path, em.Rig(dressed, {}))
    return path


@pytest.mark.slow
def test_skin_is_followed_from_an_image_to_colours_of_vertices(tmp_path: Path) -> None:
    """One scan is a GLB with an image, the other a PLY with a colour for each vertex."""
    face = posed(**SMILE)
    one = as_glb(tmp_path / "neutral.glb", scanned(posed(), rows=200), posed())
    two = as_ply(tmp_path / "smile.ply", scanned(face, rows=300, seed=1), face)
    # Where the head is without landmarks is found in other tests.
    marks = marked(posed(), one.name)
    poses = em.register_all([one, two], rig().neutral, landmarks=marks)
    smile, neutral = poses["smile"], poses["neutral"]
    assert smile.figures["correspondence"] == "by the skin's colours"
    extent = smile.figures["extent"]
    moved = face - posed()
    sure = (smile.confidence > 0.5) & (neutral.confidence > 0.5)
    moving = sure & (np.linalg.norm(moved, axis=1) > 0.02 * extent)
    off = 100 * np.linalg.norm(smile.vertices - neutral.vertices - moved, axis=1) / extent
    assert np.count_nonzero(moving) > 50
    assert off[moving].mean() < 0.5, "a confidence above a half promises no more"


@pytest.fixture(scope="module")
def scans(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """A neutral and a smile without colours."""
    folder = tmp_path_factory.mktemp("scans")
    files = [folder / "neutral.ply", folder / "smile.ply"]
    em.write(files[0], scanned(posed(), rows=90))
    em.write(files[1], scanned(posed(**SMILE), rows=90, seed=1))
    return files


def test_a_scan_of_the_neutral_is_registered_first(
    scans: list[Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    """So that a pose alone is what it is among all of them, however many steps are taken."""
    in_single_steps(monkeypatch)
    template, marks = rig().neutral, marked(posed(), scans[0].name)
    with pytest.warns(ElastomorphWarning, match="correspondence along the surface"):
        both = em.register_all(scans, template, landmarks=marks)
    with pytest.warns(ElastomorphWarning, match="correspondence along the surface"):
        alone = em.register(scans[1], template, landmarks=marks, neutral=scans[0])
    np.testing.assert_allclose(alone.vertices, both["smile"].vertices, atol=1e-6)


def test_a_file_with_the_vertices_of_the_template_is_the_neutral_itself(tmp_path: Path) -> None:
    face = read_face(rig())
    em.write(tmp_path / "neutral.obj", rig().neutral.with_vertices(1.1 * posed()))
    person = neutral_person(face, tmp_path / "neutral.obj", Marks({}, {}, ""), True, [].append)
    np.testing.assert_array_equal(person.elastic.rest[face.place], 1.1 * posed())
    assert person.shown is None


def test_what_is_no_neutral_is_told(scans: list[Path], tmp_path: Path) -> None:
    with pytest.raises(MeshError, match="the neutral must be a Mesh, found int"):
        em.register(scans[1], rig(), neutral=7)  # type: ignore[arg-type]
    with pytest.raises(em.FileError, match="gone"):
        em.register(scans[1], rig(), neutral=tmp_path / "gone.ply")


def test_a_later_scan_that_is_mirrored_is_told() -> None:
    """By an expression of one side, on a face that is not the same on both."""
    face = read_face(rig())
    crooked = face.vertices + [[0.08, 0.0, 0.0]] * (face.vertices[:, 1:2] - middle()[1])
    elastic = Elastic(crooked, face.triangles, face.size, face.skin)
    own = em.Mesh(crooked[face.place], rig().neutral.faces)
    scan = scanned(own.vertices, rows=90)
    marks = Marks({}, {}, "")
    before = Similarity.identity()
    turned = em.Mesh(scan.vertices, scan.faces.triangles()[:, ::-1])
    for sound in (scan, turned):  # inside out alone is no mirror
        found = placed_next(read_scan(sound), marks, elastic, crooked, before).similarity
        np.testing.assert_allclose(found.rotation, np.eye(3), atol=0.01)
    mirrored = em.Mesh(scan.vertices * [-1, 1, 1], scan.faces)
    with pytest.raises(CaptureError, match="is mirrored: mirror it back"):
        placed_next(read_scan(mirrored), marks, elastic, crooked, before)
