"""Gives the materials of a document the looks of a mesh: colours, images, opacity."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from elastomorph.io.gltf.finish import finish_json
from elastomorph.model.appearance import Material, Texture

__all__ = ["Looks", "image_kind"]

_WRAPS = {"repeat": 10497, "mirror": 33648, "clamp": 33071}
_NEAREST, _LINEAR, _MIPMAPS = 9728, 9729, 9987
_KINDS = ((b"\x89PNG\r\n\x1a\n", "image/png"), (b"\xff\xd8\xff", "image/jpeg"))
_WEBP = "EXT_texture_webp"


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
            "wrapS": _WRAPS[texture.wrap[0]],
            "wrapT": _WRAPS[texture.wrap[1]],
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
