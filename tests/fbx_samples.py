"""FBX files made for tests, as text and as binary, from one description of a scene."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np


@dataclass
class Named:
    """An object's name with its class, which text and binary write differently."""

    kind: str
    name: str


@dataclass
class Element:
    name: str
    values: Sequence[Any] = ()
    children: Sequence[Element] = ()


@dataclass
class Shape:
    """A shape at a full weight in percent: offsets of some vertices."""

    vertices: Sequence[int]
    offsets: Sequence[Sequence[float]]
    full_weight: float = 100.0
    name: str = ""


@dataclass
class Model:
    """A node with a mesh (or none), its transform and its channels."""

    name: str
    vertices: Sequence[Sequence[float]] = ()
    polygons: Sequence[Sequence[int]] = ()
    channels: dict[str, Sequence[Shape]] = field(default_factory=dict)
    deformer: str = "blendShape1"
    translation: Sequence[float] = (0, 0, 0)
    rotation: Sequence[float] = (0, 0, 0)
    scaling: Sequence[float] = (1, 1, 1)
    shown: bool = True
    children: Sequence[Model] = ()
    lod_group: bool = False
    uv: tuple[Sequence[Sequence[float]], Sequence[int]] | None = None
    materials: tuple[Sequence[str], Sequence[int]] | None = None
    vertex_weights: dict[str, Sequence[float]] = field(default_factory=dict)


def quad(**settings: Any) -> Model:
    """A face of one quad in the plane z = 0.5, whose shape lifts one corner."""
    lift = {"blendShape1.lift": [Shape([2], [[0.25, 0.5, -0.125]], name="lift")]}
    return Model(
        **{
            "name": "face",
            "vertices": [[0, 0, 0.5], [1, 0, 0.5], [1, 2, 0.5], [0, 2, 0.5]],
            "polygons": [[0, 1, 2, 3]],
            "channels": lift,
            **settings,
        }
    )


Y_UP = {
    "UpAxis": 1,
    "UpAxisSign": 1,
    "FrontAxis": 2,
    "FrontAxisSign": 1,
    "CoordAxis": 0,
    "CoordAxisSign": 1,
}
Z_UP = {
    "UpAxis": 2,
    "UpAxisSign": 1,
    "FrontAxis": 1,
    "FrontAxisSign": -1,
    "CoordAxis": 0,
    "CoordAxisSign": 1,
}


def scene(*models: Model, axes: dict[str, int] = Y_UP, creator: str = "") -> list[Element]:
    """The elements of a file with these nodes."""
    return _Scene(axes).of(models, creator)


class _Scene:
    def __init__(self, axes: dict[str, int]) -> None:
        self.axes = axes
        self.objects: list[Element] = []
        self.links: list[Element] = []
        self.last = 1000

    def of(self, models: Sequence[Model], creator: str) -> list[Element]:
        for model in models:
            self.model(model, 0)
        settings = [_p(name, "int", "Integer", "", value) for name, value in self.axes.items()]
        return [
            Element(
                "FBXHeaderExtension",
                (),
                [Element("FBXVersion", [7400]), Element("Creator", [creator])],
            ),
            Element("GlobalSettings", (), [Element("Properties70", (), settings)]),
            Element("Objects", (), self.objects),
            Element("Connections", (), self.links),
        ]

    def add(
        self, element: str, kind: str, name: str, sub: str, parent: int, *children: Element
    ) -> int:
        self.last += 1
        self.objects.append(Element(element, [self.last, Named(kind, name), sub], children))
        self.links.append(Element("C", ["OO", self.last, parent]))
        return self.last

    def model(self, model: Model, parent: int) -> None:
        vectors = {
            "Lcl Translation": model.translation,
            "Lcl Rotation": model.rotation,
            "Lcl Scaling": model.scaling,
        }
        properties = [_p(k, k, "", "A", *map(float, v)) for k, v in vectors.items()]
        properties.append(_p("Visibility", "Visibility", "", "A", float(model.shown)))
        properties.append(_p("InheritType", "enum", "", "", 1))
        sub = "Mesh" if len(model.vertices) else "LodGroup" if model.lod_group else "Null"
        own = self.add(
            "Model", "Model", model.name, sub, parent, Element("Properties70", (), properties)
        )
        if model.lod_group:
            self.add("NodeAttribute", "NodeAttribute", "", "LodGroup", own)
        if len(model.vertices):
            self.mesh(model, own)
        for child in model.children:
            self.model(child, own)

    def mesh(self, model: Model, node: int) -> None:
        indices = [i for p in model.polygons for i in (*p[:-1], ~p[-1])]
        layers = []
        if model.uv is not None:
            layers.append(
                _layer(
                    "LayerElementUV",
                    "ByPolygonVertex",
                    "IndexToDirect",
                    Element("UV", [np.array(model.uv[0], float).ravel()]),
                    Element("UVIndex", [np.array(model.uv[1], np.int32)]),
                )
            )
        if model.materials is not None:
            layers.append(
                _layer(
                    "LayerElementMaterial",
                    "ByPolygon",
                    "IndexToDirect",
                    Element("Materials", [np.array(model.materials[1], np.int32)]),
                )
            )
            for name in model.materials[0]:
                self.add("Material", "Material", name, "", node)
        geometry = self.add(
            "Geometry",
            "Geometry",
            "",
            "Mesh",
            node,
            Element("Vertices", [np.array(model.vertices, float).ravel()]),
            Element("PolygonVertexIndex", [np.array(indices, np.int32)]),
            *layers,
        )
        if not model.channels:
            return
        deformer = self.add("Deformer", "Deformer", model.deformer, "BlendShape", geometry)
        for name, shapes in model.channels.items():
            weights = model.vertex_weights.get(name, [shape.full_weight for shape in shapes])
            channel = self.add(
                "Deformer",
                "SubDeformer",
                name,
                "BlendShapeChannel",
                deformer,
                Element("DeformPercent", [0.0]),
                Element("FullWeights", [np.array(weights, float)]),
            )
            for shape in shapes:
                self.add(
                    "Geometry",
                    "Geometry",
                    shape.name,
                    "Shape",
                    channel,
                    Element("Indexes", [np.array(shape.vertices, np.int32)]),
                    Element("Vertices", [np.array(shape.offsets, float).ravel()]),
                )


def _p(*values: Any) -> Element:
    return Element("P", values)


def _layer(name: str, mapping: str, reference: str, *arrays: Element) -> Element:
    return Element(
        name,
        [0],
        [
            Element("MappingInformationType", [mapping]),
            Element("ReferenceInformationType", [reference]),
            *arrays,
        ],
    )


def as_text(elements: Sequence[Element]) -> bytes:
    """ASCII FBX 7.4."""
    return ("; FBX 7.4.0 project file\n" + "".join(_text(e, "") for e in elements)).encode()


def _text(element: Element, indent: str) -> str:
    children = "".join(_text(child, indent + "\t") for child in element.children)
    if element.values and isinstance(element.values[0], np.ndarray):
        array = element.values[0]
        numbers = ",".join(repr(number) for number in array.tolist())
        return f"{indent}{element.name}: *{array.size} {{\n{indent}\ta: {numbers}\n{indent}}}\n"
    line = f"{indent}{element.name}: " + ", ".join(_word(value) for value in element.values)
    if children or not element.values:
        return f"{line} {{\n{children}{indent}}}\n"
    return line + "\n"


def _word(value: Any) -> str:
    if isinstance(value, Named):
        return f'"{value.kind}::{value.name}"'
    return f'"{value}"' if isinstance(value, str) else repr(value)


def as_binary(elements: Sequence[Element]) -> bytes:
    """Binary FBX 7.4; long arrays are compressed, as programs do."""
    content = b"Kaydara FBX Binary  \x00\x1a\x00" + struct.pack("<I", 7400)
    for element in elements:
        content += _binary(element, len(content))
    return content + bytes(13) + bytes(160)


def _binary(element: Element, start: int) -> bytes:
    values = b"".join(_value(value) for value in element.values)
    name = element.name.encode()
    body = struct.pack("<B", len(name)) + name + values
    for child in element.children:
        body += _binary(child, start + 12 + len(body))
    if element.children or not element.values:
        body += bytes(13)
    head = struct.pack("<III", start + 12 + len(body), len(element.values), len(values))
    return head + body


def _value(value: Any) -> bytes:
    if isinstance(value, np.ndarray):
        raw = value.astype(value.dtype.newbyteorder("<")).tobytes()
        packed = zlib.compress(raw) if len(raw) > 128 else raw
        kind = {"f": b"d", "i": b"i"}[value.dtype.kind]
        return kind + struct.pack("<III", value.size, int(packed is not raw), len(packed)) + packed
    if isinstance(value, Named):
        return _value(f"{value.name}\x00\x01{value.kind}")
    if isinstance(value, str):
        return b"S" + struct.pack("<I", len(value.encode())) + value.encode()
    return (
        b"D" + struct.pack("<d", value)
        if isinstance(value, float)
        else b"L" + struct.pack("<q", value)
    )
