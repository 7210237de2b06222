"""What cannot be is said at once, in a sentence that says what to do, and nothing is written."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import ExifTags, Image
from small_captures import landmarks, template, write_photographs

import elastomorph as em
from elastomorph.capturing.landmarks import LANDMARKS, Landmarks, write_landmarks
from elastomorph.capturing.work import request
from elastomorph.capturing.work import request as requests
from elastomorph.capturing.work.request import Request, requested
from elastomorph.capturing.work.template import Template
from elastomorph.model.mesh import Source
from needs import extra, not_root

extra("pycolmap", "capture")

POINTS = landmarks()
CLICKS = POINTS.photographs["neutral"]


@pytest.fixture
def photos(tmp_path: Path) -> Path:
    return write_photographs(tmp_path / "photos")


def asked(photos: Any, output: Path, shape: Any = None, **options: Any) -> Request:
    given: dict[str, Any] = {
        "neutral": None,
        "landmarks": POINTS,
        "distance": None,
        "rig": "walking",
        "masks": None,
        "to": "poses",
        "working": None,
    }
    shape = template() if shape is None else None if shape is False else shape
    return requested(photos, shape, output=output, **given | options)


def only(*names: str) -> dict[str, tuple[float, float]]:
    return dict.fromkeys(names, (1.0, 2.0))


# The vertices of left and right landmarks, exchanged.
OTHER_SIDE = {"left": "right", "right": "left"}
SIDES = [
    POINTS.vertices["_".join(OTHER_SIDE.get(word, word) for word in name.split("_"))]
    for name in POINTS.vertices
]
FEW = list(LANDMARKS)[:5]

REFUSED: list[tuple[str, dict[str, Any], str]] = [
    ("goal", {"to": "meshes"}, "to must be cameras, neutral or poses, found 'meshes'"),
    ("rig", {"rig": "moving"}, "rig must be walking or fixed, found 'moving'"),
    ("neutral", {"neutral": "rest"}, "there is no pose 'rest' to be the neutral: there are a, b"),
    ("no template", {"shape": False}, r"a template is needed, .*\(--to cameras\)"),
    ("no such template", {"shape": "nowhere.obj"}, r"nowhere\.obj: there is no such file"),
    (
        "a template of another kind",
        {"shape": "face.stl"},
        r"unknown suffix '\.stl'; .*\.obj, \.ply",
    ),
    ("a number as template", {"shape": 3}, "template must be a mesh or a file, found int"),
    ("points as template", {"shape": em.Mesh(np.eye(3))}, "expected the surface of a face"),
    ("no landmarks", {"landmarks": None}, "landmarks are needed .*'elastomorph landmarks'"),
    ("no such landmarks", {"landmarks": "nowhere.json"}, r"nowhere\.json: there is no such file"),
    (
        "landmarks of another pose",
        {"landmarks": Landmarks(POINTS.vertices, {"a": CLICKS, "b": CLICKS})},
        "no landmarks in photographs of the neutral 'neutral', only of a, b; place them",
    ),
    (
        "landmarks in photographs that are not there",
        {"landmarks": Landmarks(POINTS.vertices, {"neutral": {**CLICKS, "9.jpg": only("chin")}})},
        r"9\.jpg of pose 'neutral' has landmarks, but there is no such photograph",
    ),
    (
        "too few landmarks",
        {"landmarks": Landmarks(POINTS.vertices, {"neutral": dict.fromkeys(CLICKS, only(*FEW))})},
        "5 of 15 landmarks are on the template and in two photographs of 'neutral' or more, at "
        "least 6 are needed; place nose_bridge, right_nostril",
    ),
    (
        "landmarks in one photograph",
        {"landmarks": Landmarks(POINTS.vertices, {"neutral": {"0.jpg": only(*LANDMARKS)}})},
        "0 of 15 landmarks",
    ),
    (
        "no landmarks on the template",
        {"landmarks": Landmarks({}, POINTS.photographs)},
        "0 of 15 landmarks are on the template",
    ),
    (
        "landmarks of another template",
        {"landmarks": replace(POINTS, vertices={"chin": 144})},
        r"chin is vertex 144, but the template has 144 \(0 to 143\): the landmarks were placed on",
    ),
    (
        "landmarks of the template exchanged",
        {"landmarks": replace(POINTS, vertices=dict(zip(POINTS.vertices, SIDES, strict=True)))},
        "the template: the landmarks are those of a mirrored face",
    ),
    (
        "landmarks that are on no face",
        {"landmarks": replace(POINTS, vertices={name: k for k, name in enumerate(LANDMARKS)})},
        "the template: the landmarks do not lie as on a face",
    ),
    (
        "a distance of words",
        {"distance": "chin=three"},
        "distance 'chin=three': expected two points",
    ),
    ("a distance of one", {"distance": "chin,chin=3"}, "expected two points that were clicked"),
    ("a distance of nothing", {"distance": ("chin", "nose_tip", 0)}, "number above 0, found 0"),
    ("a distance of none", {"distance": "a,b=1"}, "a, from which a distance is known, is in 0 ph"),
    (
        "a distance of cameras",
        {"distance": "chin,nose_tip=3", "to": "cameras"},
        "a distance is known between landmarks, which cameras alone do without",
    ),
    ("masks elsewhere", {"masks": "nowhere"}, "nowhere: there is no such folder of masks"),
]


@pytest.mark.parametrize(
    ("options", "message"), [case[1:] for case in REFUSED], ids=[case[0] for case in REFUSED]
)
def test_is_refused_before_any_work(
    photos: Path, tmp_path: Path, options: dict[str, Any], message: str
) -> None:
    with pytest.raises(em.ElastomorphError, match=message) as caught:
        asked(photos, tmp_path / "poses", **options)
    assert "\n" not in str(caught.value)
    assert not [file for file in tmp_path.rglob("*") if file.is_file() and file.suffix != ".jpg"]
    assert not (tmp_path / "poses").exists()


@pytest.mark.parametrize(
    ("size", "orientation", "place", "inside"),
    [
        ((300, 200), 1, (299.4, 199.4), True),
        ((300, 200), 1, (-0.4, -0.4), True),
        ((300, 200), 1, (250.0, 200.0), False),
        ((300, 200), 1, (-1.0, 20.0), False),
        ((300, 200), 1, (float("nan"), 20.0), False),
        ((300, 200), 6, (150.0, 250.0), True),
        ((300, 200), 6, (250.0, 150.0), False),
    ],
)
def test_landmarks_outside_their_photograph_are_refused_at_once(
    photos: Path,
    tmp_path: Path,
    size: tuple[int, int],
    orientation: int,
    place: tuple[float, float],
    inside: bool,
) -> None:
    """Pixels are those of the photograph as it is seen upright, whose centres are at integers."""
    exif = Image.Exif()
    exif[ExifTags.Base.Orientation] = orientation
    Image.new("RGB", size).save(photos / "neutral" / "1.jpg", exif=exif)
    clicks = {**CLICKS, "1.jpg": {**CLICKS["1.jpg"], "chin": place}}
    points = replace(POINTS, photographs={"neutral": clicks})
    if inside:
        asked(photos, tmp_path / "poses", landmarks=points)
        return
    outside = r"1\.jpg of pose 'neutral': chin is at .* outside"
    with pytest.raises(em.ElastomorphError, match=outside):
        asked(photos, tmp_path / "poses", landmarks=points)
    assert not (tmp_path / "poses").exists()


def test_photographs_that_are_not_there(photos: Path, tmp_path: Path) -> None:
    output = tmp_path / "poses"
    (tmp_path / "empty").mkdir()
    cases: list[tuple[Any, str]] = [
        (tmp_path / "nowhere", "nowhere"),
        (tmp_path / "empty", "no JPEG, PNG or TIFF photographs in it"),
        ({}, "there are no poses"),
        (3, "photos must be a folder of photographs, or pose → photographs; found int"),
        ({"neutral": 3}, "pose 'neutral': expected files of photographs, found 3"),
        ({"neutral": ["nowhere.jpg"]}, "there is no such photograph of pose 'neutral'"),
        ({"a/b": [photos / "a" / "0.jpg"]}, "it names a file, so it may hold no slash"),
        ({"a": photos / "a", "A": photos / "b"}, "poses 'a' and 'A' would be one file"),
        (
            {"a": [photos / "a" / "0.jpg", photos / "b" / "0.jpg"]},
            r"are both called 0\.jpg; each photograph of a pose needs a name of its own",
        ),
        ({"a": photos / "a"}, r"photographs of one pose only, a: .*\(--to neutral\)"),
    ]
    for given, message in cases:
        with pytest.raises(em.ElastomorphError, match=message):
            asked(given, output)


def test_two_poses_named_as_the_neutral(photos: Path, tmp_path: Path) -> None:
    shutil.copytree(photos / "neutral", photos / "neutral again")
    with pytest.raises(em.CaptureError, match="neutral and neutral again are both named as the"):
        asked(photos, tmp_path / "poses")
    assert asked(photos, tmp_path / "poses", neutral="neutral").neutral == "neutral"


def test_poses_are_those_of_folders_of_names_or_as_they_are_given(
    photos: Path, tmp_path: Path
) -> None:
    flat = tmp_path / "flat"
    flat.mkdir()
    for file in photos.rglob("*.jpg"):
        shutil.copy(file, flat / f"{file.parent.name}_{file.name}")
    given = {pose: photos / pose for pose in ("c", "neutral", "a")}
    for place, poses in (
        (photos, ["neutral", "a", "b", "c"]),
        (flat, ["neutral", "a", "b", "c"]),
        (given, ["c", "neutral", "a"]),
    ):
        found = asked(place, tmp_path / "poses", shape=False, landmarks=None, to="cameras")
        assert list(found.poses) == poses
        assert found.neutral == "neutral"
        assert all(len(files) == 6 for files in found.poses.values())


def test_landmarks_beside_the_photographs_are_found(photos: Path, tmp_path: Path) -> None:
    write_landmarks(photos / "landmarks.json", POINTS)
    found = asked(photos, tmp_path / "poses", landmarks=None)
    assert found.landmarks.vertices == POINTS.vertices


def test_an_output_that_holds_other_meshes_is_left_alone(photos: Path, tmp_path: Path) -> None:
    output = tmp_path / "poses"
    output.mkdir()
    (output / "scan.obj").write_text("v 0 0 0\n")
    with pytest.raises(em.FileError, match=r"scan\.obj is already there and is none of the poses"):
        asked(photos, output)
    (output / "scan.obj").rename(output / "a.obj")
    with pytest.raises(em.FileError, match=r"a\.obj: it is already there and not from a capture"):
        asked(photos, output)
    (output / "capture.json").write_text("{}")  # a pose of an earlier run is replaced
    asked(photos, output)


@pytest.mark.parametrize("name", ["capture", "capture/.capture"])
def test_folders_are_not_made_where_one_is_refused(
    photos: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    before = sorted(tmp_path.rglob("*"))
    whole = shutil.disk_usage(tmp_path)
    monkeypatch.setattr(request.shutil, "disk_usage", lambda _: whole._replace(free=0))
    with pytest.raises(em.FileError, match="0 MiB are free on its disk"):
        asked(photos, tmp_path / "new" / "poses", working=tmp_path / "working" / name)
    assert sorted(tmp_path.rglob("*")) == before


@not_root
def test_an_output_that_cannot_be_written_in(photos: Path, tmp_path: Path) -> None:
    output = tmp_path / "poses"
    output.mkdir(mode=0o500)
    with pytest.raises(em.FileError, match=r"it cannot be written in \(Permission denied\)"):
        asked(photos, output)


def test_an_output_that_is_a_file(photos: Path, tmp_path: Path) -> None:
    (tmp_path / "poses").write_text("")
    with pytest.raises(em.FileError, match="this is a file; name a folder"):
        asked(photos, tmp_path / "poses")


def test_a_disk_without_room(photos: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = shutil.disk_usage(tmp_path)
    monkeypatch.setattr(request.shutil, "disk_usage", lambda _: whole._replace(free=200 << 20))
    with pytest.raises(em.FileError, match="200 MiB are free on its disk, about 260 are needed"):
        asked(photos, tmp_path / "poses")


@pytest.mark.parametrize("module", ["pycolmap", "cv2", "embreex"])
def test_without_the_extra_one_sentence_says_what_to_install(
    photos: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, module: str
) -> None:
    monkeypatch.setattr(
        requests, "find_spec", lambda name: None if name == module else find_spec(name)
    )
    with pytest.raises(em.MissingExtraError, match=r"pip install 'elastomorph\[capture\]'"):
        asked(photos, tmp_path / "poses")


def test_a_template_comes_through_any_door(tmp_path: Path) -> None:
    shape = template()
    em.write(tmp_path / "face.obj", shape)
    em.write(tmp_path / "face.npz", shape)
    rig = em.Rig(shape, {"smile": em.interpolate(shape, shape.with_vertices(shape.vertices * 2))})
    doors: list[tuple[Any, Callable[[em.Mesh], bool]]] = [(shape, lambda mesh: mesh is shape)]
    for name in ("face.obj", "face.npz"):
        doors.append((tmp_path / name, lambda mesh: mesh.faces == shape.faces))
    for name in ("rig.npz", "rig.glb"):
        em.write(tmp_path / name, rig)
        doors.append((str(tmp_path / name), lambda mesh: len(mesh.vertices) >= 144))
    folder = tmp_path / "folder"
    folder.mkdir()
    em.write(folder / "neutral.obj", shape)
    em.write(folder / "smile.obj", shape)
    doors.append((folder, lambda mesh: mesh.faces == shape.faces))
    for door, right in doors:
        found = Template.named(door)
        assert right(found.mesh)
        assert found.known == {}
        np.testing.assert_allclose(found.work.vertices[found.place], found.mesh.vertices)
    ours = Template.named("built-in")
    assert set(ours.known) == set(LANDMARKS)


def test_vertices_of_a_template_that_a_format_splits_are_one_at_seams() -> None:
    """A square of two triangles that share an edge, each with corners of its own."""
    corners = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float)
    grid = np.concatenate([corners + [x, y, 0] for x in range(10) for y in range(10)])
    faces = np.arange(len(grid)).reshape(-1, 4)
    apart = em.Mesh(grid, faces, source=Source("face.glb", split=True))
    found = Template.of(apart)
    assert len(found.work.vertices) == 121
    np.testing.assert_array_equal(found.work.vertices[found.place], grid)
    np.testing.assert_array_equal(grid[found.first], found.work.vertices)
    assert found.vertices_of({"chin": 7}, "file") == {"chin": int(found.place[7])}
    kept = Template.of(em.Mesh(grid, faces))  # in other formats an artist keeps them apart
    assert len(kept.work.vertices) == 400
