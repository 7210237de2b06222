"""Meshes for the tests of files: small ones made by hand, random ones, and how they compare."""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from elastomorph.model.mesh import LARGEST, FaceLabels, Mesh, UVMap

FINITE = st.floats(-LARGEST, LARGEST)


def same_bits(one: np.ndarray, other: np.ndarray) -> bool:
    """Equal to the last bit: 0.0 and -0.0 differ."""
    return (
        one.dtype == other.dtype and one.shape == other.shape and one.tobytes() == other.tobytes()
    )


def assert_same_surface(one: Mesh, other: Mesh) -> None:
    assert same_bits(one.vertices, other.vertices)
    assert one.faces == other.faces


def assert_same_mesh(one: Mesh, other: Mesh) -> None:
    """Everything but the source is the same."""
    assert_same_surface(one, other)
    assert (one.uv is None) == (other.uv is None)
    if one.uv is not None and other.uv is not None:
        assert same_bits(one.uv.coordinates, other.uv.coordinates)
        assert same_bits(one.uv.corners, other.uv.corners)
    for mine, theirs in ((one.materials, other.materials), (one.groups, other.groups)):
        assert label_names(mine) == label_names(theirs)
        if mine is not None and theirs is not None:
            assert mine.names == theirs.names
    assert one.material_library == other.material_library


def label_names(labels: FaceLabels | None) -> list[str | None] | None:
    """The name of each polygon's label."""
    if labels is None:
        return None
    return [labels.names[i] if i >= 0 else None for i in labels.of_face.tolist()]


def labels_of(names: list[str | None]) -> FaceLabels | None:
    """Labels that give each polygon the name of the list."""
    known = tuple(dict.fromkeys(name for name in names if name is not None))
    if not known:
        return None
    places = [-1 if name is None else known.index(name) for name in names]
    return FaceLabels(known, np.array(places, dtype=np.int32))


def house() -> Mesh:
    """Five vertices, a quad and a triangle, with all the labels a mesh can have."""
    return Mesh(
        [[0, 0, 0], [1, 0, 0.1], [1, 1, -0.0], [0, 1, 1e-300], [0.5, 1.5, 1 / 3]],
        [[0, 1, 2, 3], [3, 2, 4]],
        uv=UVMap(
            np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.1, 0.7]]),
            np.array([0, 1, 2, 3, 3, 2, -1], dtype=np.int32),
        ),
        materials=labels_of(["wall", "roof"]),
        groups=labels_of([None, "upper part"]),
        material_library="house.mtl",
    )


def nameable(name: str) -> bool:
    """Whether OBJ text can hold the name."""
    ends_well = name == name.strip(" ") and not name.endswith("\\")
    return ends_well and "#" not in name.split(" ")


NAMES = st.text("abÄß漢 #\\/._-0", min_size=1, max_size=8).filter(nameable)


@st.composite
def meshes(draw: st.DrawFn) -> Mesh:
    """Meshes with any coordinates, polygons of mixed sizes, and any labels."""
    vertices = draw(arrays(np.float64, (draw(st.integers(1, 12)), 3), elements=FINITE))
    index = st.integers(0, len(vertices) - 1)
    faces = draw(st.lists(st.lists(index, min_size=3, max_size=6), max_size=8))
    corners = sum(map(len, faces))
    uv = None
    if draw(st.booleans()):
        shape = (draw(st.integers(1, 5)), draw(st.sampled_from([2, 3])))
        coordinates = draw(arrays(np.float64, shape, elements=FINITE))
        one = st.integers(draw(st.sampled_from([-1, 0])), len(coordinates) - 1)
        uv = UVMap(coordinates, draw(arrays(np.int32, corners, elements=one)))
    some = st.sampled_from([None, *draw(st.lists(NAMES, max_size=3))])
    each = st.lists(some, min_size=len(faces), max_size=len(faces))
    return Mesh(
        vertices,
        faces,
        uv=uv,
        materials=labels_of(draw(each)),
        groups=labels_of(draw(each)),
        material_library=draw(st.none() | NAMES),
    )
