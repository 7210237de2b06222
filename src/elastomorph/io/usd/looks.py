"""What materials of a stage look like, as UsdPreviewSurface says it, in the process of a worker.

Other kinds of shaders are passed over, and so is everything that is no base colour or opacity. An
image must be a file below a folder of the stage, or lie in a package there.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.io.isolated import allow_for
from elastomorph.io.usd.composed import Composed
from elastomorph.io.usd.library import pxr

_WRAPS = {"repeat": "repeat", "mirror": "mirror", "clamp": "clamp", "black": "clamp"}


def looks_of(
    arrays: dict[str, NDArray[Any]], materials: dict[str, Any], opened: Composed
) -> dict[str, dict[str, Any]]:
    """What JSON can hold of the looks of materials by name; images go into the arrays."""
    images: dict[str, int] = {}
    found = {}
    for name, material in materials.items():
        shader = _source(material.ComputeSurfaceSource())
        if shader and shader.GetIdAttr().Get() == "UsdPreviewSurface":
            found[name] = _look(arrays, images, shader, opened)
    return found


def coordinates_of(material: Any) -> str | None:
    """The name of the texture coordinates by which a material shows its base colour."""
    shader = _source(material.ComputeSurfaceSource())
    image = _input(shader, "diffuseColor")[1] if shader else None
    reader = _maker(image, "st") if image is not None else None
    if reader and reader.GetIdAttr().Get() == "UsdTransform2d":
        reader = _maker(reader, "in")
    if not reader or reader.GetIdAttr().Get() != "UsdPrimvarReader_float2":
        return None
    return str(_input(reader, "varname")[0] or "") or None


def _maker(shader: Any, name: str) -> Any:
    """The shader that an input is connected with."""
    given = shader.GetInput(name)
    sources = pxr("UsdShade").Utils.GetValueProducingAttributes(given) if given else []
    return pxr("UsdShade").Shader(sources[0].GetPrim()) if sources else None


def _look(
    arrays: dict[str, NDArray[Any]], images: dict[str, int], shader: Any, opened: Composed
) -> dict[str, Any]:
    colour, texture = _input(shader, "diffuseColor")
    alpha, mask = _input(shader, "opacity")
    threshold, _ = _input(shader, "opacityThreshold")
    cutoff = _number(threshold, 0.0)
    clear = mask is not None or _number(alpha, 1.0) < 1.0
    rgb = [_number(part, 0.18) for part in colour] if colour is not None else [0.18] * 3
    look: dict[str, Any] = {
        "colour": [*(rgb if texture is None else [1.0] * 3), 1.0 if mask else _number(alpha, 1.0)],
        "opacity": "mask" if cutoff > 0 else "blend" if clear else "opaque",
        "cutoff": cutoff,
    }
    if texture is not None:
        look["texture"] = _texture(arrays, images, texture, opened)
    return look


def _input(shader: Any, name: str) -> tuple[Any, Any]:
    """The value of an input, or the shader of the texture it is connected with."""
    given = shader.GetInput(name)
    if not given:
        return None, None
    for attribute in pxr("UsdShade").Utils.GetValueProducingAttributes(given):
        source = pxr("UsdShade").Shader(attribute.GetPrim())
        connected = source and source.GetPrim() != shader.GetPrim()
        if connected and source.GetIdAttr().Get() == "UsdUVTexture":
            return None, source
        return attribute.Get(), None
    return None, None


def _texture(
    arrays: dict[str, NDArray[Any]], images: dict[str, int], shader: Any, opened: Composed
) -> dict[str, Any]:
    asset, _ = _input(shader, "file")
    path = str(getattr(asset, "resolvedPath", "") or "")
    named = str(getattr(asset, "path", "") or "")
    if path and path not in images and _is_near(path, opened):
        content = _bytes(path)
        if content is not None:
            images[path] = len(images)
            arrays[f"image_{images[path]}"] = np.frombuffer(content, dtype=np.uint8)
    return {
        "image": images.get(path),
        "name": named[-60:],
        "wrap": [_WRAPS.get(str(_input(shader, key)[0]), "repeat") for key in ("wrapS", "wrapT")],
        **_transform(shader),
    }


def _transform(texture: Any) -> dict[str, Any]:
    """A UsdTransform2d of the coordinates, turned into one that counts from the top."""
    shader = _maker(texture, "st")
    if not shader or shader.GetIdAttr().Get() != "UsdTransform2d":
        return {}
    across, down = _pair(_input(shader, "scale")[0], 1.0)
    x, y = _pair(_input(shader, "translation")[0], 0.0)
    turn = math.radians(_number(_input(shader, "rotation")[0], 0.0))
    cosine, sine = math.cos(turn), math.sin(turn)
    return {
        "offset": [x - sine * down, 1.0 - cosine * down - y],
        "rotation": turn,
        "scale": [across, down],
    }


def _is_near(path: str, opened: Composed) -> bool:
    """Whether a file, or the package it is in, lies where the stage may take files from."""
    own, part = path, ""
    if pxr("Ar").IsPackageRelativePath(path):
        own, part = pxr("Ar").SplitPackageRelativePathOuter(path)
    try:
        whole = Path(own).resolve()
        inside = any(whole.is_relative_to(folder) for folder in opened.folders)
    except (OSError, RuntimeError, ValueError):
        return False
    return inside and ".." not in part.split("/")


def _bytes(path: str) -> bytes | None:
    if not pxr("Ar").IsPackageRelativePath(path):
        try:
            allow_for(Path(path).stat().st_size)
            return Path(path).read_bytes()
        except OSError:
            return None
    asset = pxr("Ar").GetResolver().OpenAsset(pxr("Ar").ResolvedPath(path))
    return None if asset is None else bytes(asset.GetBuffer())


def _source(found: Any) -> Any:
    """The shader of what ComputeSurfaceSource gives: it alone, or first of several."""
    return found[0] if isinstance(found, tuple) else found


def _number(value: Any, otherwise: float) -> float:
    try:
        found = float(value)
    except (TypeError, ValueError):
        return otherwise
    return found if math.isfinite(found) else otherwise


def _pair(value: Any, otherwise: float) -> tuple[float, float]:
    if value is None or len(value) != 2:
        return otherwise, otherwise
    return _number(value[0], otherwise), _number(value[1], otherwise)
