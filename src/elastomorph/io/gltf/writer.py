"""Writes a rig as one GLB file that every viewer of morph targets plays."""

from __future__ import annotations

import math
from collections.abc import Mapping
from contextlib import nullcontext
from pathlib import Path
from typing import Any, BinaryIO, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from elastomorph.errors import FormatError, ParameterError
from elastomorph.io.atomic import replacing
from elastomorph.io.gltf.buffers import BufferWriter
from elastomorph.io.gltf.clips import performance_clip, slider_clips
from elastomorph.io.gltf.container import glb_chunks, without_empty
from elastomorph.io.gltf.document import materials, primitives, weight_animation
from elastomorph.io.gltf.export_report import GlbReport
from elastomorph.io.gltf.layout import Layout, lay_out
from elastomorph.io.gltf.normals import NormalField, normal_deltas
from elastomorph.io.gltf.rig_extras import rig_extras
from elastomorph.io.gltf.surface_extras import surface_extras
from elastomorph.io.gltf.targets import MorphTargets
from elastomorph.io.gltf.weight_signs import with_positive_weights
from elastomorph.rig import Rig
from elastomorph.rig.timing import Timing, linear

__all__ = ["Performance", "require_glb_settings", "write_glb"]

Performance = tuple[ArrayLike, ArrayLike, str]
"""Times (T,) in seconds, weights (T, J) of the sliders of a rig, and a name."""

# A normal that turns by less (0.06°) is lit alike; writing it would make most targets dense.
_LEAST_TURN = 1e-3
# The largest single float is 3.4e38; differences and sums of coordinates must fit too.
_LARGEST = 1e37
# The header of a GLB file counts its bytes in 32 bits.
_LARGEST_FILE = 2**32 - 1


def write_glb(
    path: str | Path | BinaryIO,
    rig: Rig,
    *,
    normals: Literal["delta", "none"] = "delta",
    tolerance: float = 5e-7,
    keys_tolerance: float = 1e-4,
    fps: float = 30,
    sparse: bool = True,
    timing: Timing = linear,
    animation: Performance | None = None,
    settings: Mapping[str, Any] | None = None,
) -> GlbReport:
    """Write a rig as a binary glTF 2.0 file.

    Δ of a morph becomes the morph target of its name, each of its bends another one
    (``jawOpen.bend1``). An animation a morph plays it from 0 to 1 in one second. Software that
    sets weights itself gives Δ the weight t and the bends the weights b_k(t), whose curves are in
    ``extras.elastomorph`` of the mesh. Bends with curves below 0 are stored the other way round,
    because some programs hold weights between 0 and 1. The polygons come back from `read_glb` as
    they were.

    Args:
        path: The file; its folder must exist. A file that is there is replaced at once. Or a
            binary file that is open for writing, such as ``io.BytesIO()``.
        rig: The rig.
        normals: ``"delta"``: morph targets turn the normals too; about half as large again.
            ``"none"``: the normals stay those of the neutral.
        tolerance: Where a bend moves vertices no farther than this fraction of D, it is left out.
        keys_tolerance: Largest distance, as a fraction of D, between a path and the straight
            lines between the keys of its animation.
        fps: Frames per second, rounded to a whole number; the keys lie on frames where these are
            close enough together.
        sparse: Store only the vertices that a morph target moves, where that is smaller.
        timing: The t of a path at each moment of its animation, from 0 to 1 evenly by default;
            see `elastomorph.rig.timing`. The path itself stays as it is.
        animation: A recorded performance, written in place of an animation a morph: times (T,)
            in seconds from 0, weights (T, J) of the sliders of ``rig.names``, and its name.
        settings: How the rig was made, as JSON: kept in ``extras.elastomorph`` of the mesh and
            given back by `elastomorph.io.settings_used.settings_used`.

    Returns:
        What was written, and how far it can be from the rig.

    Raises:
        FileError: The file cannot be written.
        FormatError: Coordinates too large for single precision, numbers that are not finite, or
            more than 4 GiB.
        ParameterError: An argument is out of its range.
    """
    require_glb_settings(normals, tolerance, keys_tolerance, fps)
    name = path if isinstance(path, str | Path) else "the GLB file"
    _require_storable(name, rig)
    rig = with_positive_weights(rig)
    targets = MorphTargets.of(rig, tolerance)
    if animation is None:
        clips = slider_clips(rig, targets, keys_tolerance, fps, timing)
    else:
        clips = [performance_clip(rig, targets, *animation)]
    layout = lay_out(rig.neutral)
    buffer = BufferWriter()
    attributes, displaced = _vertex_accessors(buffer, rig, targets, layout, normals, sparse)
    stored = {**rig_extras(rig, targets), "surface": surface_extras(rig.neutral, layout)}
    mesh = {
        "extras": {"targetNames": list(targets.names), "elastomorph": stored},
        "primitives": primitives(buffer, layout, attributes, displaced),
        "weights": [0.0] * len(targets.names),
        "name": "face",
    }
    animations = [weight_animation(buffer, clip) for clip in clips] if targets.names else []
    views, blob = buffer.finish()
    document = without_empty(
        {
            "accessors": buffer.accessors,
            "animations": animations,
            "asset": {"generator": "elastomorph", "version": "2.0"},
            "bufferViews": views,
            "buffers": [{"byteLength": len(blob)}],
            "materials": materials(rig.neutral, layout),
            "meshes": [mesh],
            "nodes": [{"mesh": 0, "name": "face"}],
            "scene": 0,
            "scenes": [{"nodes": [0]}],
        }
    )
    if settings is not None:
        document["meshes"][0]["extras"]["elastomorph"]["settings"] = dict(settings)
    chunks = glb_chunks(document, blob)
    size = sum(map(len, chunks))
    if size > _LARGEST_FILE:
        raise FormatError(
            name, "a GLB file holds less than 4 GiB; leave out normals, or export fewer morphs"
        )
    with replacing(path) if isinstance(path, str | Path) else nullcontext(path) as file:
        file.writelines(chunks)
    return GlbReport(
        vertices=len(layout.vertex_of),
        triangles=sum(len(part.triangles) for part in layout.parts),
        targets=len(targets.names),
        bends=len(targets.names) - len(rig.morphs),
        dropped_bends=targets.dropped,
        bytes=size,
        dropped_error=targets.dropped_error,
        rounding_error=targets.rounding_error,
        key_error=max((clip.key_error for clip in clips), default=0.0),
        parts={"json": size - len(blob), **buffer.sizes},
    )


def _vertex_accessors(
    buffer: BufferWriter,
    rig: Rig,
    targets: MorphTargets,
    layout: Layout,
    normals: str,
    sparse: bool,
) -> tuple[dict[str, int], list[dict[str, int]]]:
    """Accessors of the neutral, and of each morph target."""

    def rows(values: NDArray[np.float64]) -> NDArray[np.float32]:
        return values.astype(np.float32)[layout.vertex_of]

    neutral = rig.neutral
    attributes = {"POSITION": buffer.vertices(rows(neutral.vertices), "surface", bounds=True)}
    field, at_rest = NormalField.of(neutral.faces), np.zeros_like(neutral.vertices)
    if len(neutral.faces):
        at_rest = field.normals(neutral.vertices)
        attributes["NORMAL"] = buffer.vertices(rows(at_rest), "surface")
    if layout.texture is not None:
        attributes["TEXCOORD_0"] = buffer.vertices(layout.texture, "surface")
    displaced = []
    for morph, kept in zip(rig.morphs.values(), targets.morphs, strict=True):
        fields = [morph.delta, *kept.displacements]
        group = [
            {"POSITION": buffer.vertices(rows(each), "positions", bounds=True, sparse=sparse)}
            for each in fields
        ]
        if normals == "delta" and len(neutral.faces):
            turned = normal_deltas(field, morph, kept.bends, at_rest)
            turned[np.linalg.norm(turned, axis=2) < _LEAST_TURN] = 0.0
            for target, each in zip(group, turned, strict=True):
                target["NORMAL"] = buffer.vertices(rows(each), "normals", sparse=sparse)
        displaced += group
    return attributes, displaced


def require_glb_settings(
    normals: str = "delta",
    tolerance: float = 0.0,
    keys_tolerance: float = 0.0,
    fps: float = 30.0,
    sparse: bool = True,
) -> None:
    """Check options of `write_glb`.

    Raises:
        ParameterError: One is out of its range.
    """
    if normals not in ("delta", "none"):
        raise ParameterError(f"normals must be 'delta' or 'none', found {normals!r}")
    for name, value in (("tolerance", tolerance), ("keys_tolerance", keys_tolerance)):
        if not math.isfinite(value) or value < 0:
            raise ParameterError(f"{name} must be a finite number from 0, found {value}")
    if not 1 <= fps <= 1000:
        raise ParameterError(f"fps must be from 1 to 1000, found {fps}")


def _require_storable(path: str | Path, rig: Rig) -> None:
    shapes = [rig.neutral.vertices]
    for morph in rig.morphs.values():
        shapes += [morph.target.vertices, morph.bends]
    largest = max(float(np.abs(shape).max(initial=0.0)) for shape in shapes)
    if largest > _LARGEST:
        raise FormatError(
            path, f"a coordinate of {largest:.3g} is too large for single precision; scale the rig"
        )
    for name, morph in rig.morphs.items():
        if not math.isfinite(morph.bake_error):
            raise FormatError(path, f"the bake error of the morph {name!r} is not a finite number")
    uv = rig.neutral.uv
    if uv is not None and not (np.abs(uv.coordinates) < _LARGEST).all():
        raise FormatError(path, "a texture coordinate is not finite or too large for glTF")
