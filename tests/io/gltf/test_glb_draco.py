"""Primitives packed with Draco: what is in them, and what is refused."""

from __future__ import annotations

import struct
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from draco_samples import NAME, corners_in, draco_square, numbers_in, packed_square
from glb_samples import CORNERS, MOVED, SQUARE, HandMade, square

from effort import worked
from elastomorph.errors import FormatError, MissingExtraError
from elastomorph.io.gltf import accessors, read_glb
from elastomorph.io.gltf.container import open_gltf


@pytest.mark.parametrize("level", [0, 1, 7, 10])
@pytest.mark.parametrize("preserve_order", [False, True])
def test_vertices_come_in_the_order_that_targets_index(
    tmp_path: Path, level: int, preserve_order: bool
) -> None:
    file = draco_square(compression_level=level, preserve_order=preserve_order)
    rig = read_glb(file.write(tmp_path / "a.glb"))
    places = corners_in(packed_square(compression_level=level, preserve_order=preserve_order))
    order = [places[x, y] for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]
    step = 1 / (2**14 - 1)
    np.testing.assert_allclose(rig.neutral.vertices[order], SQUARE, atol=step)
    np.testing.assert_array_equal(rig.morphs["target_0"].delta[order], MOVED)
    assert rig.neutral.uv is not None
    np.testing.assert_allclose(
        rig.neutral.uv.coordinates[order], SQUARE[:, :2] * [1, -1] + [0, 1], atol=step
    )
    faces = sorted(sorted(order.index(corner) for corner in face) for face in rig.neutral.faces)
    assert faces == [[0, 1, 2], [0, 2, 3]]


def test_two_primitives_of_one_stream_and_one_that_is_plain(tmp_path: Path) -> None:
    file = draco_square()
    first = file.document["meshes"][0]["primitives"][0]
    file.primitive(**first | {"material": 0})
    file.document["materials"] = [{"name": "other"}]
    plain = {"attributes": {"POSITION": file.array(SQUARE + 5)}}
    file.primitive(**plain, indices=file.array(CORNERS, "<u2"))
    rig = read_glb(file.write(tmp_path / "a.glb"))
    assert len(rig.neutral.vertices) == 8  # the first two share theirs
    assert len(rig.neutral.faces) == 6
    np.testing.assert_array_equal(rig.neutral.vertices[4:], SQUARE + 5)


def test_a_plain_copy_is_read_where_there_is_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = square()
    own = {"bufferView": 0, "attributes": {"POSITION": 0}}
    file.document["meshes"][0]["primitives"][0]["extensions"] = {NAME: own}
    monkeypatch.setattr(accessors, "find_spec", lambda name: None)
    rig = read_glb(file.write(tmp_path / "a.glb"))
    np.testing.assert_array_equal(rig.neutral.vertices, SQUARE)


def test_joints_and_weights_of_several_types(tmp_path: Path) -> None:
    """Whole numbers of one byte and floats, by the numbers that the extension gives."""
    import DracoPy

    joints = np.array([[1, 2, 3, 255]] * 4, dtype=np.uint8)
    weights = np.array([[0.25, 0.25, 0.5, 0]] * 4, dtype=np.float32)
    corners = np.array(CORNERS).reshape(-1, 3)
    stream = DracoPy.encode(SQUARE, corners, generic_attributes={7: joints, 9: weights})
    position = numbers_in(stream)["POSITION"]
    file = draco_square()
    own = file.document["meshes"][0]["primitives"][0]
    own["attributes"] = {
        "POSITION": own["attributes"]["POSITION"],
        "JOINTS_0": file.accessor(componentType=5121, count=4, type="VEC4"),
        "WEIGHTS_0": file.accessor(componentType=5126, count=4, type="VEC4"),
    }
    own["extensions"][NAME] = {
        "bufferView": file.view(stream),
        "attributes": {"POSITION": position, "JOINTS_0": 7, "WEIGHTS_0": 9},
    }
    opened = open_gltf(file.write(tmp_path / "a.glb"))
    for name, expected in (("JOINTS_0", joints), ("WEIGHTS_0", weights)):
        found = accessors.draco_values(opened, own["attributes"][name])
        assert found is not None
        assert found.dtype == expected.dtype
        np.testing.assert_array_equal(found, expected)


def extension(file: HandMade) -> dict[str, Any]:
    found: dict[str, Any] = file.document["meshes"][0]["primitives"][0]["extensions"][NAME]
    return found


def accessor(file: HandMade, number: int) -> dict[str, Any]:
    found: dict[str, Any] = file.document["accessors"][number]
    return found


def without_indices(file: HandMade) -> None:
    del file.document["meshes"][0]["primitives"][0]["indices"]


def swapped(file: HandMade) -> None:
    numbers = extension(file)["attributes"]
    numbers["POSITION"] = numbers["TEXCOORD_0"]


def halves_as_bytes(file: HandMade) -> None:
    import DracoPy

    stream = DracoPy.encode(SQUARE / 2, np.array(CORNERS).reshape(-1, 3))
    extension(file)["bufferView"] = file.view(stream)
    extension(file)["attributes"] = {"POSITION": numbers_in(stream)["POSITION"]}
    accessor(file, 0)["componentType"] = 5121


def of_points(file: HandMade) -> None:
    import DracoPy

    extension(file)["bufferView"] = file.view(DracoPy.encode(SQUARE))


DAMAGED = {
    "no view": (lambda f: extension(f).pop("bufferView"), r"names number null of"),
    "view beyond": (lambda f: extension(f).update(bufferView=99), r"names number 99 of"),
    "view as text": (lambda f: extension(f).update(bufferView="0"), r"names number \"0\" of"),
    "another view": (lambda f: extension(f).update(bufferView=1), r"view 1.* is damaged"),
    "attributes": (lambda f: extension(f).update(attributes=[]), r"'attributes' of .* no object"),
    "unknown number": (lambda f: extension(f)["attributes"].update(POSITION=5), r"attribute 5"),
    "no number": (lambda f: extension(f)["attributes"].update(POSITION="a"), r"'POSITION' of"),
    "more vertices": (lambda f: accessor(f, 0).update(count=5), r"has 5 elements of 3 .* 4 of 3"),
    "other width": (swapped, r"packs 4 of 2"),
    "whole numbers": (halves_as_bytes, r"for accessor 0 does not fit"),
    "more corners": (lambda f: accessor(f, 2).update(count=9), r"has 9 elements of 1 .* 6 of 1"),
    "no corners": (without_indices, r"has no indices"),
    "points": (of_points, r"holds no triangles"),
}


@pytest.mark.parametrize("case", DAMAGED)
def test_what_cannot_be_unpacked_is_refused(tmp_path: Path, case: str) -> None:
    change, problem = DAMAGED[case]
    file = draco_square()
    change(file)
    with pytest.raises(FormatError, match=problem) as caught:
        read_glb(file.write(tmp_path / "a.glb"))
    assert str(caught.value).startswith(f"{tmp_path / 'a.glb'}: ")
    assert "streams.npz" not in str(caught.value)


def test_streams_cut_off_anywhere_are_refused(tmp_path: Path) -> None:
    """All at once, as each file starts a process: the shortest that is read is the whole one."""
    from elastomorph.io.gltf.draco_worker import content_of
    from elastomorph.io.isolated import RefusedError
    from elastomorph.io.npz.members import write_arrays

    whole = np.frombuffer(packed_square(), "u1")
    read = []
    for length in range(len(whole) + 1):
        write_arrays(tmp_path / "streams.npz", {"0": whole[:length]})
        with suppress(RefusedError):
            content_of(str(tmp_path / "streams.npz"))
            read.append(length)
    assert read[-1] == len(whole)
    assert len(read) < 8


def test_a_stream_that_announces_billions_of_points_is_stopped(tmp_path: Path) -> None:
    """Draco believes their number, in 4 bytes from byte 11, and takes minutes and gigabytes."""
    import DracoPy

    before = worked()
    cloud = bytearray(DracoPy.encode(SQUARE))
    assert cloud[11:15] == struct.pack("<I", len(SQUARE))
    cloud[11:15] = struct.pack("<I", 1_600_000_000)
    file = draco_square()
    extension(file)["bufferView"] = file.view(bytes(cloud))
    with pytest.raises(FormatError, match=r"it needs more memory|Draco broke while reading it"):
        read_glb(file.write(tmp_path / "a.glb"))
    assert worked() - before < 30


def test_changed_streams_are_read_or_refused(tmp_path: Path) -> None:
    rng = np.random.default_rng(5)
    whole = packed_square(compression_level=7)
    for _ in range(8):
        bad = bytearray(whole)
        for place in rng.integers(0, len(bad), 3):
            bad[place] = rng.integers(256)
        file = draco_square()
        extension(file)["bufferView"] = file.view(bytes(bad))
        path = file.write(tmp_path / "a.glb")
        with suppress(FormatError):
            assert len(read_glb(path).neutral.vertices) == 4


def test_the_missing_package_says_how_to_install_itself(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = draco_square().write(tmp_path / "a.glb")
    monkeypatch.setattr(accessors, "find_spec", lambda name: None)
    with pytest.raises(MissingExtraError, match=r"pip install 'elastomorph\[gltf\]'"):
        read_glb(path)
