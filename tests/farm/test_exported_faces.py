"""Pictures with labels as training code reads them: three formats that say the same."""

from __future__ import annotations

import io
import json
import shutil
import tarfile
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from scipy.spatial.transform import Rotation

import elastomorph as em
from elastomorph.farm.reading import export
from elastomorph.model.mesh import FaceLabels
from elastomorph.rig.build import with_paths
from needs import extra
from small_head import bare_head, tracked_points

COUNT, SIDE = 5, 32


@pytest.fixture(scope="module")
def faces(tmp_path_factory: pytest.TempPathFactory) -> em.FaceSet:
    place = tmp_path_factory.mktemp("faces") / "p.zarr"
    return em.make_faces(
        with_paths(bare_head()), place, COUNT, render=SIDE, landmarks=tracked_points()
    )


@pytest.fixture(scope="module")
def labels(faces: em.FaceSet, tmp_path_factory: pytest.TempPathFactory) -> list[dict[str, object]]:
    folder = tmp_path_factory.mktemp("exported") / "folder"
    faces.export(folder, "folder")
    images = faces.as_images()
    for i in range(COUNT):
        picture = np.asarray(Image.open(folder / f"{i:09d}.png"))
        np.testing.assert_array_equal(picture, images[i]["colour"])
        np.testing.assert_array_equal(np.load(folder / f"{i:09d}.depth.npy"), images[i]["depth"])
    assert len(list(folder.iterdir())) == 5 * COUNT
    return [json.loads((folder / f"{i:09d}.json").read_text()) for i in range(COUNT)]


def test_labels_are_those_of_the_data_set(
    faces: em.FaceSet, labels: list[dict[str, object]]
) -> None:
    images = faces.as_images()
    names = images.arrays["landmarks"].attributes["names"]
    assert list(names) == [str(number) for number in range(68)]
    for i, label in enumerate(labels):
        weights = dict(zip(faces.rig.names, faces.weights[i], strict=True))
        assert label["weights"] == pytest.approx(weights)
        assert label["landmarks"] == dict(zip(names, images[i]["landmarks"].tolist(), strict=True))
        np.testing.assert_array_equal(label["camera"], images[i]["camera"])
        left, top, width, height = label["box"]
        assert 0 <= left < left + width <= SIDE
        assert 0 <= top < top + height <= SIDE
        inside = np.array([[x + 0.5, y + 0.5] for x, y, _ in label["landmarks"].values()])
        inside = np.clip(inside, 0, SIDE)  # the middles of the jaw's first points do not move
        assert (
            np.mean(
                (inside >= [left - 1, top - 1]) & (inside <= [left + width + 1, top + height + 1])
            )
            > 0.9
        )


def test_coco_is_read_by_its_own_library(
    faces: em.FaceSet, labels: list[dict[str, object]], tmp_path: Path
) -> None:
    coco = extra("pycocotools.coco", "dev")
    faces.export(tmp_path / "coco", "coco")
    read = coco.COCO(str(tmp_path / "coco" / "annotations.json"))
    assert len(read.getImgIds()) == COUNT
    for number in read.getImgIds():
        label = labels[number - 1]
        (own,) = read.loadAnns(read.getAnnIds([number]))
        assert own["bbox"] == label["box"]
        points = np.reshape(own["keypoints"], (-1, 3))
        expected = np.array(list(label["landmarks"].values()))
        kept = points[:, 2] > 0
        assert own["num_keypoints"] == kept.sum()
        np.testing.assert_allclose(points[kept, :2], expected[kept, :2] + 0.5)
        np.testing.assert_array_equal(points[kept, 2], 1 + expected[kept, 2])
        beside = expected[~kept, :2] + 0.5
        assert np.all((beside < 0).any(axis=1) | (beside > SIDE).any(axis=1))
        (image,) = read.loadImgs([number])
        assert (tmp_path / "coco" / "images" / image["file_name"]).is_file()


def test_shards_hold_samples_of_one_key_in_order(
    faces: em.FaceSet,
    labels: list[dict[str, object]],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """As WebDataset reads them: files of a sample follow each other, alike but for suffixes."""
    monkeypatch.setattr(export, "_SHARD", 2)
    written = export.export_faces(faces, tmp_path / "shards", "webdataset")
    assert [file.name for file in written] == [f"faces-{i:06d}.tar" for i in range(3)]
    keys, found = [], []
    for file in written:
        with tarfile.open(file) as tar:
            for entry in tar:
                key, _, suffix = entry.name.partition(".")
                keys += [key] if not keys or keys[-1] != key else []
                if suffix == "json":
                    found.append(json.load(tar.extractfile(entry)))
                if suffix == "png":
                    assert Image.open(io.BytesIO(tar.extractfile(entry).read())).size == (
                        SIDE,
                        SIDE,
                    )
    assert keys == [f"{i:09d}" for i in range(COUNT)]
    assert found == labels


@pytest.mark.parametrize("to", export.LAYOUTS)
def test_pictures_that_cannot_be_read_leave_no_folder(
    faces: em.FaceSet, tmp_path: Path, to: str
) -> None:
    shutil.copytree(faces.data.order.folder, tmp_path / "damaged.zarr")
    shard = tmp_path / "damaged.zarr/images/colour/c.0.0.0.0"
    shard.write_bytes(shard.read_bytes()[:-100])
    with pytest.raises(em.ElastomorphError):
        em.open_faces(tmp_path / "damaged.zarr").export(tmp_path / "out" / "faces", to)
    assert not (tmp_path / "out").exists()


def test_gaze_is_the_turn_of_the_eyeball(tmp_path: Path) -> None:
    """An eye that its slider turns by 30° to the left, seen by a camera without a turn."""
    angles = np.linspace(0, 2 * np.pi, 6, endpoint=False)
    ring = np.stack([np.cos(angles), np.sin(angles), np.ones(6)], axis=1)
    eye = np.concatenate([[[0, 0, 1.5]], ring, 0.5 * ring])
    skin = np.array([[-4.0, -4, 0], [4, -4, 0], [4, 4, 0], [-4, 4, 0]])
    rest = np.concatenate([eye + [2, 0, 0], eye + [-2, 0, 0], skin])
    turned = rest.copy()
    turn = Rotation.from_euler("y", 30, degrees=True)
    turned[:13] = turn.apply(eye) + [2, 0, 0]
    turned[26:] += [0, 0, 0.5]
    polygons = [[o, o + 1 + i, o + 1 + (i + 1) % 6] for o in (0, 13) for i in range(6)]
    names = FaceLabels(("eye", "skin"), np.array([0] * 12 + [1], dtype=np.int32))
    neutral = em.Mesh(rest, [*polygons, [26, 27, 28, 29]], materials=names)
    rig = em.Rig(neutral, {"look": neutral.with_vertices(turned)}, method="linear")
    still = {
        table: dict.fromkeys(keys.split(), 0)
        for table, keys in {
            "head": "yaw pitch roll",
            "camera": "azimuth elevation roll x y",
        }.items()
    }
    recipe = {"limits": {"look": [1, 1]}, "mixture": [{"kind": "uniform"}], **still}
    faces = em.make_faces(rig, tmp_path / "f.zarr", 1, recipe=recipe, render=16)
    faces.export(tmp_path / "out", "folder")
    (label,) = (json.loads(file.read_text()) for file in (tmp_path / "out").glob("*.json"))
    # In the camera's axes y is down and z away: who looks into it looks along (0, 0, -1).
    np.testing.assert_allclose(label["gaze"]["right"], [0, 0, -1], atol=1e-3)
    np.testing.assert_allclose(label["gaze"]["left"], [0.5, 0, -np.sqrt(0.75)], atol=1e-3)


def test_what_cannot_be_exported_is_refused_and_leaves_nothing(
    faces: em.FaceSet, tmp_path: Path
) -> None:
    with pytest.raises(em.ParameterError):
        faces.export(tmp_path / "new", "yolo")
    plain = em.make_faces(bare_head(), tmp_path / "plain.zarr", 3)
    with pytest.raises(em.ParameterError):
        plain.export(tmp_path / "new", "coco")
    assert not (tmp_path / "new").exists()
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "mine.txt").write_text("mine")
    with pytest.raises(em.FileError):
        faces.export(tmp_path / "full", "coco")
    assert [file.name for file in (tmp_path / "full").iterdir()] == ["mine.txt"]


def test_points_of_a_rig_that_nobody_knows_are_refused(tmp_path: Path) -> None:
    mesh = em.Mesh(np.eye(3), [[0, 1, 2]])
    rig = em.Rig(mesh, {"a": mesh.with_vertices(np.eye(3) * 2)}, method="linear")
    for points in ("68", "mediapipe", "somewhere"):
        with pytest.raises(em.ParameterError):
            em.make_faces(rig, tmp_path / "f.zarr", 1, landmarks=points)
