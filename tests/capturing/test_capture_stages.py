"""A capture goes on after any interruption, with the same result, and makes again what changed."""

from __future__ import annotations

import shutil
import signal
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from small_captures import COUNT, POSES, Counted, landmarks, run, template, write_photographs

import elastomorph as em
from children import started
from elastomorph.capturing.cameras.models import write_colmap
from elastomorph.capturing.geometry import Camera
from elastomorph.capturing.work.request import requested
from elastomorph.io.mtl import with_looks
from elastomorph.io.npz.members import open_npz
from elastomorph.model.mesh import FaceLabels, UVMap

EXAMINED = [f"photographs/{pose}" for pose in sorted(POSES, key="nabc".find)]
OTHERS = ["cameras/a", "cameras/b", "cameras/c"]
SURFACES = ["neutral", "frames", "frames", "frames", "poses", "poses", "poses"]
STAGES = [*EXAMINED, "cameras/neutral", "placed", *OTHERS, *SURFACES]


@pytest.fixture
def photos(tmp_path: Path) -> Path:
    return write_photographs(tmp_path / "photos")


def files_of(folder: Path) -> dict[str, bytes]:
    return {file.name: file.read_bytes() for file in folder.iterdir() if file.is_file()}


def apart_from_seconds(files: dict[str, bytes]) -> dict[str, bytes]:
    import json

    content = json.loads(files["capture.json"])
    content.pop("seconds")
    return files | {"capture.json": json.dumps(content).encode()}


def test_all_stages_are_made_once_and_leave_poses_confidence_and_figures(
    photos: Path, tmp_path: Path
) -> None:
    counted = Counted([])
    captured = run(photos, tmp_path / "poses", counted)
    assert counted.calls == STAGES
    assert list(captured.poses) == ["neutral", "a", "b", "c"]
    written = files_of(tmp_path / "poses")
    assert set(written) == {*(f"{p}.obj" for p in POSES), "confidence.npz", "capture.json"}
    with open_npz(tmp_path / "poses" / "confidence.npz") as members:
        for pose, mesh in captured.poses.items():
            read = em.read(tmp_path / "poses" / f"{pose}.obj")
            np.testing.assert_array_equal(read.vertices, mesh.vertices)
            assert read.faces == template().faces
            found = members.array(pose, "f", (len(mesh.vertices),))
            assert found.dtype == np.float32
            np.testing.assert_array_equal(found, mesh.confidence)
    assert {pose: len(own) for pose, own in captured.cameras.items()} == dict.fromkeys(POSES, COUNT)
    remarks = {pose: own["remarks"] for pose, own in captured.figures["poses"].items()}
    expected = {pose: ["one camera"] for pose in POSES}
    expected["neutral"] = ["one camera", "the chin lacks"]
    assert remarks == expected


@pytest.mark.parametrize(
    ("neutral", "order", "chain"),
    [
        (None, ["neutral", "a", "b", "c"], {"a": "neutral", "b": "a", "c": "b"}),
        ("b", ["a", "b", "c", "neutral"], {"c": "b", "neutral": "c", "a": "b"}),
    ],
)
def test_poses_are_chained_from_the_neutral_to_both_sides(
    photos: Path, tmp_path: Path, neutral: str | None, order: list[str], chain: dict[str, str]
) -> None:
    request = requested(
        photos,
        None,
        output=tmp_path / "poses",
        neutral=neutral,
        landmarks=None,
        distance=None,
        rig="walking",
        masks=None,
        to="cameras",
        working=None,
    )
    assert list(request.poses) == order
    assert request.chain == chain


@pytest.mark.parametrize("stage", range(len(STAGES)))
@pytest.mark.parametrize("error", [KeyboardInterrupt, MemoryError])
def test_a_run_interrupted_at_any_stage_goes_on_with_the_same_result(
    photos: Path, tmp_path: Path, stage: int, error: type[BaseException]
) -> None:
    whole = Counted([])
    run(photos, tmp_path / "whole", whole)
    first = Counted([])

    def interrupt(name: str) -> None:
        if len(first.calls) == stage:
            raise error

    first.before = interrupt
    with pytest.raises(error):
        run(photos, tmp_path / "poses", first)
    assert not files_of(tmp_path / "poses")
    second = Counted([])
    run(photos, tmp_path / "poses", second)
    assert first.calls + second.calls == whole.calls
    assert apart_from_seconds(files_of(tmp_path / "poses")) == apart_from_seconds(
        files_of(tmp_path / "whole")
    )
    third = Counted([])
    run(photos, tmp_path / "poses", third)
    assert third.calls == []


def changed(photos: Path, output: Path, **options: Any) -> list[str]:
    """What is made again, after all was made, with the result of a run that made all of it."""
    version = options.pop("version", "1")
    again, fresh = (Counted([], version=version) for _ in range(2))
    run(photos, output, again, **options)
    run(photos, output.with_name("fresh"), fresh, **options)
    shown = [apart_from_seconds(files_of(folder)) for folder in (output, output.with_name("fresh"))]
    assert shown[0] == shown[1]
    shutil.rmtree(output.with_name("fresh"))
    return again.calls


def test_what_changed_and_what_depends_on_it_is_made_again_and_no_more(
    photos: Path, tmp_path: Path
) -> None:
    output = tmp_path / "poses"
    run(photos, output, Counted([]))
    assert changed(photos, output) == []

    (photos / "c" / "3.jpg").write_text("another")
    assert changed(photos, output) == ["photographs/c", "cameras/c", "frames", "poses"]

    (photos / "a" / "new.jpg").write_text("one more")  # b and c are chained behind a
    assert changed(photos, output) == [
        *("photographs/a", "cameras/a", "frames", "poses", "poses", "poses")
    ]

    # The lens of all is that of the neutral: what was made of other photographs is all there is.
    (photos / "neutral" / "3.jpg").write_text("another neutral")
    assert changed(photos, output) == ["photographs/neutral", *STAGES[4:]]

    where = landmarks()
    moved = {**where.photographs["neutral"]["1.jpg"], "chin": (3.0, 4.5)}
    clicks = {"neutral": {**where.photographs["neutral"], "1.jpg": moved}}
    options = {"landmarks": type(where)(where.vertices, clicks)}
    # The neutral is brought to the template by vertices alone here: nothing else changes.
    assert changed(photos, output, **options) == ["placed"]

    beside = {**where.vertices, "chin": where.vertices["chin"] + 1}
    options["landmarks"] = type(where)(beside, clicks)
    assert changed(photos, output, **options) == ["placed", *SURFACES]

    other = template()
    options["template"] = other.with_vertices(other.vertices * [1, 1, 1.1])
    assert changed(photos, output, **options) == ["placed", *SURFACES]

    options["distance"] = "chin,nose_tip=8.9"
    assert changed(photos, output, **options) == ["placed", *SURFACES]

    options["rig"] = "fixed"
    assert changed(photos, output, **options) == ["rig", *STAGES[5:]]

    whole = Counted([])
    run(photos, tmp_path / "whole", whole, **options)
    assert changed(photos, output, version="2", **options) == whole.calls


def test_what_is_not_used_changes_nothing(photos: Path, tmp_path: Path) -> None:
    """Where photographs lie, their dates, and files that are no photographs."""
    output = tmp_path / "poses"
    run(photos, output, Counted([]))
    moved = photos.rename(tmp_path / "elsewhere")
    for file in moved.rglob("*.jpg"):
        file.touch()
    (moved / "a" / "notes.txt").write_text("taken on Monday")
    assert changed(moved, output) == []
    shutil.move(output, tmp_path / "moved")
    assert changed(moved, tmp_path / "moved") == []


def test_each_goal_goes_on_from_the_one_before(photos: Path, tmp_path: Path) -> None:
    output = tmp_path / "poses"
    cameras, neutral, poses = (Counted([]) for _ in range(3))
    run(photos, output, cameras, to="cameras", template=None, landmarks=None)
    assert cameras.calls == [*EXAMINED, "cameras/neutral", *OTHERS]
    assert set(files_of(output)) == {"capture.json"}
    found = run(photos, output, neutral, to="neutral")
    assert neutral.calls == ["placed", "neutral"]
    assert list(found.poses) == list(found.cameras) == ["neutral"]
    assert set(files_of(output)) == {"capture.json", "confidence.npz", "neutral.obj"}
    run(photos, output, poses)
    assert poses.calls == ["frames"] * 3 + ["poses"] * 3


PROGRAM = """
import sys
from pathlib import Path
sys.path.insert(0, sys.argv[1])
from small_captures import Counted, run, slow
run(Path(sys.argv[2]), Path(sys.argv[3]), Counted([], slow))
print("done", flush=True)
"""


@pytest.mark.slow
def test_a_capture_that_is_killed_again_and_again_comes_to_its_end(
    photos: Path, tmp_path: Path
) -> None:
    run(photos, tmp_path / "whole", Counted([]))
    words = [str(Path(__file__).parent), str(photos), str(tmp_path / "poses")]
    made: list[str] = []
    for count in range(40):
        with started("-c", PROGRAM, *words, stdout=-1) as child:
            assert child.stdout is not None
            # A stage or two are finished when the next begins; some moment of that is the last.
            own = [child.stdout.readline().strip() for _ in range(2 + count % 2)]
            time.sleep(0.01 * (count % 5))
            child.send_signal(signal.SIGKILL)
            own = [*filter(None, own), *child.stdout.read().split()]
        # Of each run only the last stage was not finished, or it was and had no time for the next.
        assert own[0] in made[-1:] or own[0] not in made or own[0] in ("frames", "poses")
        made += own
        if own[-1] == "done":
            break
    assert made[-1] == "done"
    assert len(made) <= 2 * len(STAGES)
    assert apart_from_seconds(files_of(tmp_path / "poses")) == apart_from_seconds(
        files_of(tmp_path / "whole")
    )


def with_cameras(photos: Path, place: Path, pose: str, seed: int = 1) -> None:
    """Photographs of a pose that can be opened, and a model of where they were taken from."""
    for k in range(COUNT):
        Image.new("L", (80, 64), COUNT * POSES.index(pose) + k).save(photos / pose / f"{k}.jpg")
    random = np.random.default_rng(seed)
    middle = np.array([39.5, 31.5])
    cameras = [
        Camera(f"{k}.jpg", (80, 64), 50.0, middle, 0.0, np.eye(3), random.random(3))
        for k in range(COUNT)
    ]
    write_colmap(place, cameras, np.zeros((0, 3)))


def test_cameras_that_are_given_take_the_place_of_those_that_are_found(
    photos: Path, tmp_path: Path
) -> None:
    """Of the neutral alone; the others are found, and what changes is made again."""
    model, working = tmp_path / "model" / "neutral", tmp_path / "working"
    with_cameras(photos, model, "neutral")
    counted = Counted([])
    captured = run(photos, tmp_path / "one", counted, cameras=model.parent, working=working)
    assert [call for call in counted.calls if "/" in call][4:] == ["given/neutral", *OTHERS]
    focals = {camera.focal for camera in captured.cameras["neutral"]}
    assert len(focals) == 1
    again = Counted([])
    run(photos, tmp_path / "two", again, cameras=model.parent, working=working)
    assert again.calls == []
    with_cameras(photos, model, "neutral", seed=2)
    run(photos, tmp_path / "three", again, cameras=model.parent, working=working)
    assert again.calls[:2] == ["given/neutral", "placed"]


def test_cameras_that_are_given_and_stay_are_those_of_all_poses(
    photos: Path, tmp_path: Path
) -> None:
    with_cameras(photos, tmp_path / "model", "neutral")
    counted = Counted([])
    run(photos, tmp_path / "poses", counted, cameras=tmp_path / "model", rig="fixed")
    assert [call for call in counted.calls if "/" in call][4:] == ["given/neutral", *OTHERS]
    assert "rig" not in counted.calls


def test_cameras_are_written_for_others_and_read_again(photos: Path, tmp_path: Path) -> None:
    """In the frame of the template, as the poses are."""
    for pose in POSES:
        with_cameras(photos, tmp_path / "model" / pose, pose)
    given = Counted([])
    captured = run(photos, tmp_path / "poses", given, cameras=tmp_path / "model", to="cameras")
    assert not [call for call in given.calls if call.startswith("cameras")]
    place = tmp_path / "poses" / "cameras"
    request = requested(
        photos,
        None,
        output=tmp_path / "again",
        **dict.fromkeys(["neutral", "landmarks", "distance", "masks", "working"]),
        rig="walking",
        to="cameras",
        cameras=place,
    )
    assert list(request.cameras) == list(captured.cameras)
    for pose, cameras in captured.cameras.items():
        (found,) = request.cameras[pose]
        for one, other in zip(found, cameras, strict=True):
            np.testing.assert_allclose(one.position, other.position, atol=1e-12)
        assert (place / f"{pose}.out").exists()  # the axis is in the middle
    with pytest.raises(em.FileError, match="cameras of this capture are written there"):
        run(photos, tmp_path / "poses", given, cameras=place / "neutral", to="cameras")
    with pytest.raises(em.FileError, match="there is no such folder or file of cameras"):
        run(photos, tmp_path / "poses", given, cameras=tmp_path / "nowhere", to="cameras")


def with_coordinates(materials: FaceLabels | None = None) -> em.Mesh:
    mesh = template()
    uv = (mesh.vertices[:, :2] - mesh.vertices[:, :2].min(axis=0)) / 40
    return em.Mesh(mesh.vertices, mesh.faces, UVMap(uv, mesh.faces.indices), materials)


@pytest.mark.parametrize("materials", [False, True])
def test_the_texture_is_written_beside_the_poses_and_into_the_glb(
    photos: Path, tmp_path: Path, materials: bool
) -> None:
    """Whatever reads an OBJ with its library, or a GLB, shows it; other materials stay."""
    count = len(template().faces)
    labels = FaceLabels(("M face", "teeth"), (np.arange(count) > 50).astype(np.int32))
    shape = with_coordinates(labels if materials else None)
    counted = Counted([])
    captured = run(photos, tmp_path / "poses", counted, template=shape)
    assert counted.calls.count("texture") == 1
    name, key = ("M face", "M face") if materials else ("skin", "")
    image = "neutral_M_face.png" if materials else "neutral.png"
    painted = captured.textures[key]
    assert captured.figures["texture"] == {key: {"side": 16, "seen": 0.25}}
    with Image.open(tmp_path / "poses" / image) as found:
        np.testing.assert_array_equal(np.asarray(found), painted.image)
    with Image.open(tmp_path / "poses" / image.replace(".png", "_seen.png")) as found:
        np.testing.assert_array_equal(np.asarray(found) > 0, painted.seen)
    for pose in POSES:
        read = with_looks(em.read(tmp_path / "poses" / f"{pose}.obj"))
        assert read.appearance is not None
        texture = read.appearance[name].texture
        assert texture is not None
        assert texture.image == (tmp_path / "poses" / image).read_bytes()
        assert read.materials is not None
        assert read.materials.names == (("M face", "teeth") if materials else ("skin",))
        assert captured.poses[pose].faces == shape.faces
    glb = em.read_rig(tmp_path / "poses" / "neutral.glb").neutral
    assert glb.appearance is not None
    texture = glb.appearance[name].texture
    assert texture is not None
    assert texture.image == (tmp_path / "poses" / image).read_bytes()
    before = files_of(tmp_path / "poses")
    run(photos, tmp_path / "poses", again := Counted([]), template=shape)
    assert again.calls == []
    assert apart_from_seconds(files_of(tmp_path / "poses")) == apart_from_seconds(before)


def test_a_template_without_texture_coordinates_gets_a_sentence(
    photos: Path, tmp_path: Path
) -> None:
    captured = run(photos, tmp_path / "poses", Counted([]))
    assert "has no texture coordinates" in captured.figures["texture"]
    assert not list((tmp_path / "poses").glob("*.png"))


def test_a_template_is_not_written_over_by_its_texture(photos: Path, tmp_path: Path) -> None:
    (tmp_path / "poses").mkdir()
    (tmp_path / "poses" / "neutral.glb").write_text("somebody's")
    with pytest.raises(em.FileError, match="already there and not from a capture"):
        run(photos, tmp_path / "poses", Counted([]), template=with_coordinates())
