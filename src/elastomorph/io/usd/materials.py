"""What materials look like as UsdPreviewSurfaces, and the files of their images."""

from __future__ import annotations

import math
import re
from itertools import count
from pathlib import Path
from typing import Any

from elastomorph.errors import warn
from elastomorph.io.gltf.appearance import image_kind
from elastomorph.io.usd.library import pxr
from elastomorph.model.mesh import Finish, Material, Texture

_SUFFIXES = {"image/png": ".png", "image/jpeg": ".jpg"}
_TYPES = {"rgb": "Float3", "diffuseColor": "Color3f", "emissiveColor": "Color3f"}
_TYPES |= {"normal": "Normal3f", "result": "Float2", "surface": "Token"}


class Images:
    """The images that materials show, as files whose names begin alike.

    Attributes:
        names: The name of the file of each content.
    """

    def __init__(self, prefix: str) -> None:
        self.names: dict[bytes, str] = {}
        self._prefix = prefix

    def name(self, texture: Texture) -> str | None:
        """The file of a texture; None, and a warning, for one that USD does not know."""
        suffix = _SUFFIXES.get(image_kind(texture.image) or "")
        if suffix is None:
            problem = texture.problem or "USD shows PNG and JPEG images alone"
            warn(f"the texture {texture.name!r} is left out ({problem}); its colour stays")
            return None
        stem = re.sub(r"\W+", "_", Path(texture.name).stem).removeprefix(self._prefix)
        names = (f"{self._prefix}{stem}{number or ''}{suffix}" for number in count())
        free = next(name for name in names if name not in self.names.values())
        return self.names.setdefault(texture.image, free)


def define_look(stage: Any, material: Any, look: Material, images: Images | None) -> None:
    """Define the surface of a material; without images where the mesh does not place them."""
    finish = look.finish or Finish(roughness=0.7)
    clear, mask = look.opacity != "opaque", look.opacity == "mask"
    surface = _shader(
        stage,
        material,
        "surface",
        "UsdPreviewSurface",
        diffuseColor=look.colour[:3],
        emissiveColor=finish.glow,
        roughness=finish.roughness,
        metallic=finish.metal,
        opacity=look.colour[3] if clear else 1.0,
        opacityThreshold=look.cutoff if mask else 0.0,
    )
    _connect(material.CreateSurfaceOutput(), surface, "surface")
    layers, crease = finish.layers, finish.crease
    shown: list[tuple[str, Texture | None, tuple[float, ...], float, dict[str, str]]] = [
        ("base", look.texture, look.colour, 0.0, {"diffuseColor": "rgb"}),
        ("glow", layers.get("glow"), (*finish.glow, 1.0), 0.0, {"emissiveColor": "rgb"}),
        (
            *("finish", layers.get("finish"), (1.0, finish.roughness, finish.metal, 1.0), 0.0),
            {"roughness": "g", "metallic": "b"},
        ),
        ("creases", layers.get("creases"), (crease,) * 4, 1.0 - crease, {"occlusion": "r"}),
        ("bumps", layers.get("bumps"), (2.0,) * 3 + (1.0,), -1.0, {"normal": "rgb"}),
    ]
    if clear:
        shown[0][4]["opacity"] = "a"
    for name, texture, factors, shift, inputs in shown:
        file = images and texture and images.name(texture)
        if not (texture and file):
            continue
        image = _shader(
            stage,
            material,
            name,
            "UsdUVTexture",
            file=pxr("Sdf").AssetPath(f"./{file}"),
            sourceColorSpace="sRGB" if name in ("base", "glow") else "raw",
            wrapS=texture.wrap[0],
            wrapT=texture.wrap[1],
            scale=factors,
            bias=(shift, shift, shift, 0.0),
        )
        _connect(_input(image, "st"), _coordinates(stage, material, name, texture), "result")
        for key, channel in inputs.items():
            _connect(_input(surface, key), image, channel)


def _coordinates(stage: Any, material: Any, name: str, texture: Texture) -> Any:
    """The shader that says where a texture lies: USD counts from the bottom of an image."""
    reader = _shader(stage, material, "coordinates", "UsdPrimvarReader_float2", varname="st")
    (x, y), turn, (across, down) = texture.offset, texture.rotation, texture.scale
    if (x, y, turn, across, down) == (0.0, 0.0, 0.0, 1.0, 1.0):
        return reader
    moved = _shader(
        stage,
        material,
        f"{name}_place",
        "UsdTransform2d",
        scale=(across, down),
        rotation=math.degrees(turn),
        translation=(x + math.sin(turn) * down, 1.0 - math.cos(turn) * down - y),
    )
    _connect(_input(moved, "in"), reader, "result")
    return moved


def _shader(stage: Any, material: Any, name: str, kind: str, **inputs: Any) -> Any:
    """A shader of a kind with values of its inputs, whose types they and their names tell."""
    gf, types = pxr("Gf"), pxr("Sdf").ValueTypeNames
    shader = pxr("UsdShade").Shader.Define(stage, material.GetPath().AppendChild(name))
    shader.CreateIdAttr(kind)
    for key, value in inputs.items():
        if isinstance(value, tuple):
            default = f"Float{len(value)}"
            value = getattr(gf, f"Vec{len(value)}f")(*value)
        else:
            text = "String" if key == "varname" else "Token"
            default = {str: text, float: "Float"}.get(type(value), "Asset")
        shader.CreateInput(key, getattr(types, _TYPES.get(key, default))).Set(value)
    return shader


def _input(shader: Any, name: str) -> Any:
    """An input of a shader, defined where it has no value."""
    default = "Float2" if name in ("st", "in") else "Float"
    kind = getattr(pxr("Sdf").ValueTypeNames, _TYPES.get(name, default))
    return shader.GetInput(name) or shader.CreateInput(name, kind)


def _connect(to: Any, shader: Any, output: str) -> None:
    kind = getattr(pxr("Sdf").ValueTypeNames, _TYPES.get(output, "Float"))
    to.ConnectToSource(shader.CreateOutput(output, kind))
