"""What a document says of looks: base colours, textures and opacity of its materials.

Nothing here refuses a file: whoever reads shapes need not care for an image that is missing. A
texture that cannot be had says why, and the one who draws says so.
"""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

from elastomorph.errors import ElastomorphError
from elastomorph.io.blend_shapes import different_names
from elastomorph.io.gltf.container import GltfFile
from elastomorph.io.gltf.finish import read_finish
from elastomorph.io.gltf.lenient import entry_of, key_of, number_of, numbers_of, object_of
from elastomorph.model.appearance import WHITE, Material, Opacity, Texture, Wrap

__all__ = ["material_names", "read_appearance", "shown_coordinates"]

_WRAPS: dict[Any, Wrap] = {10497: "repeat", 33648: "mirror", 33071: "clamp"}
_NEAREST = 9728
_OPACITIES: dict[Any, Opacity] = {"OPAQUE": "opaque", "MASK": "mask", "BLEND": "blend"}
_TRANSFORM = "KHR_texture_transform"
_WEBP = "EXT_texture_webp"
_GLOSSY = "KHR_materials_pbrSpecularGlossiness"
_UNLIT = ("KHR_materials_unlit", "VRMC_materials_mtoon")
# VRM 0.x writes down the settings of Unity's shader.
_OLD_OPACITIES: dict[Any, Opacity] = {0: "opaque", 1: "mask", 2: "blend", 3: "blend"}
_TEXTURE_SETS = 8


def material_names(file: GltfFile) -> list[str]:
    """The names of all materials of a document, each different from the others."""
    found = file.items("materials")
    given = (each.get("name") if isinstance(each, dict) else None for each in found)
    return different_names(
        name if isinstance(name, str) else f"material {number}" for number, name in enumerate(given)
    )


def shown_coordinates(file: GltfFile, primitive: dict[str, Any]) -> str:
    """The attribute with the texture coordinates by which a primitive shows its base colour."""
    number = primitive.get("material")
    materials = file.items("materials")
    found = "TEXCOORD_0"
    if type(number) is int and 0 <= number < len(materials):
        texture = _base(object_of(materials[number]))[1]
        chosen = _set_of(texture)
        if type(chosen) is int and 0 <= chosen < _TEXTURE_SETS:
            found = f"TEXCOORD_{chosen}"
    return found if found in object_of(primitive.get("attributes")) else "TEXCOORD_0"


def read_appearance(file: GltfFile, names: Collection[str]) -> dict[str, Material] | None:
    """The materials of these names of `material_names`, by name; None where all are plain greys.

    Such files say nothing of looks: what their parts are, their names tell.
    """
    shaders = object_of(object_of(file.document.get("extensions")).get("VRM")).get(
        "materialProperties"
    )
    old = shaders if isinstance(shaders, list) else []
    found = {}
    for number, name in enumerate(material_names(file)):
        if name in names:
            shader = object_of(old[number]) if number < len(old) else {}
            found[name] = _material(file, object_of(file.items("materials")[number]), shader)
    return None if all(material.plain for material in found.values()) else found


def _material(file: GltfFile, entry: dict[str, Any], shader: dict[str, Any]) -> Material:
    colour, texture = _base(entry)
    extensions = object_of(entry.get("extensions"))
    opacity = _OPACITIES.get(key_of(entry.get("alphaMode")), "opaque")
    cutoff = number_of(entry.get("alphaCutoff"), 0.5)
    double = entry.get("doubleSided") is True
    unlit = any(name in extensions for name in _UNLIT)
    if str(shader.get("shader")).startswith(("VRM/MToon", "VRM/Unlit")):
        settings = object_of(shader.get("floatProperties"))
        unlit = True
        opacity = _OLD_OPACITIES.get(key_of(settings.get("_BlendMode")), opacity)
        cutoff = number_of(settings.get("_Cutoff"), cutoff)
        double = double or settings.get("_CullMode") == 0
        image = object_of(shader.get("textureProperties")).get("_MainTex")
        texture = texture or ({} if image is None else {"index": image})

    def layer(shown: dict[str, Any]) -> Texture | None:
        """As `_texture`, of those that take the coordinates of the base colour and are there."""
        if "index" not in shown or _set_of(shown) != _set_of(texture):
            return None
        found = _texture(file, shown)
        return found if found.image else None

    return Material(
        _colour(colour),
        _texture(file, texture) if texture else None,
        opacity,
        cutoff,
        double,
        unlit,
        read_finish(entry, shader, layer),
    )


def _set_of(texture: dict[str, Any]) -> Any:
    """The number of the texture coordinates that a texture takes."""
    transform = object_of(object_of(texture.get("extensions")).get(_TRANSFORM))
    return transform.get("texCoord", texture.get("texCoord", 0))


def _base(entry: dict[str, Any]) -> tuple[Any, dict[str, Any]]:
    """The colour factor and the texture of a material."""
    glossy = object_of(object_of(entry.get("extensions")).get(_GLOSSY))
    if glossy:
        return glossy.get("diffuseFactor"), object_of(glossy.get("diffuseTexture"))
    metallic = object_of(entry.get("pbrMetallicRoughness"))
    return metallic.get("baseColorFactor"), object_of(metallic.get("baseColorTexture"))


def _texture(file: GltfFile, shown: dict[str, Any]) -> Texture:
    """A texture as a material shows it, with its image where that can be had."""
    number = shown.get("index")
    entry = entry_of(file, "textures", number)
    sampler = entry_of(file, "samplers", entry.get("sampler"))
    transform = object_of(object_of(shown.get("extensions")).get(_TRANSFORM))
    source = object_of(object_of(entry.get("extensions")).get(_WEBP)).get("source")
    source = entry.get("source") if source is None else source
    picture = entry_of(file, "images", source)
    named = picture.get("name")
    name = named if isinstance(named, str) and named else f"texture {number}"
    content, problem = _content(file, picture, source)
    across, down = numbers_of(transform.get("offset"), (0.0, 0.0))
    wide, high = numbers_of(transform.get("scale"), (1.0, 1.0))
    return Texture(
        content,
        name[:60],
        problem,
        (_wrap(sampler.get("wrapS")), _wrap(sampler.get("wrapT"))),
        (across, down),
        number_of(transform.get("rotation"), 0.0),
        (wide, high),
        smooth=sampler.get("magFilter") != _NEAREST,
    )


def _content(file: GltfFile, picture: dict[str, Any], source: Any) -> tuple[bytes, str]:
    """The content of an image file, or none and why."""
    if not picture:
        return b"", "it names no PNG, JPEG or WebP image"
    if picture.get("mimeType") == "image/ktx2":
        return b"", "KTX2 images are not read"
    of, uri = f"image {source}", picture.get("uri")
    try:
        if isinstance(uri, str):
            found = file.uri_content(uri, of)
        else:
            found = bytes(file.view(picture.get("bufferView"), of)[0])
        file.budget.spend(len(found))
        return found, ""
    except ElastomorphError as error:
        return b"", str(error).removeprefix(f"{file.path}: ")


def _colour(given: Any) -> tuple[float, float, float, float]:
    red, green, blue, alpha = (min(max(part, 0.0), 1.0) for part in numbers_of(given, WHITE))
    return red, green, blue, alpha


def _wrap(given: Any) -> Wrap:
    return _WRAPS.get(key_of(given), "repeat")
