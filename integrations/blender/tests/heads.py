"""Heads in the scene, and where their vertices are when Blender has evaluated everything."""

import sys
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path

import bpy
import numpy as np

sys.path.append(str(Path(__file__).parents[3] / "tests"))

CLOSE = 1e-5
"""Of D: how close what Blender shows is to the rig."""


@cache
def small_head(*names: str):
    """Some targets of the small head, or all, as Blender stores them; with paths."""
    from small_head import bare_head

    return stored(bare_head(), *names)


def stored(rig, *names: str):
    """Some targets of a rig, or all, as Blender stores them; with paths."""
    chosen = names or rig.names
    return with_paths(single(rig.neutral), {name: single(rig[name].target) for name in chosen})


def with_paths(neutral, targets, method: str = "auto"):
    """A rig with the paths that a character gets."""
    import elastomorph as em
    from elastomorph.bending.plan import make_plan
    from elastomorph.model.mesh import Source
    from elastomorph.rig.build import bare_rig

    whole = em.Mesh(neutral.vertices, neutral.faces, source=Source("head", split=True))
    ends = {name: whole.with_vertices(target.vertices) for name, target in targets.items()}
    return make_plan(bare_rig(whole, ends), method).rig


def single(mesh):
    """A mesh at positions in single precision."""
    return mesh.with_vertices(mesh.vertices.astype(np.float32))


def split(rig, lower):
    """The rig in two parts, with no polygon between them."""
    import elastomorph as em

    order = np.concatenate([np.flatnonzero(~lower), np.flatnonzero(lower)])
    number = np.argsort(order)
    parts = (~lower, lower)
    faces = [number[f] for part in parts for f in rig.neutral.faces if part[f].all()]
    neutral = em.Mesh(rig.neutral.vertices[order], faces)
    targets = {n: neutral.with_vertices(rig[n].target.vertices[order]) for n in rig.morphs}
    return with_paths(neutral, targets)


def add_head(
    rig, name: str = "Head", kept: np.ndarray | None = None, names: Sequence[str] = ()
) -> bpy.types.Object:
    """An object with the neutral and the targets of a rig, or those of its vertices to be kept."""
    own = np.arange(len(rig.neutral.vertices)) if kept is None else np.flatnonzero(kept)
    number = np.full(len(rig.neutral.vertices), -1)
    number[own] = np.arange(len(own))
    faces = [number[face].tolist() for face in rig.neutral.faces if (number[face] >= 0).all()]
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(rig.neutral.vertices[own].tolist(), [], faces)
    thing = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(thing)
    thing.shape_key_add(name="Basis")
    for target in names or rig.names:
        block = thing.shape_key_add(name=target, from_mix=False)
        positions = rig[target].target.vertices[own]
        block.data.foreach_set("co", positions.astype(np.float32).ravel())
        block.value = 0.0
    select(thing)
    return thing


def select(*things: bpy.types.Object) -> None:
    """Select these objects only; the first is active."""
    for other in bpy.context.view_layer.objects:
        other.select_set(False)
    for thing in things:
        thing.select_set(True)
    bpy.context.view_layer.objects.active = things[0]


def set_weights(thing: bpy.types.Object, weights: Mapping[str, float]) -> None:
    """Set the sliders of the keys that an object has."""
    for name, weight in weights.items():
        block = thing.data.shape_keys.key_blocks.get(name)
        if block is not None:
            block.slider_min = min(block.slider_min, weight)
            block.slider_max = max(block.slider_max, weight)
            block.value = weight


def settle(*keys: bpy.types.Key) -> None:
    """Evaluate drivers seven times.

    Blender 5.0 now and then evaluates a driver before what it reads from the same data-block,
    whoever made the driver, and shows the moment before: up to once in a hundred evaluations on a
    busy machine, once in a thousand after two in a row.
    """
    graph = bpy.context.evaluated_depsgraph_get()
    graph.update()
    for _ in range(6):
        for own in keys:
            own.update_tag()
        graph.update()


def evaluated(*things: bpy.types.Object) -> np.ndarray:
    """(V, 3) positions in the world, as Blender draws them."""
    settle(*(t.data.shape_keys for t in things if t.data.shape_keys))
    graph = bpy.context.evaluated_depsgraph_get()
    found = []
    for thing in things:
        shown = thing.evaluated_get(graph)
        flat = np.empty(3 * len(shown.data.vertices), dtype=np.float32)
        shown.data.vertices.foreach_get("co", flat)
        to_world = np.array(shown.matrix_world)
        found.append(flat.reshape(-1, 3).astype(float) @ to_world[:3, :3].T + to_world[:3, 3])
    return np.concatenate(found)


def set_keyframes(thing: bpy.types.Object, weights: Mapping[str, Sequence[float]]) -> None:
    """Weights of frames 1, 2, … as keyframes, as an animator would set them."""
    blocks = thing.data.shape_keys.key_blocks
    for name, values in weights.items():
        for frame, value in enumerate(values, start=1):
            blocks[name].slider_min = min(blocks[name].slider_min, float(value))
            blocks[name].slider_max = max(blocks[name].slider_max, float(value))
            blocks[name].value = value
            blocks[name].keyframe_insert("value", frame=frame)


def apart(found: np.ndarray, expected: np.ndarray, rig) -> float:
    """The largest distance between vertices, as a part of the extent of the face."""
    from elastomorph.rig.build import extent_of

    return float(np.linalg.norm(found - expected, axis=1).max()) / extent_of(rig)


def bend_keys(thing: bpy.types.Object) -> list[str]:
    """Names of the keys of an object that are bends."""
    return [block.name for block in thing.data.shape_keys.key_blocks if ".bend" in block.name]


def curves_of(head):
    """The animation curves of the shape keys of an object."""
    return fcurves(head.data.shape_keys.animation_data)


def fcurves(animation):
    """The animation curves of the active action."""
    strip = animation.action.layers[0].strips[0]
    return strip.channelbag(animation.action_slot).fcurves


def random_weights(names, frames: int = 12, least: float = 0.0, most: float = 1.0):
    """Weights of some frames, the same in every run, as single precision holds them."""
    table = np.random.default_rng(7).uniform(least, most, (frames, len(names)))
    return dict(zip(names, table.astype(np.float32).T, strict=True))


def frames_apart(things, rig, weights) -> float:
    """The largest distance between what Blender shows and the rig, over all frames."""
    count = len(next(iter(weights.values())))
    worst = 0.0
    for frame in range(count):
        bpy.context.scene.frame_set(frame + 1)
        now = {name: float(values[frame]) for name, values in weights.items()}
        worst = max(worst, apart(evaluated(*things), rig.pose(now), rig))
    return worst


def add_performed(names: Sequence[str] = ("jawOpen", "eyeBlink_L", "mouthSmile_L")):
    """A bent head that plays random weights for 12 frames, its rig and the weights."""
    rig = small_head(*names)
    head = add_head(rig)
    weights = random_weights(names)
    set_keyframes(head, weights)
    for curve in curves_of(head):
        for point in curve.keyframe_points:
            point.interpolation = "LINEAR"
    bpy.context.scene.frame_end = 12
    bpy.ops.elastomorph.bend()
    return head, rig, weights
