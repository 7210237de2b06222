"""The parts of a glTF document that a rig needs: primitives, materials, animations."""

from __future__ import annotations

from typing import Any

from elastomorph.io.gltf.buffers import BufferBuilder, pygltflib
from elastomorph.io.gltf.clips import Clip
from elastomorph.io.gltf.layout import Layout
from elastomorph.model.mesh import Mesh

__all__ = ["materials", "primitives", "weight_animation"]


def primitives(
    buffer: BufferBuilder,
    layout: Layout,
    attributes: dict[str, int],
    displaced: list[dict[str, int]],
) -> list[Any]:
    """One primitive a material, all on the same vertices.

    Args:
        buffer: Where the triangles go.
        layout: The triangles.
        attributes: Accessors of the neutral.
        displaced: Accessors of each morph target.
    """
    library = pygltflib()
    shared: dict[str, Any] = {
        "attributes": library.Attributes(**attributes),
        "targets": [dict(target) for target in displaced],
    }
    if not layout.parts:  # markers without a surface
        return [library.Primitive(mode=library.POINTS, **shared)]
    return [
        library.Primitive(
            mode=library.TRIANGLES,
            indices=buffer.indices(part.triangles, len(layout.vertex_of)),
            material=number,
            **shared,
        )
        for number, part in enumerate(layout.parts)
    ]


def materials(mesh: Mesh, layout: Layout) -> list[Any]:
    """A plain material for each primitive, of the name the mesh has for it."""
    library = pygltflib()
    names = mesh.materials.names if mesh.materials is not None else ()
    return [
        library.Material(
            name=names[part.label] if part.label >= 0 else "unnamed",
            # The default of glTF is bare metal, which is black where nothing is reflected.
            pbrMetallicRoughness=library.PbrMetallicRoughness(
                baseColorFactor=[0.8, 0.8, 0.8, 1.0], metallicFactor=0.0, roughnessFactor=0.7
            ),
        )
        for part in layout.parts
    ]


def weight_animation(buffer: BufferBuilder, clip: Clip) -> Any:
    """An animation of the weights of node 0."""
    library = pygltflib()
    return library.Animation(
        name=clip.name,
        samplers=[
            library.AnimationSampler(
                input=buffer.times(clip.times),
                output=buffer.weights(clip.weights),
                interpolation="LINEAR",
            )
        ],
        channels=[
            library.AnimationChannel(
                sampler=0, target=library.AnimationChannelTarget(node=0, path="weights")
            )
        ],
    )
