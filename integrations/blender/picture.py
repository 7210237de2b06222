"""Draw the picture of the documentation: a face half way, on straight lines and bent.

    .venv-blender/bin/python integrations/blender/picture.py ZIP docs/blender.png

ZIP is the extension for this system (`build.py --platform …`); Blender is imported as a module.
"""

from __future__ import annotations

import os
import sys
import tempfile
from math import radians
from pathlib import Path

os.environ["BLENDER_USER_RESOURCES"] = tempfile.mkdtemp(prefix="elastomorph-blender-")
sys.path.insert(0, str(Path(__file__).parent / "tests"))

import bpy
import numpy as np
from heads import add_head, evaluated, select, set_weights, stored
from mathutils import Matrix

WEIGHTS = {"jawOpen": 0.5, "eyeBlinkLeft": 0.5, "eyeBlinkRight": 0.5}
LABELS = ("straight: jawOpen 0.5, eyeBlink 0.5", "bent: the same weights", "how far they are apart")
TURN = 55.0  # Degrees from the front to the side
WIDTH, HEIGHT = 960, 500
TONES = 63


def draw(extension: str, path: str) -> None:
    """Render the face on straight lines, bent, and bent with the distance of both as colour."""
    bpy.ops.extensions.package_install_files(
        filepath=extension, repo="user_default", enable_on_install=True
    )
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    import elastomorph as em

    rig = stored(em.read_rig("built-in"), *WEIGHTS)
    upright = Matrix.Rotation(radians(TURN), 4, "Z") @ Matrix.Rotation(radians(90), 4, "X")
    heads = []
    for label, place in zip(LABELS, (-1, 0, 1), strict=True):
        head = add_head(rig, label)
        head.matrix_world = Matrix.Translation((25 * place, 0, 0)) @ upright
        head.data.shade_smooth()
        set_weights(head, WEIGHTS)
        add_label(label, (25 * place, -14, -23))
        heads.append(head)
    straight = evaluated(heads[0]) - np.array(heads[0].location)
    for head in heads[1:]:
        select(head)
        bpy.ops.elastomorph.bend()
    bent = evaluated(heads[2]) - np.array(heads[2].location)
    apart = np.linalg.norm(bent - straight, axis=1)
    for head, shown in zip(heads, (None, None, apart), strict=True):
        head.data.materials.append(skin(head.data, shown))
    from elastomorph.rig.build import extent_of

    print(f"at most {apart.max() / extent_of(rig):.2%} of D apart")
    render(path)


def skin(mesh: bpy.types.Mesh, shown: np.ndarray | None) -> bpy.types.Material:
    """One colour, or from that to red by a number of each vertex."""
    amount = np.zeros(len(mesh.vertices)) if shown is None else shown / shown.max()
    plain, strong = np.array([0.55, 0.42, 0.36, 1.0]), np.array([0.75, 0.05, 0.02, 1.0])
    colours = plain + amount[:, None] * (strong - plain)
    layer = mesh.attributes.new("Colour", "FLOAT_COLOR", "POINT")
    layer.data.foreach_set("color", colours.astype(np.float32).ravel())
    material = bpy.data.materials.new("Skin")
    nodes = material.node_tree.nodes
    source = nodes.new("ShaderNodeVertexColor")
    source.layer_name = "Colour"
    surface = nodes["Principled BSDF"]
    surface.inputs["Roughness"].default_value = 0.6
    material.node_tree.links.new(source.outputs["Color"], surface.inputs["Base Color"])
    return material


def add_label(text: str, place: tuple[float, float, float]) -> None:
    """A line of text that faces the camera."""
    curve = bpy.data.curves.new(text, "FONT")
    curve.body, curve.size, curve.align_x = text, 1.4, "CENTER"
    thing = bpy.data.objects.new(text, curve)
    thing.location, thing.rotation_euler = place, (radians(90), 0, 0)
    material = bpy.data.materials.new("Ink")
    material.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (0, 0, 0, 1)
    curve.materials.append(material)
    bpy.context.scene.collection.objects.link(thing)


def add_lamp(name: str, place: tuple[float, float, float], power: float) -> None:
    """A square lamp that shines on the middle of the faces."""
    lamp = bpy.data.lights.new(name, "AREA")
    lamp.energy, lamp.size = power, 30
    thing = bpy.data.objects.new(name, lamp)
    thing.location = place
    thing.rotation_euler = (-thing.location).to_track_quat("-Z", "Y").to_euler()
    bpy.context.scene.collection.objects.link(thing)


def render(path: str) -> None:
    """The scene from the front, by Cycles on the processor."""
    scene = bpy.context.scene
    camera = bpy.data.cameras.new("Camera")
    camera.type, camera.ortho_scale = "ORTHO", 77
    scene.camera = bpy.data.objects.new("Camera", camera)
    scene.camera.location, scene.camera.rotation_euler = (0, -100, -4.6), (radians(90), 0, 0)
    scene.collection.objects.link(scene.camera)
    add_lamp("Key", (-30, -60, 30), 50_000)
    add_lamp("Fill", (50, -40, 5), 12_000)
    scene.world = bpy.data.worlds.new("World")
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (1, 1, 1, 1)
    scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0.35
    scene.render.engine, scene.cycles.samples, scene.cycles.use_denoising = "CYCLES", 48, True
    scene.render.resolution_x, scene.render.resolution_y = WIDTH, HEIGHT
    scene.render.film_transparent = True
    scene.view_settings.view_transform = "Standard"
    scene.render.image_settings.color_mode = "RGBA"
    scene.render.image_settings.compression = 100
    scene.render.filepath = str(Path(path).resolve())
    bpy.ops.render.render(write_still=True)
    on_white(scene.render.filepath)


def on_white(path: str) -> None:
    """Give a transparent picture a white background, and fewer tones, which pack well."""
    image = bpy.data.images.load(path)
    pixels = np.empty((len(image.pixels) // 4, 4), dtype=np.float32)
    image.pixels.foreach_get(pixels.ravel())
    pixels[:, :3] = pixels[:, :3] * pixels[:, 3:] + 1 - pixels[:, 3:]
    pixels = np.round(pixels * TONES) / TONES
    pixels[:, 3] = 1
    image.pixels.foreach_set(np.ascontiguousarray(pixels).ravel())
    bpy.context.scene.render.image_settings.color_mode = "RGB"
    image.save_render(path)


if __name__ == "__main__":
    draw(*sys.argv[1:])
