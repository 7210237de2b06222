"""Rigs and files for the tests of glTF: made by hand, or random within what single floats hold."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from elastomorph.model.bend_curve import BendCurve
from elastomorph.model.mesh import FaceLabels, Mesh, UVMap
from elastomorph.model.morph import Morph
from elastomorph.model.polygons import Polygons
from elastomorph.rig import Rig
from foreign_files import chunks_of, glb


def own_extras(path: Path) -> dict[str, Any]:
    """``extras.elastomorph`` of the one mesh of a file."""
    found: dict[str, Any] = chunks_of(path)[0]["meshes"][0]["extras"]["elastomorph"]
    return found


class HandMade:
    """A document built accessor by accessor, as other programs write them."""

    def __init__(self) -> None:
        self.blob = b""
        self.more_buffers: list[dict[str, Any]] = []  # after the one that holds the bytes
        self.document: dict[str, Any] = {
            "asset": {"version": "2.0"},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": []}],
            "bufferViews": [],
            "accessors": [],
        }

    def view(self, content: bytes, **fields: Any) -> int:
        self.blob += bytes(-len(self.blob) % 4)
        view = {"buffer": 0, "byteOffset": len(self.blob), "byteLength": len(content), **fields}
        self.document["bufferViews"].append(view)
        self.blob += content
        return len(self.document["bufferViews"]) - 1

    def accessor(self, **fields: Any) -> int:
        self.document["accessors"].append(fields)
        return len(self.document["accessors"]) - 1

    def array(self, values: Any, kind: str = "<f4", **fields: Any) -> int:
        codes = {"i1": 5120, "u1": 5121, "<i2": 5122, "<u2": 5123, "<u4": 5125, "<f4": 5126}
        array = np.asarray(values).astype(kind)
        return self.accessor(
            bufferView=self.view(array.tobytes()),
            componentType=codes[kind],
            count=len(array),
            type="SCALAR" if array.ndim == 1 else f"VEC{array.shape[1]}",
            **fields,
        )

    def primitive(self, mesh: int = 0, **fields: Any) -> dict[str, Any]:
        self.document["meshes"][mesh]["primitives"].append(fields)
        return fields

    def write(self, path: Path) -> Path:
        self.document["buffers"] = [{"byteLength": len(self.blob)}, *self.more_buffers]
        path.write_bytes(glb(self.document, self.blob))
        return path


SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float)
CORNERS = [0, 1, 2, 0, 2, 3]
MOVED = np.array([[0, 0, 0], [0, 0, 0.5], [0, 0, -0.25], [0, 0, 0]])


def square(**target: Any) -> HandMade:
    """A square of two triangles with one morph target."""
    file = HandMade()
    file.primitive(
        attributes={"POSITION": file.array(SQUARE)},
        indices=file.array(CORNERS, "<u2"),
        targets=[target or {"POSITION": file.array(MOVED)}],
    )
    return file


def triangle() -> Mesh:
    return Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])


def triangle_rig() -> Rig:
    """One triangle that stands up about the x axis on a parabola."""
    flat = triangle()
    up = flat.with_vertices([[0, 0, 0], [1, 0, 0], [0, 0, 1]])
    bend = np.zeros((1, 3, 3))
    bend[0, 2] = [0, -0.5, -0.5]
    return Rig(flat, {"lift": Morph(flat, up, bend, (BendCurve.power(2),), method="by hand")})


def sheet(rows: int, targets: int) -> Rig:
    """A wavy sheet of quads, and targets that each lift another strip of it, some on parabolas."""
    u, v = np.meshgrid(np.linspace(0, 1, rows), np.linspace(0, 1, rows))
    flat = np.stack([u, v, 0.1 * np.sin(9 * u) * np.sin(7 * v)], axis=2).reshape(-1, 3)
    corner = (np.arange(rows - 1)[:, None] * rows + np.arange(rows - 1)).reshape(-1, 1)
    mesh = Mesh(flat, Polygons.of(corner + [0, 1, rows + 1, rows]))
    morphs = {}
    for number in range(targets):
        near = np.exp(-200 * (flat[:, 0] - number / targets) ** 2)[:, None]
        lifted = mesh.with_vertices(flat + 0.2 * near * [0, 0.3, 1])
        bends = 0.1 * near[None] * np.array([[[0, 1, 0]]]) * (number % 2)
        morphs[f"lift {number}"] = Morph(mesh, lifted, bends, (BendCurve.power(2),))
    return Rig(mesh, morphs)


def seamed_mesh() -> Mesh:
    """Two quads and a triangle in a row, with a texture seam, two materials and groups."""
    return Mesh(
        [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0, 0], [2, 1, 0.5], [3, 0, 0]],
        [[0, 1, 2, 3], [1, 4, 5, 2], [4, 6, 5]],
        uv=UVMap(
            np.array([[0, 0], [0.5, 0], [0.5, 1], [0, 1], [0.6, 0], [0.6, 1], [1, 0], [1, 1]]),
            np.array([0, 1, 2, 3, 4, 6, 7, 5, 6, 6, 7], dtype=np.int32),
        ),
        materials=FaceLabels(("skin", "unused", "teeth"), np.array([2, 0, -1], dtype=np.int32)),
        groups=FaceLabels(("left", ""), np.array([0, 0, 1], dtype=np.int32)),
        material_library="face.mtl",
    )


# Two sliders "a", which bends, and "b" on the mesh above, as written before each material had a
# mesh of its own: three primitives that share the vertices.
SHARED_VERTICES = Path(__file__).with_name("shared_vertices.glb")


COORDINATES = st.floats(-100, 100, allow_nan=False, width=32)
NAMES = st.text("abcÄ漢 ._", min_size=0, max_size=6)


@st.composite
def curves(draw: st.DrawFn) -> BendCurve:
    """Polynomials without constant term that end at 0, and piecewise cubics."""
    if draw(st.booleans()):
        free = draw(st.lists(st.floats(-3, 3), min_size=1, max_size=4))
        return BendCurve.polynomial([0.0, -sum(free), *free])
    middle = draw(st.floats(0.1, 0.9))
    height, slope = draw(st.floats(-2, 2)), draw(st.floats(-2, 2))
    pieces = []
    for length, start, end in (
        (middle, (0.0, 1.0), (height, slope)),
        (1 - middle, (height, slope), (0.0, 0.0)),
    ):
        rise = (end[0] - start[0]) / length
        pieces.append(
            [
                start[0],
                start[1],
                (3 * rise - 2 * start[1] - end[1]) / length,
                (start[1] + end[1] - 2 * rise) / length**2,
            ]
        )
    return BendCurve([0, middle, 1], pieces)


@st.composite
def labels(draw: st.DrawFn, polygons: int) -> FaceLabels | None:
    names = draw(st.lists(NAMES, max_size=3, unique=True))
    places = draw(arrays(np.int32, polygons, elements=st.integers(-1, len(names) - 1)))
    return draw(st.sampled_from([None, FaceLabels(tuple(names), places)]))


@st.composite
def meshes(draw: st.DrawFn) -> Mesh:
    """Polygons of three to six corners, seams, labels; every polygon has distinct corners."""
    count = draw(st.integers(1, 12))
    vertices = draw(arrays(np.float64, (count, 3), elements=COORDINATES))
    vertices[0] = [0, 0, 0]
    vertices[-1] = [10, 0, 0]
    sides = st.integers(3, 6).flatmap(
        lambda n: st.permutations(range(count)).map(lambda order: list(order[: min(n, count)]))
    )
    faces = draw(st.lists(sides, max_size=6)) if count >= 3 else []
    corners = sum(map(len, faces))
    uv = None
    if draw(st.booleans()):
        table = draw(
            st.sampled_from([2, 3]).flatmap(
                lambda width: arrays(
                    np.float64,
                    (draw(st.integers(1, 6)), width),
                    elements=st.sampled_from([0.0, 0.25, 0.1, 0.123456, 1 / 3, -2.5, -0.0]),
                )
            )
        )
        uv = UVMap(table, draw(arrays(np.int32, corners, elements=st.integers(-1, len(table) - 1))))
    return Mesh(
        vertices,
        faces,
        uv=uv,
        materials=draw(labels(len(faces))),
        groups=draw(labels(len(faces))),
        material_library=draw(st.sampled_from([None, "a.mtl"])),
    )


@st.composite
def rigs(draw: st.DrawFn) -> Rig:
    """Up to four morphs with up to three bends, a corrective and a group."""
    neutral = draw(meshes())
    shape = neutral.vertices.shape
    steps = arrays(np.float64, shape, elements=st.just(0.0) | st.floats(-5, 5, width=32))
    morphs = {}
    for name in draw(st.lists(NAMES, max_size=4, unique=True)):
        drawn = draw(st.lists(curves(), max_size=3))
        bends = [draw(steps) for _ in drawn]
        morphs[name] = Morph(
            neutral,
            neutral.with_vertices(neutral.vertices + draw(steps)),
            np.stack(bends) if bends else np.zeros((0, *shape)),
            tuple(drawn),
            method=draw(NAMES),
            limit_law=draw(curves()),
            bake_error=draw(st.sampled_from([0.0, 1e-5])),
        )
    names = list(morphs)
    return Rig(
        neutral,
        morphs,
        correctives={names[-1]: names[:2]} if len(names) > 2 else None,
        groups={"": [], "some": names[:1]} if names else None,
    )
