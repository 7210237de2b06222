"""Materials of a document and the looks of a mesh, either from the other: colours, images, light.

Nothing here refuses a file: whoever reads shapes need not care for an image that is missing. A
texture that cannot be had says why, and the one who draws says so.

How a surface takes light is told as glTF's materials and those of VRM tell it. Toons of VRM 0.x are
read as what they are in VRM 1.0, whose extension is written.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from typing import Any

from elastomorph.errors import ElastomorphError
from elastomorph.io.blend_shapes import different_names
from elastomorph.io.gltf.container import (
    GltfFile,
    entry_of,
    key_of,
    number_of,
    numbers_of,
    object_of,
)
from elastomorph.model.mesh import (
    WHITE,
    Finish,
    Layer,
    Material,
    Opacity,
    Texture,
    Toon,
    Wrap,
)

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


_WRAPS: dict[Any, Wrap] = {10497: "repeat", 33648: "mirror", 33071: "clamp"}
_NEAREST = 9728
_OPACITIES: dict[Any, Opacity] = {"OPAQUE": "opaque", "MASK": "mask", "BLEND": "blend"}
_TRANSFORM = "KHR_texture_transform"
_WEBP = "EXT_texture_webp"
_GLOSSY = "KHR_materials_pbrSpecularGlossiness"
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
    unlit = any(name in extensions for name in (_UNLIT, _TOON))
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


_WRAP_NUMBERS = {wrap: number for number, wrap in _WRAPS.items()}
_LINEAR, _MIPMAPS = 9729, 9987
_KINDS = ((b"\x89PNG\r\n\x1a\n", "image/png"), (b"\xff\xd8\xff", "image/jpeg"))


class Looks:
    """Collects textures, samplers and images while materials are written down.

    Attributes:
        used: The extensions that were needed, and whether a reader must know them.
    """

    def __init__(self, appearance: Mapping[str, Material] | None) -> None:
        self._appearance = appearance or {}
        self._samplers: list[dict[str, Any]] = []
        self._textures: list[dict[str, Any]] = []
        self._images: dict[bytes, str] = {}
        self.used: dict[str, bool] = {}

    @property
    def size(self) -> int:
        """Bytes of the images."""
        return sum(map(len, self._images))

    def material(self, name: str, otherwise: Mapping[str, Any]) -> dict[str, Any]:
        """A material of this name, as JSON: with its own looks, or those of another."""
        found = self._appearance.get(name)
        if found is None:
            return {**otherwise, "name": name}
        shading: dict[str, Any] = {
            "baseColorFactor": list(found.colour),
            "metallicFactor": 0.0,
            "roughnessFactor": 0.7,
        }
        if found.texture is not None and (shown := self._shown(found.texture)) is not None:
            shading["baseColorTexture"] = shown
        entry: dict[str, Any] = {
            "name": name,
            "pbrMetallicRoughness": shading,
            "alphaMode": found.opacity.upper(),
            "doubleSided": found.double_sided,
        }
        if found.opacity == "mask":
            entry["alphaCutoff"] = found.cutoff
        extensions: dict[str, Any] = {"KHR_materials_unlit": {}} if found.unlit else {}
        if found.finish is not None:
            said, more = finish_json(found.finish, self._shown)
            shading |= said.pop("pbrMetallicRoughness")
            entry |= said
            extensions |= more
        if extensions:
            entry["extensions"] = extensions
            self.used = dict.fromkeys(extensions, False) | self.used
        return entry

    def add_to(self, document: dict[str, Any], blob: bytes) -> bytes:
        """Add what was collected to a document, and the images to the bytes of its first buffer."""
        views, images = document.setdefault("bufferViews", []), []
        for content, kind in self._images.items():
            place = {"buffer": 0, "byteOffset": len(blob), "byteLength": len(content)}
            images.append({"bufferView": len(views), "mimeType": kind})
            views.append({**place, "name": "image"})
            blob += content + bytes(-len(content) % 4)
        lists = {"images": images, "samplers": self._samplers, "textures": self._textures}
        document.update({key: value for key, value in lists.items() if value})
        for key, names in (
            ("extensionsUsed", list(self.used)),
            ("extensionsRequired", [name for name, needed in self.used.items() if needed]),
        ):
            if names:
                document[key] = sorted({*document.get(key, ()), *names})
        document["buffers"][0] = {"byteLength": len(blob)}
        return blob

    def _shown(self, texture: Texture) -> dict[str, Any] | None:
        """How a material shows a texture; None for one without an image that glTF knows."""
        kind = image_kind(texture.image)
        if kind is None:
            return None
        self._images.setdefault(texture.image, kind)
        source = list(self._images).index(texture.image)
        sampler = {
            "magFilter": _LINEAR if texture.smooth else _NEAREST,
            "minFilter": _MIPMAPS if texture.smooth else _NEAREST,
            "wrapS": _WRAP_NUMBERS[texture.wrap[0]],
            "wrapT": _WRAP_NUMBERS[texture.wrap[1]],
        }
        entry: dict[str, Any] = {"sampler": _place(self._samplers, sampler), "source": source}
        if kind == "image/webp":
            self.used[_WEBP] = True
            entry = {"sampler": entry["sampler"], "extensions": {_WEBP: {"source": source}}}
        shown: dict[str, Any] = {"index": _place(self._textures, entry)}
        if (texture.offset, texture.rotation, texture.scale) != ((0.0, 0.0), 0.0, (1.0, 1.0)):
            self.used.setdefault("KHR_texture_transform", False)
            place = {"offset": list(texture.offset), "scale": list(texture.scale)}
            moved = {**place, "rotation": texture.rotation}
            shown["extensions"] = {"KHR_texture_transform": moved}
        return shown


def image_kind(content: bytes) -> str | None:
    """The media type of an image that glTF knows, by how it begins."""
    for start, kind in _KINDS:
        if content.startswith(start):
            return kind
    return "image/webp" if content[:4] == b"RIFF" and content[8:12] == b"WEBP" else None


def _place(entries: list[dict[str, Any]], entry: dict[str, Any]) -> int:
    """The number of an entry, which is added where none is equal."""
    if entry not in entries:
        entries.append(entry)
    return entries.index(entry)
