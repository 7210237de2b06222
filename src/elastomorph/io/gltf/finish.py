"""How surfaces take light, as glTF's materials and those of VRM say it: read and written.

Toons of VRM 0.x are read as what they are in VRM 1.0, whose extension is written.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from elastomorph.io.gltf.lenient import number_of, numbers_of, object_of
from elastomorph.model.appearance import Finish, Layer, Texture, Toon

__all__ = ["finish_json", "read_finish"]

_TOON = "VRMC_materials_mtoon"
_STRENGTH = "KHR_materials_emissive_strength"
_UNLIT = "KHR_materials_unlit"
_QUEUES = {True: 2500, False: 3000}  # of what blends in Unity: what covers, and what does not
_PLACES: dict[Layer, tuple[str, ...]] = {
    "bumps": ("normalTexture",),
    "glow": ("emissiveTexture",),
    "finish": ("pbrMetallicRoughness", "metallicRoughnessTexture"),
    "creases": ("occlusionTexture",),
    "shade": ("extensions", _TOON, "shadeMultiplyTexture"),
}
_OLD_PLACES: dict[Layer, str] = {
    "bumps": "_BumpMap",
    "glow": "_EmissionMap",
    "shade": "_ShadeTexture",
}


def read_finish(
    entry: dict[str, Any],
    shader: dict[str, Any],
    texture: Callable[[dict[str, Any]], Texture | None],
) -> Finish | None:
    """The finish of a material; None of an unlit one.

    Args:
        entry: The material.
        shader: Its properties in VRM 0.x, or nothing.
        texture: What a reference to a texture shows, if it can be had.
    """
    old = str(shader.get("shader")) == "VRM/MToon"
    extensions = object_of(entry.get("extensions"))
    new = object_of(extensions.get(_TOON))
    if _UNLIT in extensions and not old and not new:
        return None
    references = {name: _within(entry, keys) for name, keys in _PLACES.items()}
    if old:
        given = object_of(shader.get("textureProperties"))
        references = {
            name: {"index": given[key]} for name, key in _OLD_PLACES.items() if key in given
        }
    layers = {name: found for name, own in references.items() if (found := texture(own))}
    shading = object_of(entry.get("pbrMetallicRoughness"))
    return Finish(
        roughness=number_of(shading.get("roughnessFactor"), 1.0),
        metal=number_of(shading.get("metallicFactor"), 1.0),
        glow=_old_glow(shader) if old else _glow(entry, extensions),
        bump=number_of(_within(entry, _PLACES["bumps"]).get("scale"), 1.0),
        crease=number_of(_within(entry, _PLACES["creases"]).get("strength"), 1.0),
        layers=layers,
        toon=_old_toon(shader) if old else _toon(new) if new else None,
    )


def _glow(entry: dict[str, Any], extensions: dict[str, Any]) -> tuple[float, float, float]:
    strength = number_of(object_of(extensions.get(_STRENGTH)).get("emissiveStrength"), 1.0)
    red, green, blue = numbers_of(entry.get("emissiveFactor"), (0.0, 0.0, 0.0))
    return strength * red, strength * green, strength * blue


def _old_glow(shader: dict[str, Any]) -> tuple[float, float, float]:
    colours = object_of(shader.get("vectorProperties"))
    red, green, blue, _ = numbers_of(colours.get("_EmissionColor"), (0.0, 0.0, 0.0, 1.0))
    return _linear(red), _linear(green), _linear(blue)


def _toon(given: dict[str, Any]) -> Toon:
    red, green, blue = numbers_of(given.get("shadeColorFactor"), (0.0, 0.0, 0.0))
    return Toon(
        (red, green, blue),
        number_of(given.get("shadingShiftFactor"), 0.0),
        number_of(given.get("shadingToonyFactor"), 0.9),
        given.get("transparentWithZWrite") is True,
        int(number_of(given.get("renderQueueOffsetNumber"), 0.0)),
    )


def _old_toon(shader: dict[str, Any]) -> Toon:
    """Of VRM 0.x, whose colours are those of screens and whose edge has other numbers."""
    settings = object_of(shader.get("floatProperties"))
    colours = object_of(shader.get("vectorProperties"))
    red, green, blue, _ = numbers_of(colours.get("_ShadeColor"), (0.97, 0.81, 0.86, 1.0))
    shift = number_of(settings.get("_ShadeShift"), 0.0)
    given = number_of(settings.get("_ShadeToony"), 0.9)
    toony = given + (1 - given) * (0.5 + 0.5 * shift)
    covers = settings.get("_BlendMode") == 3
    queue = int(number_of(shader.get("renderQueue"), 3000.0)) - _QUEUES[covers]
    shade = (_linear(red), _linear(green), _linear(blue))
    return Toon(shade, -shift - (1 - toony), toony, covers, queue)


def finish_json(
    finish: Finish, shown: Callable[[Texture], dict[str, Any] | None]
) -> tuple[dict[str, Any], dict[str, Any]]:
    """What a material says of a finish beside its base colour, and its extensions.

    Args:
        finish: The finish.
        shown: The reference to a texture; None for one without an image.
    """
    layers = {
        name: found for name, own in finish.layers.items() if (found := shown(own)) is not None
    }
    strength = max(1.0, *finish.glow)
    entry: dict[str, Any] = {
        "pbrMetallicRoughness": {
            "metallicFactor": finish.metal,
            "roughnessFactor": finish.roughness,
        },
        "emissiveFactor": [part / strength for part in finish.glow],
    }
    extensions: dict[str, Any] = {}
    if strength > 1.0:
        extensions[_STRENGTH] = {"emissiveStrength": strength}
    if finish.toon:
        extensions[_UNLIT] = {}
        extensions[_TOON] = _toon_json(finish.toon, layers.pop("shade", None))
    if "bumps" in layers:
        entry["normalTexture"] = {**layers["bumps"], "scale": finish.bump}
    if "creases" in layers:
        entry["occlusionTexture"] = {**layers["creases"], "strength": finish.crease}
    if "glow" in layers:
        entry["emissiveTexture"] = layers["glow"]
    if "finish" in layers:
        entry["pbrMetallicRoughness"]["metallicRoughnessTexture"] = layers["finish"]
    return entry, extensions


def _toon_json(toon: Toon, shade: dict[str, Any] | None) -> dict[str, Any]:
    return {
        "specVersion": "1.0",
        "transparentWithZWrite": toon.covers,
        "renderQueueOffsetNumber": toon.queue,
        "shadeColorFactor": list(toon.shade),
        "shadingShiftFactor": toon.shift,
        "shadingToonyFactor": toon.toony,
        **({} if shade is None else {"shadeMultiplyTexture": shade}),
    }


def _within(entry: Mapping[str, Any], keys: tuple[str, ...]) -> dict[str, Any]:
    found: Any = entry
    for key in keys:
        found = object_of(object_of(found).get(key))
    return object_of(found)


def _linear(part: float) -> float:
    """Light from a colour as screens take it."""
    return part / 12.92 if part <= 0.04045 else float(((part + 0.055) / 1.055) ** 2.4)
