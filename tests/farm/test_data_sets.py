"""Data sets made, gone on with and read: what is stored is what the rig gives."""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import dask.array
import numpy as np
import pytest
import zarr

import elastomorph as em
from elastomorph.errors import FormatError, ParameterError
from elastomorph.farm.pictures.painter import Painter
from elastomorph.farm.storage.layout import packed, unpacked
from elastomorph.io.performance import write_performance_csv
from elastomorph.model.mesh import Material, Texture
from elastomorph.rig.build import extent_of
from elastomorph.rig.performance import Performance

FACES = 300
ONE = {"mixture": [{"kind": "sparse", "active": 0.5}]}


@pytest.fixture(scope="module")
def folder(rig: em.Rig, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A data set of all that is stored."""
    folder = tmp_path_factory.mktemp("farm") / "faces.zarr"
    em.make_faces(
        rig, folder, FACES, seed=3, vertices="int16", normals=True, landmarks={"nose": 4, "chin": 9}
    )
    return folder


def test_faces_are_those_of_the_rig(rig: em.Rig, tmp_path: Path) -> None:
    faces = em.make_faces(rig, tmp_path / "faces.zarr", FACES, seed=3)
    assert faces.shape == (FACES, 90, 3)
    assert len(faces) == FACES
    assert (faces.codes[:] == em.FaceSampler(rig, seed=3).codes(0, FACES)).all()
    assert np.allclose(faces[:], rig.batch(faces.weights[:]), atol=1e-6)
    assert faces[10:20].shape == (10, 90, 3)
    assert faces.rig.names == rig.names


def test_a_face_has_the_same_bits_in_any_company(rig: em.Rig, tmp_path: Path) -> None:
    faces = em.make_faces(rig, tmp_path / "faces.zarr", FACES)
    whole = faces[:]
    rows = np.random.default_rng(0).permutation(FACES)[:100]
    assert (faces[rows] == whole[rows]).all()
    assert (faces[77:231:7] == whole[77:231:7]).all()
    assert (faces[-1] == whole[-1]).all()
    assert (faces[5, :, 1] == whole[5, :, 1]).all()
    assert (faces[..., 2] == whole[..., 2]).all()
    assert (faces[::-1] == whole[::-1]).all()
    assert (faces[whole[:, 0, 0] > 2] == whole[whole[:, 0, 0] > 2]).all()
    for wrong in (FACES, -FACES - 1, [0, FACES]):
        with pytest.raises(IndexError):
            faces[wrong]


def test_plain_zarr_and_dask_read_what_is_stored(rig: em.Rig, folder: Path) -> None:
    """With the attributes of the arrays and nothing of ours."""
    group = zarr.open_group(folder, mode="r")
    codes, vertices = group["weights"], group["vertices"]
    low, high = np.transpose(codes.attrs["ranges"])
    weights = low + codes[:] * (high - low) / 65535
    positions = group["neutral"][:] + vertices.attrs["scale"] * vertices[:]
    exact = rig.batch(weights[:, : len(rig.names)], dtype=np.float64)
    error = vertices.attrs["largest_error_of_D"]
    assert 0.2 * error < np.abs(positions - exact).max() / extent_of(rig) <= error <= 1.01e-4
    lazy = dask.array.from_zarr(str(folder / "vertices"))
    assert (lazy[250:].compute() == vertices[250:]).all()
    assert np.allclose(em.open_faces(folder)[:], positions, atol=1e-6)
    assert group["landmarks"].attrs["names"] == ["nose", "chin"]
    assert np.allclose(group["landmarks"][:], exact[:, [4, 9]], atol=1e-6)


def test_normals_are_at_right_angles_to_the_surface(rig: em.Rig, folder: Path) -> None:
    """On a sheet without depth they are known."""
    normals = em.open_faces(folder).labels["normals"][:]
    assert np.allclose(np.linalg.norm(normals, axis=2), 1, atol=1e-6)
    flat = em.Mesh(rig.neutral.vertices * [1, 1, 0], rig.neutral.faces)
    still = em.Rig(flat, {"none": em.interpolate(flat, flat, "linear")})
    faces = em.make_faces(still, folder.parent / "flat.zarr", 2, recipe=ONE, normals=True)
    assert (faces.labels["normals"][:] == [0, 0, 1]).all()


def test_the_same_call_makes_nothing_twice(
    rig: em.Rig, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = {file: file.stat().st_mtime_ns for file in folder.rglob("c.*")}
    em.make_faces(
        rig, folder, FACES, seed=3, vertices="int16", normals=True, landmarks={"nose": 4, "chin": 9}
    )
    assert {file: file.stat().st_mtime_ns for file in folder.rglob("c.*")} == before


def test_what_was_begun_for_something_else_is_refused(rig: em.Rig, tmp_path: Path) -> None:
    place = tmp_path / "faces.zarr"
    em.make_faces(rig, place, 10)
    there = sorted(place.rglob("*"))
    other = rig.only(rig.names[:7])
    for own, options, said in [
        (other, {}, "another rig"),
        (rig, {"seed": 1}, "another recipe or seed"),
        (rig, {"normals": True}, "other contents"),
        (rig, {"unit": 64}, "units of 65,536 faces"),
    ]:
        with pytest.raises(FormatError, match=said):
            em.make_faces(own, place, 10, **options)
    assert sorted(place.rglob("*")) == there


def test_an_unknown_format_is_refused(rig: em.Rig, tmp_path: Path) -> None:
    place = tmp_path / "faces.zarr"
    em.make_faces(rig, place, 10)
    root = json.loads((place / "zarr.json").read_text())
    root["attributes"]["elastomorph"]["format"] = 7
    (place / "zarr.json").write_text(json.dumps(root))
    with pytest.raises(FormatError, match="format 7, expected 2; update"):
        em.open_faces(place)


def test_pictures_are_drawn_of_the_faces_that_are_stored(rig: em.Rig, tmp_path: Path) -> None:
    """From the rig that is kept with the data."""
    faces = em.make_faces(rig, tmp_path / "faces.zarr", 6, render=16, landmarks={"nose": 44})
    painter = Painter(faces.rig, (16, 16), {"nose": 44})
    drawn = painter.draw(faces[:], dict(zip(faces.columns.names, faces.values[:].T, strict=True)))
    assert set(drawn) == {n.split("/")[1] for n in faces.labels if n.startswith("images/")}
    for name, values in drawn.items():
        assert (faces.labels[f"images/{name}"][:] == values).all(), name
    assert (drawn["colour"].std(axis=(1, 2)) > 1).all()


def test_the_look_of_a_rig_is_kept_with_it(rig: em.Rig) -> None:
    image = Texture(b"a picture", "skin.png", wrap=("clamp", "repeat"), scale=(2.0, 1.0))
    looks = {"skin": Material((0.5, 0.4, 0.3, 1.0), image, unlit=True), "plain": Material()}
    mesh = em.Mesh(rig.neutral.vertices, rig.neutral.faces, appearance=looks)
    other = unpacked(packed(em.Rig(mesh, {"a": em.interpolate(mesh, mesh, "linear")})))
    assert other.neutral.appearance is not None
    assert {n: asdict(m) for n, m in other.neutral.appearance.items()} == {
        n: asdict(m) for n, m in looks.items()
    }


def test_other_takes_than_begun_with_are_refused(rig: em.Rig, tmp_path: Path) -> None:
    """The recipe still names the same file."""
    take = Performance(("jawOpen", "cheekPuff"), np.arange(4) / 30, np.eye(4)[:, :2], 30.0)
    write_performance_csv(tmp_path / "take.csv", take)
    recipe = tmp_path / "recipe.toml"
    recipe.write_text('[[mixture]]\nkind = "take"\nfiles = ["take.csv"]\n')
    em.make_faces(rig, tmp_path / "faces.zarr", 9, recipe=recipe)
    write_performance_csv(tmp_path / "take.csv", replace(take, weights=take.weights / 2))
    with pytest.raises(FormatError, match="begun with other takes"):
        em.make_faces(rig, tmp_path / "faces.zarr", 12, recipe=recipe)


def test_more_faces_than_a_recipe_has_are_refused_before_anything_is_written(
    rig: em.Rig, tmp_path: Path
) -> None:
    grid = {"mixture": [{"kind": "grid", "levels": 3, "sliders": ["jawOpen", "cheekPuff"]}]}
    with pytest.raises(ParameterError, match="and 99 were asked for: leave the number out"):
        em.make_faces(rig, tmp_path / "faces.zarr", 99, recipe=grid)
    assert not (tmp_path / "faces.zarr").exists()
    faces = em.make_faces(rig, tmp_path / "faces.zarr", recipe=grid)
    assert len(faces) == em.FaceSampler(rig, grid).count


@pytest.mark.parametrize("dtype", ["float32", "float16", "int16"])
def test_the_error_that_is_stated_holds_and_tolerances_are_kept(
    rig: em.Rig, tmp_path: Path, dtype: str
) -> None:
    options: dict[str, Any] = {"tolerance": 2e-3} if dtype != "float32" else {}
    faces = em.make_faces(rig, tmp_path / "f", 200, vertices=dtype, codec="zstd", **options)
    stated = faces.labels["vertices"].dtype, faces.data.array("vertices").attrs
    exact = rig.batch(faces.weights[:], dtype=np.float64)
    error = np.abs(faces[:] - exact).max() / extent_of(rig)
    assert stated[0] == dtype
    assert error <= stated[1]["largest_error_of_D"] <= options.get("tolerance", 1e-5)
    assert error > 0.01 * stated[1]["largest_error_of_D"]


def test_a_tolerance_that_cannot_be_kept_is_refused(rig: em.Rig, tmp_path: Path) -> None:
    for dtype in ("float32", "float16", "int16"):
        with pytest.raises(ParameterError, match=f"{dtype} keeps .* of D for this rig"):
            em.make_faces(rig, tmp_path / "f", 9, vertices=dtype, tolerance=1e-9)
    assert not (tmp_path / "f").exists()


def test_faces_are_the_same_in_units_and_blocks_of_any_size(
    rig: em.Rig, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = em.make_faces(rig, tmp_path / "whole.zarr", 5, render=16, vertices="float32")
    one = em.make_faces(rig, tmp_path / "one.zarr", 5, render=16, vertices="float32", unit=1)
    monkeypatch.setattr("elastomorph.farm.making.executors._BLOCK_BYTES", 1)  # a face at a time
    each = em.make_faces(rig, tmp_path / "each.zarr", 5, render=16, vertices="float32")
    for name in ("weights", "vertices", "images/colour", "images/depth"):
        rows = whole.array(name)[:]
        assert np.array_equal(one.array(name)[:], rows)
        assert np.array_equal(each.array(name)[:], rows)


def test_a_wrong_unit_is_refused(rig: em.Rig, tmp_path: Path) -> None:
    for unit in (0, -2, 48, 2**21, 64.0):
        with pytest.raises(ParameterError, match="a unit is a power of two"):
            em.make_faces(rig, tmp_path / "f", 9, unit=unit)  # type: ignore[arg-type]


def test_other_programs_need_nothing_of_ours(folder: Path) -> None:
    """Weights and positions by what the attributes say, in a process without this package."""
    program = """
import sys
import dask.array, numpy, zarr
place, out = sys.argv[1:]
codes = zarr.open_group(place, mode="r")["weights"]
low, high = numpy.transpose(codes.attrs["ranges"])
vertices = zarr.open_array(place + "/vertices", mode="r").attrs
lazy = dask.array.from_zarr(place, component="vertices")
neutral = dask.array.from_zarr(place, component=vertices["offset"])
positions = (neutral + lazy * vertices["scale"]).compute()
numpy.savez(out, positions=positions, weights=low + codes[:] * (high - low) / 65535)
assert "elastomorph" not in sys.modules
"""
    out = folder.parent / "read.npz"
    subprocess.run([sys.executable, "-c", program, str(folder), str(out)], check=True)
    faces, read = em.open_faces(folder), np.load(out)
    assert np.allclose(read["positions"], faces[:], atol=1e-6)
    assert np.allclose(read["weights"], faces.values[:], atol=1e-12)
