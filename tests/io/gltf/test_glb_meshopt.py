"""Views packed by meshoptimizer: what is in them, and what is refused."""

from __future__ import annotations

import base64
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from glb_samples import CORNERS, MOVED, SQUARE, HandMade, square
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from packed_samples import EXT, KHR, meshopt, packed

from elastomorph.errors import FormatError, MissingExtraError
from elastomorph.io.gltf import read_glb
from elastomorph.io.gltf.meshopt import Packing, decoded, encode_attributes, encode_indices


@pytest.mark.parametrize(("name", "version"), [(EXT, 0), (KHR, 0), (KHR, 1)])
@pytest.mark.parametrize("fallback", [True, False])
def test_a_packed_file_is_read_as_the_plain_one(
    tmp_path: Path, name: str, version: int, fallback: bool
) -> None:
    file = packed(square(), name=name, version=version, fallback=fallback)
    rig = read_glb(file.write(tmp_path / "a.glb"))
    np.testing.assert_array_equal(rig.neutral.vertices, SQUARE)
    np.testing.assert_array_equal(rig.morphs["target_0"].delta, MOVED)
    assert sorted(map(sorted, rig.neutral.faces)) == [[0, 1, 2], [0, 2, 3]]


def test_sparse_values_in_packed_views(tmp_path: Path) -> None:
    """The places are a sequence of indices, and the values are rows."""
    file = square(POSITION=2)
    file.accessor(componentType=5126, count=4, type="VEC3")
    made = packed(file)
    moved = encode_attributes(MOVED[1:3].astype("<f4"), 12)
    views = [
        packed_view(made, 8, encode_indices(np.array([1, 2], "<u4"), "INDICES"), 4, "INDICES"),
        packed_view(made, 24, moved, 12, "ATTRIBUTES"),
    ]
    made.document["accessors"][2]["sparse"] = {
        "count": 2,
        "indices": {"bufferView": views[0], "componentType": 5125},
        "values": {"bufferView": views[1]},
    }
    rig = read_glb(made.write(tmp_path / "a.glb"))
    np.testing.assert_array_equal(rig.morphs["target_0"].delta, MOVED)


def packed_view(file: HandMade, length: int, stream: bytes, stride: int, mode: str) -> int:
    """The number of a view of so many bytes that a stream stands for."""
    number = file.view(stream)
    how = {"byteStride": stride, "count": length // stride, "mode": mode}
    own = {"buffer": 1, "byteLength": length}
    place = file.document["bufferViews"][number]
    file.document["bufferViews"][number] = own | {"extensions": {EXT: place | how}}
    return number


def test_packed_views_in_several_buffers_of_a_text_file(tmp_path: Path) -> None:
    """Streams of positions in a data URI, all others in a file beside it; one is for show."""
    file = packed(square())
    first, *others = file.document["bufferViews"]
    place = first["extensions"][EXT]
    end = place["byteOffset"] + place["byteLength"]
    uri = "data:application/octet-stream;base64," + base64.b64encode(file.blob[:end]).decode()
    (tmp_path / "rest.bin").write_bytes(file.blob[end:])
    for view in others:
        view["extensions"][EXT]["buffer"] = 2
        view["extensions"][EXT]["byteOffset"] -= end
    file.document["buffers"] = [
        {"uri": uri, "byteLength": end},
        *file.more_buffers,
        {"uri": "rest.bin", "byteLength": len(file.blob) - end},
    ]
    (tmp_path / "a.gltf").write_text(json.dumps(file.document))
    rig = read_glb(tmp_path / "a.gltf")
    np.testing.assert_array_equal(rig.neutral.vertices, SQUARE)
    np.testing.assert_array_equal(rig.morphs["target_0"].delta, MOVED)


def test_a_strip_of_indices_keeps_its_order(tmp_path: Path) -> None:
    """Four corners are no triangles to pack: they are a sequence, and this one is a strip."""
    file = square()
    file.document["meshes"][0]["primitives"][0] |= {
        "mode": 5,
        "indices": file.array([0, 1, 3, 2], "<u2"),
    }
    rig = read_glb(packed(file).write(tmp_path / "a.glb"))
    assert [list(face) for face in rig.neutral.faces] == [[0, 1, 3], [3, 1, 2]]


def test_rows_that_hold_several_attributes(tmp_path: Path) -> None:
    """Interleaved: positions at byte 0, texture coordinates at byte 12 of rows of 20."""
    file = square()
    rows = np.hstack([SQUARE, [[0, 0], [1, 0], [1, 1], [0, 1]]]).astype("<f4")
    number = file.view(rows.tobytes())
    file.document["accessors"][0]["bufferView"] = number
    where = {"bufferView": number, "componentType": 5126, "count": 4, "byteOffset": 12}
    attributes = file.document["meshes"][0]["primitives"][0]["attributes"]
    attributes["TEXCOORD_0"] = file.accessor(**where, type="VEC2")
    rig = read_glb(packed(file).write(tmp_path / "a.glb"))
    np.testing.assert_array_equal(rig.neutral.vertices, SQUARE)
    assert rig.neutral.uv is not None
    np.testing.assert_array_equal(rig.neutral.uv.coordinates, [[0, 1], [1, 1], [1, 0], [0, 0]])


def stream_of(rows: Any, version: int = 0) -> memoryview:
    return memoryview(meshopt.encode_gltf_buffer(rows, "ATTRIBUTES", version))


def test_exponents() -> None:
    """A whole number of 24 bits times two to the power of the highest 8: 3 · 2⁻¹, −5 · 2², 0."""
    words = np.array([[(0xFF << 24) | 3], [(2 << 24) | (0x1000000 - 5)], [0]], dtype="<u4")
    found = decoded(Packing(3, 4, "ATTRIBUTES", "EXPONENTIAL"), stream_of(words))
    np.testing.assert_array_equal(np.frombuffer(found, "<f4"), [1.5, -20.0, 0.0])


def test_directions_on_an_octahedron() -> None:
    """x and y over the third number, which stands for 1; what is left of the sum is z."""
    rows = np.array([[0, 0, 127, 1], [127, 0, 127, 2], [0, -127, 127, 3]], dtype="i1")
    found = decoded(Packing(3, 4, "ATTRIBUTES", "OCTAHEDRAL"), stream_of(rows))
    np.testing.assert_array_equal(
        np.frombuffer(found, "i1").reshape(-1, 4),
        [[0, 0, 127, 1], [127, 0, 0, 2], [0, -127, 0, 3]],
    )


def test_quaternions_without_their_largest_part() -> None:
    """Three parts over √½ and, in the last two bits, which one is left out: here the last, 1."""
    rows = np.array([[0, 0, 0, (1023 & ~3) | 3]], dtype="<i2")
    found = decoded(Packing(1, 8, "ATTRIBUTES", "QUATERNION"), stream_of(rows))
    np.testing.assert_array_equal(np.frombuffer(found, "<i2"), [0, 0, 0, 32767])


def test_colours_as_luma_and_chroma() -> None:
    """White is all luma: Y = 255, no chroma, and alpha of 7 bits under a leading one."""
    rows = np.array([[255, 0, 0, 255]], dtype="u1")
    found = decoded(Packing(1, 4, "ATTRIBUTES", "COLOR"), stream_of(rows))
    np.testing.assert_array_equal(np.frombuffer(found, "u1"), [255, 255, 255, 255])


@given(st.data())
def test_rows_come_back_as_they_were(data: st.DataObject) -> None:
    stride = 4 * data.draw(st.integers(1, 64))
    count = data.draw(st.integers(1, 40))
    rows = data.draw(arrays(np.uint8, (count, stride)))
    for given_rows in (rows, rows.tobytes()):
        stream = memoryview(encode_attributes(given_rows, stride))
        assert bytes(decoded(Packing(count, stride, "ATTRIBUTES"), stream)) == rows.tobytes()


@given(arrays(np.uint32, st.integers(1, 60), elements=st.integers(0, 2**30 - 1)))
def test_sequences_of_indices_come_back_as_they_were(numbers: Any) -> None:
    packing = Packing(len(numbers), 4, "INDICES")
    found = decoded(packing, memoryview(encode_indices(numbers, "INDICES")))
    np.testing.assert_array_equal(np.frombuffer(found, "<u4"), numbers)


@pytest.mark.parametrize(("rows", "stride"), [(b"", 4), (b"12345", 4), (b"123", 3), (b"1" * 9, 0)])
def test_what_is_no_rows_is_not_packed(rows: bytes, stride: int) -> None:
    with pytest.raises(ValueError, match=r"rows"):
        encode_attributes(rows, stride)


DAMAGED: dict[str, tuple[dict[str, Any], str]] = {
    "mode": ({"mode": "ATTRIBUTE"}, r"its mode is 'ATTRIBUTE'"),
    "no mode": ({"mode": 7}, r"its mode or its filter is no text"),
    "filter": ({"filter": "GZIP"}, r"its filter is 'GZIP' in mode ATTRIBUTES"),
    "filter of indices": ({"mode": "INDICES", "filter": "OCTAHEDRAL"}, r"filter is 'OCTAHEDRAL'"),
    "filter of rows": ({"filter": "QUATERNION"}, r"rows have 12 bytes, not fit for QUATERNION"),
    "stride 0": ({"byteStride": 0}, r"rows have 0 bytes; expected 4 to 256, in fours"),
    "stride 6": ({"byteStride": 6}, r"rows have 6 bytes"),
    "stride 260": ({"byteStride": 260}, r"rows have 260 bytes"),
    "stride of indices": ({"mode": "INDICES"}, r"indices have 12 bytes; expected 2 or 4"),
    "count 0": ({"count": 0}, r"it has 0 rows"),
    "four corners": ({"mode": "TRIANGLES", "byteStride": 4}, r"it has 4 indices"),
    "negative": ({"count": -4}, r"'count' of buffer view 0 is -4"),
    "endless": ({"count": 2**70}, r"rows of 12 bytes are not its byteLength"),
    "more rows": ({"count": 5}, r"5 rows of 12 bytes are not its byteLength"),
    "as indices": ({"mode": "INDICES", "byteStride": 4, "count": 12}, r"its stream is damaged"),
    "as triangles": ({"mode": "TRIANGLES", "byteStride": 4, "count": 12}, r"stream is damaged"),
    "cut off": ({"byteLength": 3}, r"its stream is damaged"),
    "nothing": ({"byteLength": 0}, r"its stream is damaged"),
    "beyond": ({"byteOffset": 10**9}, r"buffer view 0 reaches beyond its buffer"),
    "other buffer": ({"buffer": 1}, r"buffer 1 announces"),
    "no buffer": ({"buffer": 9}, r"names number 9 of 2 buffers"),
}


@pytest.mark.parametrize("case", DAMAGED)
@pytest.mark.parametrize("name", [EXT, KHR])
def test_what_cannot_be_unpacked_is_refused(tmp_path: Path, case: str, name: str) -> None:
    fields, problem = DAMAGED[case]
    file = packed(square(), name=name)
    file.document["bufferViews"][0]["extensions"][name] |= fields
    with pytest.raises(FormatError, match=problem):
        read_glb(file.write(tmp_path / "a.glb"))


def test_few_bytes_that_unpack_to_many_are_refused(tmp_path: Path) -> None:
    """Zeros pack a thousand to one; what they would take is counted before they are unpacked."""
    count = 20_000_000
    file = HandMade()
    stream = meshopt.encode_gltf_buffer(np.zeros((count, 4), np.uint8), "ATTRIBUTES", 1)
    number = file.view(stream)
    place = file.document["bufferViews"].pop(number)
    how = {"byteStride": 4, "count": count, "mode": "ATTRIBUTES"}
    file.document["bufferViews"] = [
        {"buffer": 1, "byteLength": 4 * count, "extensions": {KHR: place | how}}
    ]
    file.more_buffers = [{"byteLength": 4 * count}]
    positions = file.accessor(bufferView=0, componentType=5120, count=count, type="VEC3")
    file.primitive(attributes={"POSITION": positions}, mode=0)
    with pytest.raises(FormatError, match="would take more memory than"):
        read_glb(file.write(tmp_path / "a.glb"))


def test_a_plain_view_of_the_buffer_that_is_not_there(tmp_path: Path) -> None:
    file = packed(square())
    del file.document["bufferViews"][0]["extensions"]
    with pytest.raises(FormatError, match="buffer 1 announces"):
        read_glb(file.write(tmp_path / "a.glb"))


def test_the_missing_package_says_how_to_install_itself(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = packed(square()).write(tmp_path / "a.glb")
    monkeypatch.setitem(sys.modules, "meshopt", None)
    with pytest.raises(MissingExtraError, match=r"pip install 'elastomorph\[gltf\]'"):
        read_glb(path)


MUTATED = """
import sys
import meshopt, numpy as np
from elastomorph.io.gltf.meshopt import Packing, decoded
rng = np.random.default_rng(11)
kinds = []
for stride in (4, 8, 12, 64):
    for count in (1, 5, 300):
        rows = np.cumsum(rng.integers(-3, 4, (count, stride)), axis=0).astype(np.uint8)
        for version in (0, 1):
            stream = meshopt.encode_gltf_buffer(rows, "ATTRIBUTES", version)
            kinds.append((stream, count, stride, "ATTRIBUTES"))
corners = (np.arange(300)[:, None] + [0, 1, 2]).astype(np.uint32).reshape(-1)
for mode in ("TRIANGLES", "INDICES"):
    kinds.append((meshopt.encode_gltf_buffer(corners, mode), 900, 4, mode))
refused = read = 0
for _ in range(6000):
    stream, count, stride, mode = kinds[rng.integers(len(kinds))]
    bad = bytearray(stream)
    for _ in range(rng.integers(1, 6)):
        match rng.integers(4):
            case 0: bad[rng.integers(len(bad))] = rng.integers(256)
            case 1: bad = bad[: rng.integers(1, len(bad) + 1)]
            case 2: bad += rng.integers(0, 256, rng.integers(1, 20), dtype=np.uint8).tobytes()
            case 3: bad[rng.integers(min(4, len(bad)))] = rng.integers(256)
    if rng.random() < 0.3:
        count = 3 * int(rng.integers(1, 2000))
    try:
        read += len(decoded(Packing(count, stride, mode), memoryview(bad))) == count * stride
    except ValueError:
        refused += 1
print(read, refused)
"""


def test_changed_streams_are_read_or_refused() -> None:
    """Some changes only change numbers; none ends or stops the program."""
    done = subprocess.run(
        [sys.executable, "-c", MUTATED], capture_output=True, text=True, timeout=60, check=False
    )
    assert done.returncode == 0, done.stderr[-500:]
    read, refused = map(int, done.stdout.split())
    assert read + refused == 6000
    assert read > 10
    assert refused > 1000


def test_corners_of_a_square_pack_to_triangles() -> None:
    corners = np.array(CORNERS, dtype=np.uint16)
    stream = memoryview(encode_indices(corners, "TRIANGLES"))
    found = np.frombuffer(decoded(Packing(6, 2, "TRIANGLES"), stream), "<u2").reshape(-1, 3)
    assert sorted(map(sorted, found.tolist())) == [[0, 1, 2], [0, 2, 3]]
