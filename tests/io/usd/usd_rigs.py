"""Rigs for the tests of USD, and UsdSkel's own word on where their points go."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from blended_points import blended
from elastomorph.errors import FormatError
from elastomorph.io.blend_shapes import hats
from elastomorph.io.isolated import RefusedError
from elastomorph.io.npz.members import open_npz, write_arrays
from elastomorph.io.untrusted import MemoryBudget
from elastomorph.io.usd import reader, worker
from elastomorph.io.usd.reader import found_meshes
from elastomorph.model.bend_curve import BendCurve
from elastomorph.model.mesh import FaceLabels, Mesh, UVMap
from elastomorph.model.morph import Morph
from elastomorph.rig import Rig

NAMES = st.text(st.characters(exclude_characters="\0", codec="utf-8"), max_size=6)
SMALL = st.floats(-2, 2, allow_nan=False, width=32)


def grid(rows: int = 4, columns: int = 5) -> Mesh:
    """A sheet of quads, the last of them split in two, with all the labels a mesh can have."""
    y, x = np.mgrid[:rows, :columns]
    vertices = np.stack([x, y, 0.1 * x * y], axis=-1).reshape(-1, 3) / 3
    corner = (y * columns + x)[:-1, :-1].reshape(-1)
    faces: list[list[int]] = [[c, c + 1, c + columns + 1, c + columns] for c in corner.tolist()]
    a, b, c, d = faces.pop()
    faces += [[a, b, c], [a, c, d]]
    of_face = np.arange(len(faces), dtype=np.int32) % 3 - 1
    corners = np.concatenate([np.array(face) for face in faces]).astype(np.int32)
    corners[3] = -1
    return Mesh(
        vertices,
        faces,
        uv=UVMap(vertices[:, :2] / 2, corners),
        materials=FaceLabels(("skin.001", "lip stick"), of_face),
        groups=FaceLabels(("upper part", "unused", "smile"), np.where(of_face == 0, 2, of_face)),
        material_library="face.mtl",
    )


def curved(mesh: Mesh, seed: int, moved: slice, powers: int = 2) -> Morph:
    """A morph of some vertices with bends t^k - t."""
    random = np.random.default_rng(seed)
    target = mesh.vertices.copy()
    target[moved] += random.normal(size=target[moved].shape)
    bends = np.zeros((powers, *target.shape))
    bends[:, moved] = random.normal(size=bends[:, moved].shape)
    curves = tuple(BendCurve.power(k) for k in range(2, powers + 2))
    return Morph(mesh, mesh.with_vertices(target), bends, curves, "beam", curves[0], 1e-5)


def sample_rig() -> Rig:
    """Curved, straight, empty and piecewise linear morphs with difficult names."""
    mesh = grid()
    random = np.random.default_rng(5)
    target = mesh.with_vertices(mesh.vertices + random.normal(size=mesh.vertices.shape))
    bends = random.normal(size=(2, *mesh.vertices.shape))
    morphs = {
        "jaw open.v2": curved(mesh, 1, slice(3, 9)),
        "smile": curved(mesh, 2, slice(0, 20), powers=3),
        "straight": Morph(mesh, target, np.zeros((0, *mesh.vertices.shape)), ()),
        "nothing": Morph(mesh, mesh, np.zeros((0, *mesh.vertices.shape)), ()),
        "pieces": Morph(mesh, target, bends, hats(np.array([0.25, 0.6875])), "inbetweens"),
        "Lächeln": curved(mesh, 3, slice(1, 2)),
        "jaw-open v2": curved(mesh, 4, slice(0, 4)),
    }
    return Rig(
        mesh,
        morphs,
        correctives={"pieces": ("smile", "straight")},
        groups={"mouth": ("smile", "jaw open.v2")},
    )


@st.composite
def rigs(draw: st.DrawFn) -> Rig:
    """Rigs of any polygons with morphs of any shapes, powers and names."""
    vertices = draw(arrays(np.float64, (draw(st.integers(2, 8)), 3), elements=SMALL))
    vertices[0], vertices[1] = (-1, 0, 0), (1, 0, 0)
    index = st.integers(0, len(vertices) - 1)
    mesh = Mesh(vertices, draw(st.lists(st.lists(index, min_size=3, max_size=5), max_size=5)))
    morphs = {}
    for name in draw(st.lists(NAMES, max_size=4, unique=True)):
        powers = draw(st.lists(st.integers(2, 6), max_size=3, unique=True))
        target = draw(arrays(np.float64, vertices.shape, elements=SMALL))
        bends = draw(arrays(np.float64, (len(powers), *vertices.shape), elements=SMALL))
        curves = tuple(map(BendCurve.power, powers))
        morphs[name] = Morph(mesh, mesh.with_vertices(target), bends, curves, draw(NAMES))
    return Rig(mesh, morphs)


def posed_by_usd(path: Path, weights: Mapping[str, float], mesh: str = "/Face/Mesh") -> np.ndarray:
    """Points as UsdSkel itself evaluates blend shapes, by the names of their prims."""
    from pxr import Usd, UsdSkel

    stage = Usd.Stage.Open(str(path))
    prim = stage.GetPrimAtPath(mesh)
    order = UsdSkel.BindingAPI(prim).GetBlendShapesAttr().Get()
    return np.array(blended(prim, [weights.get(name, 0.0) for name in order]))


def played_by_usd(path: Path, code: float) -> np.ndarray:
    """Points as UsdSkel plays the animation of the file and skins them to its skeleton."""
    from pxr import Usd, UsdSkel

    stage = Usd.Stage.Open(str(path))
    root = UsdSkel.Root(stage.GetDefaultPrim())
    cache = UsdSkel.Cache()
    assert cache.Populate(root, Usd.PrimDefaultPredicate)
    (bound,) = cache.ComputeSkelBindings(root, Usd.PrimDefaultPredicate)
    (target,) = bound.GetSkinningTargets()
    query = cache.GetSkelQuery(bound.GetSkeleton())
    animation = query.GetAnimQuery()
    weights = animation.ComputeBlendShapeWeights(code)
    skinned = blended(target.GetPrim(), target.GetBlendShapeMapper().Remap(weights))
    assert target.ComputeSkinnedPoints(query.ComputeSkinningTransforms(code), skinned, code)
    return np.array(skinned)


def piecewise_linear(morph: Morph, inbetweens: tuple[float, ...], t: float) -> np.ndarray:
    """Straight between the positions of the path at 0, the in-betweens and 1."""
    knots = np.array([0.0, *inbetweens, 1.0])
    place = int(np.clip(np.searchsorted(knots, t) - 1, 0, len(knots) - 2))
    low, high = knots[place : place + 2]
    ends = morph.at([low, high])
    return ends[0] + (t - low) / (high - low) * (ends[1] - ends[0])


def read_in_this_process(
    path: Path, folder: Path, *wanted: str, budget: MemoryBudget | None = None
) -> Rig:
    """As `read_usd`, without the process of its own: for many harmless files in a short time."""
    archive = folder / "scene.npz"
    try:
        write_arrays(archive, worker.content_of(str(path), *wanted))
    except RefusedError as error:
        raise FormatError(path, str(error)) from error
    with open_npz(archive, budget or MemoryBudget(path, 1 << 22)) as members:
        found = found_meshes(path, members)
        parts = reader.parts_of(path, found, members.budget)
        return reader.rig_of(path, found, parts, members.budget)


def assert_same_paths(one: Morph, other: Morph, tolerance: float = 1e-6) -> None:
    """The same path everywhere, within a fraction of D."""
    size = one.neutral.diameter or 1.0
    for t in (-0.3, 0.0, 0.2, 0.5, 0.77, 1.0, 1.4):
        apart = np.linalg.norm(one.at(t) - other.at(t), axis=1).max()
        assert apart <= tolerance * size


def author_shapes(stage: Any, place: str, vertices: np.ndarray, shapes: Mapping[str, Any]) -> Any:
    """A mesh of one quad strip with blend shapes, as another program might write them.

    Each shape is (offsets, point indices or None, {weight: offsets}).
    """
    from pxr import UsdGeom, UsdSkel

    mesh = UsdGeom.Mesh.Define(stage, place)
    mesh.CreatePointsAttr(vertices.tolist())
    mesh.CreateFaceVertexCountsAttr([4] * (len(vertices) // 2 - 1))
    starts = range(0, len(vertices) - 2, 2)
    mesh.CreateFaceVertexIndicesAttr([i + k for i in starts for k in (0, 1, 3, 2)])
    targets = []
    for name, (offsets, points, inbetweens) in shapes.items():
        shape = UsdSkel.BlendShape.Define(stage, mesh.GetPath().AppendChild(name))
        shape.CreateOffsetsAttr(offsets.tolist())
        if points is not None:
            shape.CreatePointIndicesAttr(points)
        for i, (weight, own) in enumerate(inbetweens.items()):
            inbetween = shape.CreateInbetween(f"in{i}")
            inbetween.SetOffsets(own.tolist())
            inbetween.SetWeight(weight)
        targets.append(shape.GetPath())
    binding = UsdSkel.BindingAPI.Apply(mesh.GetPrim())
    binding.CreateBlendShapesAttr(list(shapes))
    binding.CreateBlendShapeTargetsRel().SetTargets(targets)
    return mesh
