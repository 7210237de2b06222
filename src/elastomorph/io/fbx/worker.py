"""Takes the meshes and blend shapes out of an FBX file, in a process that may crash."""

from __future__ import annotations

import gc
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.io.isolated import RefusedError, serve

ADVICE = (
    "export it again as binary FBX 2014 or later from the program it was made with, or as another "
    "format"
)

# The binding takes fewer references to its objects than it gives back: each element that is looked
# up again and each array that NumPy reads costs one, and an object freed that way ends the process.
# A few more references on each, never given back, keep them all; so does leaving by os._exit.
_kept: list[object] = []
_SPARE_REFERENCES = 8


def content_of(source: str) -> dict[str, NDArray[Any]]:
    """The arrays of a file; a RefusedError where it is no FBX file, or a damaged one."""
    import ufbx

    content = Path(source).read_bytes()
    try:
        scene = ufbx.load_memory(content, ignore_animation=True, ignore_embedded=True)
        return _content(_hold(scene))
    except ufbx.UfbxError as error:
        raise RefusedError(
            f"it cannot be read as FBX ({str(error)[:200]}): it is damaged, cut off or another "
            f"format; {ADVICE}"
        ) from error


def _prepare() -> None:
    import ufbx  # noqa: F401

    gc.disable()


def _hold(thing: Any) -> Any:
    _kept.extend([thing] * _SPARE_REFERENCES)
    return thing


def _each(things: Iterable[Any]) -> list[Any]:
    return [_hold(thing) for thing in _hold(things)]


def _array(things: Any, dtype: str, columns: int | None = None) -> NDArray[Any]:
    """A list of the binding as an array of ours."""
    held = _hold(things)
    array = np.array(held).astype(dtype) if len(held) else np.empty(0, dtype=dtype)
    return array if columns is None else array.reshape(-1, columns)


def _content(scene: Any) -> dict[str, NDArray[Any]]:
    settings = _hold(scene.settings)
    axes = settings.axes
    arrays: dict[str, NDArray[Any]] = {
        # rows: what the author calls right, up and front
        "axes": np.stack([_direction(int(axis)) for axis in (axes.right, axes.up, axes.front)])
    }
    meshes = [node for node in _each(scene.nodes) if _hold(node.mesh) is not None]
    arrays["mesh_names"] = np.array([node.name for node in meshes], dtype=np.str_)
    arrays["mesh_shown"] = np.array([_is_shown(node) for node in meshes], dtype=np.int64)
    for number, node in enumerate(meshes):
        mesh = _hold(node.mesh)
        part = {
            "matrix": np.array([list(column) for column in node.geometry_to_world]),
            **_surface(mesh, node),
            **_shapes(mesh),
        }
        arrays |= {f"{number}_{name}": array for name, array in part.items()}
    return arrays


def _direction(axis: int) -> NDArray[np.float64]:
    """The unit vector of an axis that the binding numbers +X, -X, +Y, -Y, +Z, -Z."""
    direction = np.zeros(3)
    if 0 <= axis < 6:
        direction[axis // 2] = -1.0 if axis % 2 else 1.0
    return direction


def _is_shown(node: Any) -> bool:
    """Whether the author sees it: visible with all above it, and no lower level of detail."""
    below = None
    while node is not None:
        if not node.visible:
            return False
        if below is not None and _hold(node.attrib_type).name == "LOD_GROUP":
            levels = _each(node.children)
            if levels and levels[0].element_id != below.element_id:
                return False
        below, node = node, _hold(node.parent)
    return True


def _surface(mesh: Any, node: Any) -> dict[str, NDArray[Any]]:
    faces = _array(mesh.faces, "i8", 2)
    real = faces[:, 1] >= 3  # FBX also holds loose points and lines
    corners = _corners_of(faces[real])
    own = {
        "vertices": _array(mesh.vertices, "f8", 3),
        "face_indices": _array(mesh.vertex_indices, "i8")[corners],
        "face_offsets": np.concatenate([[0], np.cumsum(faces[real, 1])]).astype("i8"),
    }
    texture = _hold(mesh.vertex_uv)
    if texture.exists:
        own["uv_coordinates"] = _array(texture.values, "f8", 2)
        own["uv_corners"] = _array(texture.indices, "i8")[corners]
    materials = _each(node.materials) or _each(mesh.materials)
    of_face = _array(mesh.face_material, "i8")
    if materials and len(of_face) == len(faces):
        own["material_names"] = np.array([m.name for m in materials], dtype=np.str_)
        of_face[of_face >= len(materials)] = -1
        own["material_of_face"] = of_face[real]
    return own


def _corners_of(faces: NDArray[np.int64]) -> NDArray[np.int64]:
    """The corners of polygons given by their first corner and their number of corners."""
    sizes = faces[:, 1]
    within = np.arange(sizes.sum()) - np.repeat(np.cumsum(sizes) - sizes, sizes)
    corners: NDArray[np.int64] = np.repeat(faces[:, 0], sizes) + within
    return corners


def _shapes(mesh: Any) -> dict[str, NDArray[Any]]:
    """Blend shape channels; each with one shape, or with several at rising weights."""
    names: list[str] = []
    counts: list[int] = []
    weights: list[float] = []
    vertices = [np.empty(0, dtype="i8")]
    offsets = [np.empty((0, 3))]
    for deformer in _each(mesh.blend_deformers):
        for channel in _each(deformer.channels):
            keys = _each(channel.keyframes)
            shapes = [_hold(key.shape) for key in keys]
            if not keys:
                continue
            names.append(_plain_name(channel.name, deformer.name, shapes[-1].name))
            counts.append(len(keys))
            for key, shape in zip(keys, shapes, strict=True):
                weights.append(key.target_weight)
                moved = _array(shape.offset_vertices, "i8")
                by = _array(shape.position_offsets, "f8", 3)
                strength = _array(shape.offset_weights, "f8")
                # Blender writes the vertex group of a shape key, and some files nonsense instead.
                if len(strength) == len(moved) and ((strength >= 0) & (strength <= 1)).all():
                    by = by * strength[:, None]
                vertices.append(moved)
                offsets.append(by)
    return {
        "channel_names": np.array(names, dtype=np.str_),
        "key_counts": np.array(counts, dtype="i8"),
        "key_weights": np.array(weights, dtype="f8"),
        "key_sizes": np.array([len(own) for own in vertices[1:]], dtype="i8"),
        "key_vertices": np.concatenate(vertices),
        "key_offsets": np.concatenate(offsets),
    }


def _plain_name(channel: str, deformer: str, shape: str) -> str:
    """The slider's name: 'jawOpen' of the channel 'blendShape1.jawOpen'."""
    if not channel or channel.endswith(f".{shape}"):
        return shape
    return channel.removeprefix(f"{deformer}.")


if __name__ == "__main__":
    serve(_prepare, content_of)
