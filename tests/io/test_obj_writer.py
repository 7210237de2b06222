"""OBJ text is written so that reading it gives the same mesh, and refuses what it cannot hold."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mesh_samples import house, labels_of

from elastomorph.errors import FormatError
from elastomorph.io.obj import read_obj, write_obj
from elastomorph.model.mesh import Mesh, UVMap

TRIANGLE = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]


def test_the_text_is_what_one_would_write_by_hand(tmp_path: Path) -> None:
    write_obj(tmp_path / "house.obj", house())
    assert (tmp_path / "house.obj").read_bytes().decode() == (
        "mtllib house.mtl\n"
        "v 0.0 0.0 0.0\nv 1.0 0.0 0.1\nv 1.0 1.0 -0.0\nv 0.0 1.0 1e-300\n"
        "v 0.5 1.5 0.3333333333333333\n"
        "vt 0.0 0.0\nvt 1.0 0.0\nvt 1.0 1.0\nvt 0.1 0.7\n"
        "usemtl wall\nf 1/1 2/2 3/3 4/4\n"
        "g upper part\nusemtl roof\nf 4/4 3/3 5\n"
    )


def test_a_polygon_without_label_after_one_with_a_label_stays_without(tmp_path: Path) -> None:
    mesh = Mesh(TRIANGLE, [[0, 1, 2]] * 3, groups=labels_of(["a", None, "a"]))
    write_obj(tmp_path / "a.obj", mesh)
    again = read_obj(tmp_path / "a.obj")
    assert again.groups is not None
    assert again.groups.of_face.tolist() == [0, -1, 0]


@pytest.mark.parametrize(
    "name", ["", " ", "a ", " a", "a\nb", "a\rb", "#", "a # b", "a\\", "a\0b", "\ud800"]
)
def test_a_name_that_would_not_be_read_back_is_refused(tmp_path: Path, name: str) -> None:
    mesh = Mesh(TRIANGLE, [[0, 1, 2]], materials=labels_of([name]))
    with pytest.raises(FormatError, match=r"a\.obj: the name .* cannot be written as 'usemtl'"):
        write_obj(tmp_path / "a.obj", mesh)
    assert list(tmp_path.iterdir()) == []


@given(name=st.text(max_size=6))
@settings(max_examples=200, deadline=None)
def test_any_name_is_read_back_or_refused(
    tmp_path_factory: pytest.TempPathFactory, name: str
) -> None:
    path = tmp_path_factory.getbasetemp() / "name.obj"
    mesh = Mesh(TRIANGLE, [[0, 1, 2]], groups=labels_of([name]), material_library=name)
    try:
        write_obj(path, mesh)
    except FormatError:
        return
    again = read_obj(path)
    assert again.groups is not None
    assert again.groups.names == (name,)
    assert again.material_library == name


def test_a_name_that_no_polygon_uses_is_not_written(tmp_path: Path) -> None:
    labels = labels_of(["a"])
    assert labels is not None
    unused = type(labels)(("a", "not\nwritable"), labels.of_face)
    write_obj(tmp_path / "a.obj", Mesh(TRIANGLE, [[0, 1, 2]], groups=unused))
    assert b"writable" not in (tmp_path / "a.obj").read_bytes()


def test_texture_coordinates_that_are_not_finite_are_refused(tmp_path: Path) -> None:
    uv = UVMap(np.array([[0.0, np.nan]]), np.zeros(3, dtype=np.int32))
    with pytest.raises(FormatError, match="not finite"):
        write_obj(tmp_path / "a.obj", Mesh(TRIANGLE, [[0, 1, 2]], uv=uv))
    assert list(tmp_path.iterdir()) == []
