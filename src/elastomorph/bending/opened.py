"""A character that was read once: its rig, and its own file with the paths that a rig was given.

The file is one of chunks that needs no other, and may show some of its meshes alone. Numbers of
nodes, meshes, accessors and views stay what they are, so that all that names them holds.
"""

from __future__ import annotations

import copy
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

from elastomorph.bending.face import Face, FaceMesh
from elastomorph.bending.files import Character, written_glb
from elastomorph.bending.gltf import FEWEST, KEYS_TOLERANCE, CharacterEdit, of_bounded_depth
from elastomorph.bending.plan import make_plan
from elastomorph.errors import ElastomorphError, FormatError
from elastomorph.io.gltf.appearance import image_kind
from elastomorph.io.gltf.clips import POINTER
from elastomorph.io.gltf.container import GltfFile
from elastomorph.io.gltf.meshopt import EXTENSIONS as MESHOPT
from elastomorph.io.gltf.reader import (
    ReadMesh,
    read_meshes,
    require_known_extensions,
    rig_of,
    wanted_meshes,
)
from elastomorph.io.gltf.rig_extras import corrective_entries, least_version
from elastomorph.io.untrusted import naming_file
from elastomorph.rig import Rig


def standalone(file: GltfFile) -> GltfFile:
    """A file with everything inside; itself where it is so.

    Raises:
        ElastomorphError: Bytes of its meshes are not to be had. An image that is not is left out.
    """
    entries = [own for kind in ("buffers", "images") for own in file.items(kind)]
    if file.is_glb and not any(isinstance(own, dict) and "uri" in own for own in entries):
        return file
    document, chunk = copy.deepcopy(file.document), bytearray()
    _take_buffers(file, document, chunk)
    _take_images(file, document, chunk)
    if chunk:
        document["buffers"][0]["byteLength"] = len(chunk)
    content = bytes(chunk) if chunk else None
    return GltfFile(file.path, document, content, file.size + len(chunk), file.rest or b"")


def _take_buffers(file: GltfFile, document: dict[str, Any], chunk: bytearray) -> None:
    """Put all buffers that have bytes into one; those that are announced alone follow it."""
    starts: dict[int, tuple[int, int]] = {}  # of each buffer: its number, and where it begins
    others: list[dict[str, Any]] = []
    for number in range(len(file.items("buffers"))):
        entry = file.item("buffers", number, "the document")
        if "uri" in entry or (number == 0 and file.chunk is not None):
            chunk += bytes(-len(chunk) % 8)
            starts[number] = 0, len(chunk)
            chunk += file.buffer(number)
        else:
            others.append(entry)
            starts[number] = len(others), 0
    document["buffers"] = [{"byteLength": len(chunk)}, *others]
    for number in range(len(file.items("bufferViews"))):
        file.item("bufferViews", number, "the document")
        view = document["bufferViews"][number]
        packed = file.object_in(view, "extensions", f"buffer view {number}")
        places = [view, *(packed[name] for name in MESHOPT if isinstance(packed.get(name), dict))]
        for place in places:
            of = f"buffer view {number}"
            own = file.whole_in(place, "buffer", of)
            if own not in starts:
                file.refuse(f"{of} names a buffer that does not exist")
            place["buffer"], start = starts[own]
            place["byteOffset"] = start + file.whole_in(place, "byteOffset", of, default=0)


def _take_images(file: GltfFile, document: dict[str, Any], chunk: bytearray) -> None:
    """Put images in too, each once; what cannot be had is an image without bytes."""
    views: dict[str, tuple[int, str | None]] = {}
    for number, image in enumerate(file.items("images")):
        uri = image.get("uri") if isinstance(image, dict) else None
        if not isinstance(uri, str):
            continue
        entry = document["images"][number]
        del entry["uri"]
        if uri not in views:
            try:
                content = file.uri_content(uri, f"image {number}")
            except ElastomorphError:
                continue
            chunk += bytes(-len(chunk) % 8)
            place = {"buffer": 0, "byteOffset": len(chunk), "byteLength": len(content)}
            chunk += content
            own = document.setdefault("bufferViews", [])
            own.append(place)
            views[uri] = len(own) - 1, image_kind(content)
        entry["bufferView"], kind = views[uri]
        if kind is not None:
            entry["mimeType"] = kind


def showing_only(file: GltfFile, nodes: Collection[int | None]) -> GltfFile:
    """A file whose other nodes show no mesh; what moved the weights of those is left out.

    Raises:
        FormatError: What is to be shown is in no node.
    """
    if None in nodes:
        file.refuse("no node of its scene shows the meshes that were named")
    document = copy.deepcopy(file.document)
    emptied = set()
    for number, node in enumerate(document["nodes"]):
        if isinstance(node, dict) and "mesh" in node and number not in nodes:
            emptied.add(number)
            for key in ("mesh", "skin", "weights"):
                node.pop(key, None)
    animations = []
    for animation in file.list_in(document, "animations", "the document"):
        if isinstance(animation, dict) and isinstance(animation.get("channels"), list):
            own = animation["channels"]
            animation["channels"] = [each for each in own if not _moves(each, emptied)]
            if own and not animation["channels"]:
                continue
        animations.append(animation)
    document.pop("animations", None)
    if animations:
        document["animations"] = animations
    return GltfFile(file.path, document, file.chunk, file.size, file.rest)


def _moves(channel: Any, nodes: Collection[int]) -> bool:
    """Whether a channel of an animation moves weights of some nodes."""
    target = channel.get("target") if isinstance(channel, dict) else None
    if not isinstance(target, dict):
        return False
    if target.get("path") != "pointer":
        return target.get("path") == "weights" and target.get("node") in nodes
    extensions = target.get("extensions")
    own = extensions.get(POINTER) if isinstance(extensions, dict) else None
    pointer = own.get("pointer") if isinstance(own, dict) else None
    parts = pointer.split("/") if isinstance(pointer, str) else []
    named = parts[1:2] == ["nodes"] and parts[3:4] == ["weights"] and parts[2].isdecimal()
    return named and len(parts[2]) < 10 and int(parts[2]) in nodes


@dataclass(frozen=True, eq=False)
class OpenedCharacter:
    """A .glb, .vrm or .gltf file, or some meshes of it.

    Attributes:
        file: Its document and buffers.
        names: Of the meshes that are meant; all that its scene shows where there are none.
        meshes: What was read of them.
        rig: What they are together, as `elastomorph.io.gltf.read_glb` gives it.
    """

    file: GltfFile
    names: tuple[str, ...]
    meshes: tuple[ReadMesh, ...]
    rig: Rig

    @classmethod
    def of(cls, file: GltfFile, names: Sequence[str] = ()) -> OpenedCharacter:
        """The meshes of these names in a file that is open.

        Raises:
            FormatError: It is damaged, or has no mesh of a name.
        """
        meshes, rig = _read(file, names)
        return cls(file, tuple(names), tuple(meshes), rig)

    def glb(self, rig: Rig) -> bytes:
        """The file as one of chunks with everything inside, in memory, with the paths of a rig.

        Args:
            rig: The rig of the file with other paths, and with groups and correctives of its own.

        Raises:
            ElastomorphError: The file was bent by others, a part of it is missing, or the rig is
                not that of these meshes.
        """
        with of_bounded_depth(self.file.path):
            face, character = self._face, self._character
            pairs = rig.pair_bends()
            own, given = (
                (len(r.neutral.vertices), [name for name in r.morphs if name not in pairs])
                for r in (face.rig, rig)
            )
            if own != given:
                raise FormatError(self.file.path, "the rig is not that of its meshes")
            document, chunk = character.file.document, character.chunk
            if any(len(morph.bends) for morph in rig.morphs.values()):
                welding = face.welding
                with naming_file(self.file.path):
                    morphs = {name: welding.welded(morph) for name, morph in rig.morphs.items()}
                plan = make_plan(Rig(welding.neutral, morphs, correctives=pairs))
                edit = CharacterEdit(character, face, plan, FEWEST)
                edit.add_bends(lambda _: None)
                edit.add_clips(KEYS_TOLERANCE, lambda _: None)
                document, chunk = edit.glb()
            return written_glb(character, _with_sliders(document, face, rig), chunk)

    @cached_property
    def _character(self) -> Character:
        """What the page is handed, without the bends that were in it: numbers are as in the file.

        Other meshes than those that are meant are in it still, but no node shows them.
        """
        whole = Character.of(self.file)
        own = whole.file
        if self.names:
            with naming_file(own.path):
                own = showing_only(own, {each.node for each in wanted_meshes(own, self.names)})
        own = standalone(own)
        own.draco = None if whole.was_bent else self.file.draco
        return replace(whole, file=own)

    @cached_property
    def _face(self) -> Face:
        own = self._character
        if own.was_bent:
            return Face.of(own.file, *_read(own.file, self.names))
        return Face.of(own.file, self.meshes, self.rig)


def _read(file: GltfFile, names: Sequence[str]) -> tuple[Sequence[ReadMesh], Rig]:
    require_known_extensions(file)
    with naming_file(file.path):
        meshes = read_meshes(file, wanted_meshes(file, names))
        return meshes, rig_of(file, meshes)


def _with_sliders(document: dict[str, Any], face: Face, rig: Rig) -> dict[str, Any]:
    """A document whose meshes have the groups and correctives of a rig, in place of the file's.

    Pair bends are there with their bends.
    """
    known, sliders, pairs = face.rig.sliders, rig.sliders, rig.pair_bends()
    correctives = {n: own for n, own in sliders.correctives.items() if n not in pairs}
    if (known.correctives, known.groups) == (correctives, sliders.groups):
        return document
    meshes = list(document["meshes"])
    holders = {mesh.number: _described(meshes[mesh.number], mesh) for mesh in face.meshes}
    for entry in holders.values():
        entry["groups"] = []
        entry["correctives"] = [c for c in entry.get("correctives", []) if c["name"] in pairs]
    for own in corrective_entries(correctives):
        _holder(face, holders, {own["name"], *own["drivers"]})["correctives"].append(own)
    wholes = [entry["whole"] for entry in holders.values() if "whole" in entry]
    groups = [{"name": name, "members": [*own]} for name, own in sliders.groups.items()]
    if wholes:  # one surface, of which each mesh has some sliders
        wholes[0]["groups"] = groups
    for group in groups if not wholes else []:
        _holder(face, holders, {*group["members"]})["groups"].append(group)
    for number, entry in holders.items():
        entry["version"] = max(entry["version"], least_version([], entry["correctives"]))
        extras = {**meshes[number].get("extras", {}), "elastomorph": entry}
        meshes[number] = {**meshes[number], "extras": extras}
    return {**document, "meshes": meshes}


def _described(entry: Mapping[str, Any], mesh: FaceMesh) -> dict[str, Any]:
    """What a mesh says of its paths; that they are straight where it says nothing."""
    stored = entry.get("extras", {}).get("elastomorph")
    if isinstance(stored, dict):
        return copy.deepcopy(stored)
    straight = {"method": "linear", "bake_error": 0.0, "choice": None, "bends": []}
    named = [{"name": mesh.morph_of.get(name, name), "target": name} for name in mesh.names]
    return {"version": 1, "morphs": [own | straight for own in named]}


def _holder(face: Face, holders: Mapping[int, dict[str, Any]], names: set[str]) -> dict[str, Any]:
    """What the first mesh that has all sliders of some names says: there they are understood."""
    for mesh in face.meshes:
        if names <= {mesh.morph_of.get(name, name) for name in mesh.names}:
            return holders[mesh.number]
    raise FormatError(face.file.path, "no mesh has all sliders of a group")
