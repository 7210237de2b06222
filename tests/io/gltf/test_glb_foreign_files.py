"""Files that others write, file by file: where their bytes are, and what is refused in them."""

from __future__ import annotations

import base64
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from glb_samples import CORNERS, SQUARE, HandMade, glb, square

from elastomorph.errors import FileError, FormatError
from elastomorph.io.gltf import read_glb


def in_two_files(folder: Path, uri: str, content: bytes | None = None) -> Path:
    file = square()
    file.document["buffers"] = [{"byteLength": len(file.blob), "uri": uri}]
    if content is None:
        content = file.blob
    (folder / "sub folder").mkdir(exist_ok=True)
    (folder / "sub folder" / "ä b.bin").write_bytes(content)
    path = folder / "face.gltf"
    path.write_text(json.dumps(file.document))
    return path


def test_a_file_beside_it_with_percent_signs_in_its_name(tmp_path: Path) -> None:
    for uri in ("sub%20folder/%C3%A4%20b.bin", "sub folder/ä b.bin", "./sub%20folder/ä%20b.bin"):
        rig = read_glb(in_two_files(tmp_path, uri))
        np.testing.assert_array_equal(rig.neutral.vertices, SQUARE)


def test_a_data_uri(tmp_path: Path) -> None:
    text = base64.b64encode(square().blob).decode()
    for head in ("data:application/octet-stream;base64,", "data:application/gltf-buffer;base64,"):
        rig = read_glb(in_two_files(tmp_path, head + text))
        np.testing.assert_array_equal(rig.neutral.vertices, SQUARE)
    for uri in ("data:text/plain,AAAA", "data:;base64,?!", "data:;base64," + text[:40]):
        with pytest.raises(FormatError, match=r"data URI|announces"):
            read_glb(in_two_files(tmp_path, uri))


@pytest.mark.parametrize(
    "uri",
    [
        "../secret.bin",
        "sub/../../secret.bin",
        "%2e%2e/secret.bin",
        "..%2Fsecret.bin",
        "..\\secret.bin",
        "/etc/passwd",
        "%2Fetc%2Fpasswd",
        "\\\\host\\share",
        "C:\\secret.bin",
        "file:///etc/passwd",
        "http://example.com/a.bin",
        "HTTPS://example.com/a.bin",
        "a%00.bin",
        "way-out/secret.bin",
    ],
)
def test_names_that_lead_out_of_the_folder_are_refused(tmp_path: Path, uri: str) -> None:
    folder = tmp_path / "inside"
    folder.mkdir()
    (tmp_path / "secret.bin").write_bytes(square().blob)
    (folder / "way-out").symlink_to(tmp_path, target_is_directory=True)
    with pytest.raises(FormatError, match=r"own folder"):
        read_glb(in_two_files(folder, uri))


def test_a_missing_or_short_file_beside_it(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="no such file"):
        read_glb(in_two_files(tmp_path, "gone.bin"))
    with pytest.raises(FormatError, match="announces"):
        read_glb(in_two_files(tmp_path, "sub%20folder/%C3%A4%20b.bin", b"short"))


def test_unknown_required_extensions_are_refused_and_harmless_ones_are_not(tmp_path: Path) -> None:
    file = square()
    file.document["extensionsRequired"] = [
        *("KHR_materials_unlit", "KHR_texture_transform", "KHR_texture_basisu", "EXT_texture_webp"),
        *("EXT_lights_image_based", "KHR_audio_emitter", "KHR_mesh_quantization", "VRMC_vrm"),
    ]
    read_glb(file.write(tmp_path / "a.glb"))
    file.document["extensionsRequired"] = ["VENDOR_secret_shapes"]
    with pytest.raises(FormatError, match=r"VENDOR_secret_shapes.* may say where vertices"):
        read_glb(file.write(tmp_path / "a.glb"))


def broken(change: Any) -> HandMade:
    file = square()
    change(file.document)
    return file


def zeros(count: int) -> dict[str, Any]:
    """Changes an accessor to one without bytes."""
    return {"bufferView": None, "count": count}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda d: d["accessors"][0].update(count=10**12), "do not fit"),
        (lambda d: d["accessors"][0].update(count=5), "do not fit"),
        (lambda d: d["accessors"][0].update(count=0), "0 elements"),
        (lambda d: d["accessors"][0].update(count=-1), "whole number"),
        (lambda d: d["accessors"][0].update(count=True), "whole number"),
        (lambda d: d["accessors"][0].update(count="4"), "whole number"),
        (lambda d: d["accessors"][0].update(count=10**50), "whole number|do not fit"),
        (lambda d: d["accessors"][0].update(byteOffset=4), "do not fit"),
        (lambda d: d["accessors"][0].update(bufferView=99), "99"),
        (lambda d: d["accessors"][0].update(componentType=5124), "type"),
        (lambda d: d["accessors"][0].update(componentType=[]), "type"),
        (lambda d: d["accessors"][0].update(type="MAT4"), "type"),
        (lambda d: d["accessors"][0].update(normalized=True), "normalised floats"),
        (lambda d: d["accessors"][0].update(zeros(10**12)), "more memory"),
        (lambda d: d["accessors"][2].update(count=3), "expected 4"),
        (lambda d: d["bufferViews"][0].update(byteLength=10**12), "beyond its buffer"),
        (lambda d: d["bufferViews"][0].update(byteOffset=10**12), "beyond its buffer"),
        (lambda d: d["bufferViews"][0].update(byteStride=4), "do not fit"),
        (lambda d: d["bufferViews"][0].update(byteStride=8), "do not fit"),
        (lambda d: d["bufferViews"][0].update(byteStride=10**9), "do not fit"),
        (lambda d: d["bufferViews"][0].update(buffer=1), "buffers"),
        (lambda d: d["bufferViews"].__setitem__(0, 3), "no object"),
        (lambda d: d.update(accessors={}), "no list"),
        (lambda d: d.update(asset={"version": "1.0"}), "only glTF 2.0"),
        (lambda d: d.update(asset=[]), "no object"),
        (lambda d: d["meshes"][0].update(primitives=[]), "no triangles"),
        (lambda d: d["meshes"][0]["primitives"][0].update(attributes={}), "no positions"),
        (lambda d: d["meshes"][0]["primitives"][0].update(indices=0), "type"),
        (lambda d: d["meshes"][0]["primitives"][0].update(material=0), "materials"),
        (lambda d: d["nodes"][0].update(mesh=7), "7 of 1 meshes"),
        (lambda d: d["nodes"][0].update(children=[0]), "twice"),
        (lambda d: d["nodes"][0].update(matrix=[1, 2]), "16 finite numbers"),
        (lambda d: d["nodes"][0].update(scale=[1, 2, "x"]), "3 finite numbers"),
        (lambda d: d["nodes"][0].update(scale=[1, 2, 10**400]), "3 finite numbers"),
        (lambda d: d["nodes"][0].update(scale=[1.7e308] * 3, translation=[1.7e308] * 3), "finite"),
        (lambda d: d["scenes"][0].update(nodes=[5]), "5 of 1 nodes"),
        (lambda d: d.update(scene=3), "3 of 1 scenes"),
    ],
)
def test_what_is_out_of_range_is_refused(tmp_path: Path, change: Any, message: str) -> None:
    path = tmp_path / "a.glb"
    file = broken(change)
    with pytest.raises(FormatError, match=message) as caught:
        read_glb(file.write(path))
    assert str(path) in str(caught.value)


def test_an_index_beyond_the_vertices_is_refused(tmp_path: Path) -> None:
    file = HandMade()
    file.primitive(
        attributes={"POSITION": file.array(SQUARE)}, indices=file.array([0, 1, 4], "<u4")
    )
    with pytest.raises(FormatError, match="vertex 4 of 4"):
        read_glb(file.write(tmp_path / "a.glb"))


@pytest.mark.parametrize("places", [[1, 4], [3, 1], [2, 2]])
def test_sparse_places_out_of_range_or_order_are_refused(tmp_path: Path, places: Any) -> None:
    file = HandMade()
    target = file.accessor(
        componentType=5126,
        count=4,
        type="VEC3",
        sparse={
            "count": 2,
            "indices": {"bufferView": file.view(bytes(places)), "componentType": 5121},
            "values": {"bufferView": file.view(bytes(24))},
        },
    )
    file.primitive(
        attributes={"POSITION": file.array(SQUARE)},
        indices=file.array(CORNERS, "u1"),
        targets=[{"POSITION": target}],
    )
    with pytest.raises(FormatError, match="out of range or out of order"):
        read_glb(file.write(tmp_path / "a.glb"))


def test_positions_that_are_no_numbers_are_refused(tmp_path: Path) -> None:
    file = HandMade()
    nan = SQUARE.copy()
    nan[2, 1] = np.nan
    file.primitive(attributes={"POSITION": file.array(nan)}, indices=file.array(CORNERS, "u1"))
    with pytest.raises(FormatError, match="vertex 2"):
        read_glb(file.write(tmp_path / "a.glb"))


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"glTF",
        b"glTF" + bytes(16),
        b"{}",
        b"[1]",
        b"text",
        b"\xff\xfe",
        b"[" * 100_000,
        b'{"asset": {"version": NaN}}',
        b'{"a": ' + b"9" * 5000 + b"}",
        glb({"asset": {"version": "2.0"}}),
    ],
)
def test_what_is_no_gltf_is_refused(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "a.glb").write_bytes(content)
    with pytest.raises(FormatError, match=r"a\.glb"):
        read_glb(tmp_path / "a.glb")
