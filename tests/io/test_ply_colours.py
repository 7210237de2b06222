"""Colours of vertices, in every encoding that scanners use."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest

import elastomorph as em
from elastomorph.io.ply import read_ply_colours

COLOURS = np.array([[255, 0, 10], [1, 2, 3], [128, 127, 126]])
HEADER = """ply
format {encoding} 1.0
element vertex 3
property float x
property float y
property float z
{properties}
element face 1
property list uchar int vertex_indices
end_header
"""
KINDS = {"uchar": "B", "ushort": "H", "float": "f", "double": "d"}


def written(path: Path, encoding: str, kind: str, names: str = "red green blue alpha") -> Path:
    properties = "\n".join(f"property {kind} {name}" for name in names.split())
    head = HEADER.format(encoding=encoding, properties=properties).encode()
    scale = 255 if kind in ("float", "double") else 1
    rows = [[*np.eye(3)[i], *(COLOURS[i] / scale), 1 if scale > 1 else 255] for i in range(3)]
    width = 3 + len(names.split())
    if encoding == "ascii":
        lines = [" ".join(f"{v:.9g}" for v in row[:width]) for row in rows]
        path.write_bytes(head + "\n".join([*lines, "3 0 1 2\n"]).encode())
        return path
    order = "<" if "little" in encoding else ">"
    content = b""
    for row in rows:
        own = row[3:width] if scale > 1 else [round(value) for value in row[3:width]]
        content += struct.pack(f"{order}3f{width - 3}{KINDS[kind]}", *row[:3], *own)
    path.write_bytes(head + content + struct.pack(f"{order}B3i", 3, 0, 1, 2))
    return path


@pytest.mark.parametrize("encoding", ["ascii", "binary_little_endian", "binary_big_endian"])
@pytest.mark.parametrize("kind", KINDS)
def test_colours_of_the_vertices(tmp_path: Path, encoding: str, kind: str) -> None:
    file = written(tmp_path / "scan.ply", encoding, kind)
    found = read_ply_colours(file)
    assert found is not None
    assert found.dtype == np.uint8
    np.testing.assert_array_equal(found, COLOURS)
    np.testing.assert_array_equal(em.read(file).vertices, np.eye(3))


def test_a_file_without_them_has_none(tmp_path: Path) -> None:
    em.write(tmp_path / "plain.ply", em.Mesh(np.eye(3), [[0, 1, 2]]))
    assert read_ply_colours(tmp_path / "plain.ply") is None
    assert read_ply_colours(written(tmp_path / "two.ply", "ascii", "uchar", "red green")) is None


def test_damage_is_told(tmp_path: Path) -> None:
    whole = written(tmp_path / "scan.ply", "binary_little_endian", "uchar").read_bytes()
    for size in range(0, len(whole), 7):
        (tmp_path / "cut.ply").write_bytes(whole[:size])
        with pytest.raises(em.FormatError, match=r"cut\.ply"):
            read_ply_colours(tmp_path / "cut.ply")
