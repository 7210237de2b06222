"""The parts of a glTF document that a rig needs: primitives, materials, animations."""

from __future__ import annotations

from typing import Any

from elastomorph.io.gltf.buffers import BufferWriter
from elastomorph.io.gltf.clips import Clip
from elastomorph.io.gltf.layout import Layout
from elastomorph.model.mesh import Mesh

__all__ = ["materials", "primitives", "weight_animation"]

_POINTS, _TRIANGLES = 0, 4


def primitives(
    buffer: BufferWriter,
    layout: Layout,
    attributes: dict[str, int],
    displaced: list[dict[str, int]],
) -> list[dict[str, Any]]:
    """One primitive a material, all on the same vertices.

    Args:
        buffer: Where the triangles go.
        layout: The triangles.
        attributes: Accessors of the neutral.
        displaced: Accessors of each morph target.
    """
    if not layout.parts:  # markers without a surface
        return [{"attributes": attributes, "mode": _POINTS, "targets": displaced}]
    return [
        {
            "attributes": attributes,
            "indices": buffer.indices(part.triangles, len(layout.vertex_of)),
            "mode": _TRIANGLES,
            "material": number,
            "targets": displaced,
        }
        for number, part in enumerate(layout.parts)
    ]


def materials(mesh: Mesh, layout: Layout) -> list[dict[str, Any]]:
    """A plain material for each primitive, of the name the mesh has for it."""
    names = mesh.materials.names if mesh.materials is not None else ()
    return [
        {
            # The default of glTF is bare metal, which is black where nothing is reflected.
            "pbrMetallicRoughness": {
                "baseColorFactor": [0.8, 0.8, 0.8, 1.0],
                "metallicFactor": 0.0,
                "roughnessFactor": 0.7,
            },
            "emissiveFactor": [0.0, 0.0, 0.0],
            "alphaMode": "OPAQUE",
            "doubleSided": False,
            "name": names[part.label] if part.label >= 0 else "unnamed",
        }
        for part in layout.parts
    ]


def weight_animation(buffer: BufferWriter, clip: Clip) -> dict[str, Any]:
    """An animation of the weights of node 0."""
    times, weights = buffer.times(clip.times), buffer.weights(clip.weights)
    return {
        "name": clip.name,
        "channels": [{"sampler": 0, "target": {"node": 0, "path": "weights"}}],
        "samplers": [{"input": times, "interpolation": "LINEAR", "output": weights}],
    }
