"""Documents whose primitives are packed with Draco, made from plain ones."""

from __future__ import annotations

from typing import Any

import numpy as np
from glb_samples import CORNERS, MOVED, SQUARE, HandMade

import needs

needs.installed("DracoPy", "gltf")
NAME = "KHR_draco_mesh_compression"


def draco_square(**options: Any) -> HandMade:
    """The square with a morph target and texture coordinates, its vertices as Draco orders them.

    The target is plain, and moves the corners (1, 0) and (1, 1) wherever Draco put them.
    """
    stream = packed_square(**options)
    file = HandMade()
    number = file.view(stream)
    places = corners_in(stream)
    moved = np.zeros((4, 3))
    moved[[places[1, 0], places[1, 1]]] = MOVED[1:3]
    shown = {
        "POSITION": file.accessor(componentType=5126, count=4, type="VEC3"),
        "TEXCOORD_0": file.accessor(componentType=5126, count=4, type="VEC2"),
    }
    file.primitive(
        attributes=shown,
        indices=file.accessor(componentType=5123, count=6, type="SCALAR"),
        targets=[{"POSITION": file.array(moved)}],
        extensions={NAME: {"bufferView": number, "attributes": numbers_in(stream)}},
    )
    file.document["extensionsUsed"] = file.document["extensionsRequired"] = [NAME]
    return file


def packed_square(**options: Any) -> bytes:
    """A stream of Draco: 14 bits a coordinate, unless options say otherwise."""
    import DracoPy

    corners = np.array(CORNERS).reshape(-1, 3)
    texture = SQUARE[:, :2].copy()
    stream: bytes = DracoPy.encode(
        SQUARE, corners, tex_coord=texture, **{"quantization_bits": 14} | options
    )
    return stream


def numbers_in(stream: bytes) -> dict[str, int]:
    """The numbers of the attributes of a stream, by what they are in glTF."""
    import DracoPy

    names = {0: "POSITION", 3: "TEXCOORD_0"}
    found = DracoPy.decode(stream).attributes
    return {
        names[own["attribute_type"]]: own["unique_id"]
        for own in found
        if own["attribute_type"] in names
    }


def corners_in(stream: bytes) -> dict[tuple[int, int], int]:
    """The numbers that Draco gives to the corners of the square."""
    import DracoPy

    points = np.rint(DracoPy.decode(stream).points)
    return {(int(x), int(y)): number for number, (x, y, _) in enumerate(points)}
