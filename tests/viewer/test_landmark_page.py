"""The page of landmarks gets what it shows, and the server takes what is placed, and no more."""

from __future__ import annotations

import http.client
import json
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from pages import Elements

import elastomorph as em
from elastomorph.capturing.cameras.models import SolvedPose
from elastomorph.capturing.geometry import Camera
from elastomorph.capturing.landmarks import LANDMARKS, Landmarks, read_landmarks
from elastomorph.capturing.work.stages import WorkingFolder
from elastomorph.model.mesh import FaceLabels, Material, Texture, UVMap
from elastomorph.viewer import ViewerServer
from elastomorph.viewer.landmarks import (
    PackedSurface,
    landmark_task,
    pack_surface,
    serve_landmarks,
    solved_cameras,
    write_landmark_page,
)
from small_head import head, landmarks

FILE = {"version": 1, "vertices": {"chin": 3}, "photographs": {}, "points": {}}


@pytest.fixture
def photos(tmp_path: Path) -> Path:
    folder = tmp_path / "neutral"
    folder.mkdir()
    for name in ("IMG_2.JPG", "IMG_1.png", "notes.txt"):
        (folder / name).write_bytes(name.encode())
    return folder


@pytest.fixture
def server(photos: Path, tmp_path: Path) -> Iterator[ViewerServer]:
    em.write(tmp_path / "head.npz", head())
    known = Landmarks(vertices=landmarks())
    task = landmark_task([photos], tmp_path / "head.npz", known=known)
    with serve_landmarks(task, tmp_path / "landmarks.json") as started:
        yield started


def ask(
    server: ViewerServer, name: str, content: bytes | None = None, **headers: str
) -> tuple[int, bytes]:
    """Status and body; a POST where there is content."""
    connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=60)
    own = {"Origin": f"http://127.0.0.1:{server.port}"} | headers
    method = "GET" if content is None else "POST"
    connection.request(
        method, f"/{server.token}/{name}", content, {k: v for k, v in own.items() if v}
    )
    reply = connection.getresponse()
    found = reply.status, reply.read()
    connection.close()
    return found


def unpacked(content: bytes) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """Header and arrays of a surface, read by their description."""
    (length,) = struct.unpack_from("<I", content)
    header = json.loads(content[4 : 4 + length])
    at, arrays = 4 + length, {}
    vertices, triangles, edges = (header[name] for name in ("vertices", "triangles", "edges"))
    for name, kind, shape in (
        ("positions", "<f4", (vertices, 3)),
        ("uv", "<f4", (vertices if header["uv"] else 0, 2)),
        ("sources", "<u4", (vertices,)),
        ("triangles", "<u4", (triangles, 3)),
        ("edges", "<u4", (edges, 2)),
        ("colours", "u1", (vertices if header["colours"] else 0, 4)),
    ):
        count = int(np.prod(shape))
        arrays[name] = np.frombuffer(content, kind, count, at).reshape(shape)
        at += count * np.dtype(kind).itemsize
    assert at == len(content)
    return header, arrays


def test_photographs_are_sent_as_they_are(server: ViewerServer, photos: Path) -> None:
    """In the order of their names, and read when they are asked for."""
    assert ask(server, "place-1") == (200, b"IMG_1.png")
    (photos / "IMG_2.JPG").write_bytes(b"another")
    assert ask(server, "place-2") == (200, b"another")
    (photos / "IMG_2.JPG").unlink()
    status, words = ask(server, "place-2")
    assert status == 410
    assert b"IMG_2.JPG" in words


def test_the_page_says_what_there_is(photos: Path, tmp_path: Path) -> None:
    task = landmark_task([photos], "built-in")
    with serve_landmarks(task, tmp_path / "landmarks.json") as server:
        _, page = ask(server, "")
    task = json.loads(Elements(page.decode()).texts["elastomorph-landmarks"])
    assert task["names"] == list(LANDMARKS)
    assert task["words"] == LANDMARKS
    assert task["save"] == task["file"] == "landmarks.json"
    assert [(place["kind"], place["pose"], place["name"]) for place in task["places"]] == [
        ("template", "", "built-in"),
        ("photograph", "neutral", "IMG_1.png"),
        ("photograph", "neutral", "IMG_2.JPG"),
    ]
    assert set(task["known"]["vertices"]) == set(LANDMARKS)


def test_what_is_placed_is_written(server: ViewerServer, tmp_path: Path) -> None:
    assert ask(server, "landmarks.json", json.dumps(FILE).encode()) == (200, b"saved\n")
    assert read_landmarks(tmp_path / "landmarks.json").vertices == {"chin": 3}


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"no json", b"not JSON"),
        (b"{}", b"no file of landmarks"),
        (json.dumps(FILE | {"vertices": {"chin": -1}}).encode(), b"chin is -1"),
        (json.dumps(FILE | {"points": {"s": {"chin": [1, 2]}}}).encode(), b"3 numbers"),
    ],
)
def test_what_is_no_file_of_landmarks_is_refused(
    server: ViewerServer, tmp_path: Path, content: bytes, words: bytes
) -> None:
    """The file that is there stays as it is."""
    file = tmp_path / "landmarks.json"
    file.write_text("as it was")
    status, said = ask(server, "landmarks.json", content)
    assert status == 400
    assert words in said
    assert file.read_text() == "as it was"


@pytest.mark.parametrize(
    "headers",
    [
        {"Origin": ""},
        {"Origin": "http://evil.example"},
        {"Origin": "null"},
        {"Host": "evil.example", "Origin": "http://evil.example"},
    ],
)
def test_pages_of_others_place_nothing(
    server: ViewerServer, tmp_path: Path, headers: dict[str, str]
) -> None:
    status, _ = ask(server, "landmarks.json", json.dumps(FILE).encode(), **headers)
    assert status == 405
    assert not (tmp_path / "landmarks.json").exists()


def test_only_the_file_is_taken_and_only_by_who_knows_the_address(
    server: ViewerServer, tmp_path: Path
) -> None:
    content = json.dumps(FILE).encode()
    assert ask(server, "place-1", content)[0] == 405
    assert ask(server, "../landmarks.json", content)[0] == 405
    server.token = server.token.swapcase()
    assert ask(server, "landmarks.json", content)[0] == 405
    assert not (tmp_path / "landmarks.json").exists()


@pytest.mark.parametrize(("length", "status"), [("x", 411), ("-1", 411), ("9000000", 413)])
def test_lengths_that_are_none(server: ViewerServer, length: str, status: int) -> None:
    connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=60)
    connection.putrequest("POST", f"/{server.token}/landmarks.json")
    connection.putheader("Origin", f"http://127.0.0.1:{server.port}")
    connection.putheader("Content-Length", length)
    connection.endheaders()
    assert connection.getresponse().status == status
    connection.close()


def test_it_ends_when_all_is_placed(server: ViewerServer, tmp_path: Path) -> None:
    ask(server, "landmarks.json?finish", json.dumps(FILE).encode())
    server.wait()
    assert read_landmarks(tmp_path / "landmarks.json").vertices == {"chin": 3}


def test_a_written_page_brings_everything(photos: Path, tmp_path: Path) -> None:
    em.write(tmp_path / "head.npz", head())
    write_landmark_page(tmp_path / "page.html", landmark_task([photos], tmp_path / "head.npz"))
    page = (tmp_path / "page.html").read_text()
    elements = Elements(page)
    task = json.loads(elements.texts["elastomorph-landmarks"])
    assert task["save"] is None
    assert [place["source"] for place in task["places"]] == ["#place-0", "#place-1", "#place-2"]
    assert set(elements.texts) >= {"place-0", "place-1", "place-2"}
    with pytest.raises(em.FormatError, match=r"\.html"):
        write_landmark_page(tmp_path / "page.txt", landmark_task([photos]))


def test_a_page_holds_no_more_than_browsers_open(
    photos: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("elastomorph.viewer.landmarks._MOST_IN_A_PAGE", 10)
    with pytest.raises(em.ParameterError, match="more than browsers open; name fewer"):
        write_landmark_page(tmp_path / "page.html", landmark_task([photos]))
    assert not (tmp_path / "page.html").exists()


def test_cameras_of_photographs_are_told(photos: Path) -> None:
    camera = Camera("IMG_1.png", (4, 3), 7.0, np.ones(2), 0.1, np.eye(3), np.arange(3.0))
    task = landmark_task([photos], cameras={"neutral": [camera], "smile": [camera]})
    first, second = task.document(["a", "b"], [[], []])["places"]
    assert first["camera"] == {
        "focal": 7.0,
        "centre": [1.0, 1.0],
        "radial": 0.1,
        "rotation": [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        "translation": [0.0, 1.0, 2.0],
    }
    assert second["camera"] is None


def test_photographs_of_phones_are_refused_at_once(tmp_path: Path) -> None:
    folder = tmp_path / "neutral"
    folder.mkdir()
    (folder / "IMG_1.HEIC").write_bytes(b"\0\0\0\x18ftypheic" + bytes(16))
    with pytest.raises(em.FormatError, match=r"IMG_1\.HEIC: .*convert it to JPEG"):
        landmark_task([folder])


def test_cameras_of_a_working_folder(tmp_path: Path) -> None:
    """As the stages of a capture leave them; what is no result of theirs is passed over."""
    camera = Camera("IMG_1.png", (4, 3), 7.0, np.ones(2), 0.1, np.eye(3), np.arange(3.0))
    solved = SolvedPose((camera,), np.zeros((1, 3)), np.zeros((1, 128), np.float32), {})
    with WorkingFolder(tmp_path / "working") as working:
        working.made("cameras/neutral", {}, lambda: solved, 1)
    (tmp_path / "working" / "cameras" / "smile.npz").write_bytes(b"damaged")
    found = solved_cameras(tmp_path / "working")
    assert list(found) == ["neutral"]
    assert found["neutral"][0].name == "IMG_1.png"
    np.testing.assert_array_equal(found["neutral"][0].translation, camera.translation)
    with pytest.raises(em.FileError, match="no cameras are solved in it"):
        solved_cameras(tmp_path)


def test_poses_are_folders(tmp_path: Path) -> None:
    for pose in ("smile", "neutral"):
        (tmp_path / "photos" / pose).mkdir(parents=True)
        (tmp_path / "photos" / pose / "1.jpg").write_bytes(b"")
    places = landmark_task([tmp_path / "photos"]).places
    assert [(place.pose, place.name) for place in places] == [
        ("neutral", "1.jpg"),
        ("smile", "1.jpg"),
    ]


def test_a_folder_of_one_pose_is_its_name(tmp_path: Path) -> None:
    """As it is in a folder of several poses; photographs of several in one folder say it."""
    folder = tmp_path / "photos" / "neutral"
    folder.mkdir(parents=True)
    for name in ("anna_1.jpg", "anna_2.jpg"):
        (folder / name).write_bytes(b"")
    for place in (folder, tmp_path / "photos"):
        assert {each.pose for each in landmark_task([place]).places} == {"neutral"}
    (folder / "smile_1.jpg").write_bytes(b"")
    assert [each.pose for each in landmark_task([folder]).places] == ["anna", "anna", "smile"]


def test_what_cannot_be_shown_is_refused(tmp_path: Path, photos: Path) -> None:
    with pytest.raises(em.ParameterError, match="nothing to place points on"):
        landmark_task()
    with pytest.raises(em.ParameterError, match=r"two files called IMG_1\.png"):
        landmark_task([photos, photos])
    (tmp_path / "empty").mkdir()
    with pytest.raises(em.FileError, match="no JPEG, PNG or TIFF photographs"):
        landmark_task([tmp_path / "empty"])
    with pytest.raises(em.FileError, match=r"nowhere\.ply"):
        landmark_task([tmp_path / "nowhere.ply"])
    em.write(tmp_path / "points.ply", em.Mesh(np.eye(3)))
    with pytest.raises(em.MeshError, match=r"points\.ply has points but no polygons"):
        landmark_task([tmp_path / "points.ply"])
    with pytest.raises(em.FormatError, match="chin is vertex 99,999"):
        landmark_task(template="built-in", known=Landmarks(vertices={"chin": 99_999}))


def test_a_scan_has_the_colours_of_its_vertices(tmp_path: Path) -> None:
    (tmp_path / "scan.ply").write_text(
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
        "property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
        "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
        "0 0 0 1 2 3\n1 0 0 4 5 6\n0 1 0 7 8 9\n3 0 1 2\n"
    )
    (place,) = landmark_task([tmp_path / "scan.ply"]).places
    assert isinstance(place.content, PackedSurface)
    found = unpacked(place.content.content)[1]["colours"]
    np.testing.assert_array_equal(found[:, :3], np.arange(1, 10).reshape(3, 3))


def test_an_obj_has_them_too(tmp_path: Path) -> None:
    (tmp_path / "scan.obj").write_text("v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1\nf 1 2 3\n")
    (place,) = landmark_task([tmp_path / "scan.obj"]).places
    assert isinstance(place.content, PackedSurface)
    found = unpacked(place.content.content)[1]["colours"]
    np.testing.assert_array_equal(found[:, :3], 255 * np.eye(3))


def test_a_surface_is_packed_about_its_middle(tetrahedron: em.Mesh) -> None:
    far = tetrahedron.with_vertices(tetrahedron.vertices + 1e6)
    header, arrays = unpacked(pack_surface(far, edges=True).content)
    np.testing.assert_array_equal(arrays["positions"] + header["origin"], far.vertices)
    np.testing.assert_array_equal(arrays["triangles"], far.faces.triangles())
    np.testing.assert_array_equal(arrays["sources"], np.arange(4))
    np.testing.assert_array_equal(arrays["edges"], far.edges)
    assert header["parts"] == [{"start": 0, "count": 12, "image": -1}]
    assert unpacked(pack_surface(far, edges=False).content)[1]["edges"].size == 0


def test_a_seam_of_the_texture_splits_vertices(tetrahedron: em.Mesh) -> None:
    """Each part shows its image, and every corner keeps its vertex and its texture coordinate."""
    rng = np.random.default_rng(3)
    corners = np.array([0, 1, 2, 3, 4, 5, 1, 2, 6, 0, 6, 1], np.int32)
    looks = [
        Material(texture=Texture(text, "t", rotation=r)) for text, r in ((b"x", 0), (b"y", 0.5))
    ]
    mesh = em.Mesh(
        tetrahedron.vertices,
        tetrahedron.faces,
        UVMap(rng.random((7, 2)), corners),
        FaceLabels(("one", "other", "grey"), np.array([1, 0, 2, 0], np.int32)),
        appearance={"one": looks[0], "other": looks[1]},
    )
    packed = pack_surface(mesh, edges=True, colours=np.arange(12, dtype=np.uint8).reshape(4, 3))
    header, arrays = unpacked(packed.content)
    assert packed.images == (b"x", b"y")
    assert header["parts"] == [
        {"start": 0, "count": 3, "image": -1},
        {"start": 3, "count": 6, "image": 0},
        {"start": 9, "count": 3, "image": 1},
    ]
    order = [2, 1, 3, 0]  # polygons by image
    own = arrays["triangles"]
    np.testing.assert_array_equal(
        arrays["sources"][own], np.array([mesh.faces[face] for face in order])
    )
    expected = mesh.uv.coordinates[corners.reshape(4, 3)[order]]  # type: ignore[union-attr]
    np.testing.assert_allclose(arrays["uv"][own][:3], expected[:3], rtol=1e-6)
    u, from_top = expected[3, :, 0], 1 - expected[3, :, 1]
    across = np.cos(0.5) * u + np.sin(0.5) * from_top
    np.testing.assert_allclose(arrays["uv"][own][3, :, 0], across, rtol=1e-6)
    np.testing.assert_array_equal(
        arrays["colours"][:, :3], np.arange(12).reshape(4, 3)[arrays["sources"]]
    )
    np.testing.assert_array_equal(np.sort(arrays["sources"][arrays["edges"]], axis=1), mesh.edges)
