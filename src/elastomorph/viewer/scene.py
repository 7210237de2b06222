"""What a viewer page shows: models with one set of vertices, and what is known beside them."""

from __future__ import annotations

import json
import math
import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, Literal

from elastomorph.curves import CurveNetwork
from elastomorph.errors import ParameterError

Role = Literal["rig", "method", "truth"]
ROLES: tuple[Role, ...] = ("rig", "method", "truth")

# The parts of the page's state that a scene may begin with.
START = (
    "weights", "t", "correctivesOff", "mirror", "arrangement", "shown", "swipe", "ghost", "onion",
    "orbits", "picked", "grab", "pins", "heat", "against", "heatTop", "wireframe", "loops",
    "shading", "light", "headTurns", "theme", "playing", "repeat", "timing", "seconds", "clip",
    "clipTime", "live", "poses", "favourites", "folded", "takes", "range", "speed", "soundOffsets",
    "methods",
)  # fmt: skip


@dataclass(frozen=True, eq=False, repr=False)
class SceneModel:
    """One face of a scene.

    Attributes:
        name: What the page calls it.
        role: ``rig`` alone, or a ``method`` beside others, or the ``truth`` they are compared with.
        glb: A GLB file.

    Raises:
        ParameterError: An unknown role, or bytes that are no GLB file.
    """

    name: str
    role: Role
    glb: bytes
    vertices: int = field(init=False)

    def __post_init__(self) -> None:
        if self.role not in ROLES:
            raise ParameterError(f"role must be one of {', '.join(ROLES)}, found {self.role!r}")
        object.__setattr__(self, "vertices", _vertices(self.name, self.glb))

    def __repr__(self) -> str:
        return f"SceneModel({self.name!r}, {self.role}, {len(self.glb):,} bytes)"


@dataclass(frozen=True, eq=False, repr=False)
class Scene:
    """Models to look at, together.

    Attributes:
        models: One model, or several with the same vertices to be compared.
        title: What the page is called.
        unit: Unit of the coordinates for legends, or an empty string.
        diameter: D in that unit; None where the page may find it by itself.
        curves: Curves on the models, drawn as loops.
        start: What the page begins with, by the names in `START`: weights of the sliders,
            ``t``, ``arrangement`` (single, side, swipe), numbers of the models ``shown``, ….
        name: Of the rig, by whatever methods it is shown: what the browser keeps its poses under.
            The title by default.

    Raises:
        ParameterError: No models, models with different vertices, or an unknown name in the start.
    """

    models: tuple[SceneModel, ...]
    title: str
    unit: str = ""
    diameter: float | None = None
    curves: CurveNetwork | None = None
    start: Mapping[str, Any] = field(default_factory=dict)
    name: str = ""

    def __post_init__(self) -> None:
        if not self.models:
            raise ParameterError("there is nothing to show: a scene needs at least one model")
        first = self.models[0]
        for model in self.models[1:]:
            if model.vertices != first.vertices:
                raise ParameterError(
                    f"{model.name!r} has {model.vertices:,} vertices in its file, {first.name!r} "
                    f"has {first.vertices:,}: only models of one neutral can be compared. Look at "
                    "them one at a time, or export both from the same neutral"
                )
        for name in self.start:
            if name not in START:
                raise ParameterError(f"a view has no {name!r}; it has {', '.join(START)}")
        object.__setattr__(self, "models", tuple(self.models))
        object.__setattr__(self, "start", MappingProxyType(dict(self.start)))

    @property
    def size(self) -> int:
        """Bytes of the models together."""
        return sum(len(model.glb) for model in self.models)

    def to_json(self, addresses: Sequence[str], services: Mapping[str, str] | None = None) -> str:
        """The scene as the page reads it, strict JSON, with an address of each GLB file.

        Services are addresses too: of what the page may ask of the command that shows it.
        """
        found: dict[str, Any] = {
            "version": 1,
            "title": self.title,
            "unit": self.unit,
            "models": [
                {"name": model.name, "role": model.role, "glb": address}
                for model, address in zip(self.models, addresses, strict=True)
            ],
        }
        if self.diameter is not None and math.isfinite(self.diameter) and self.diameter > 0:
            found["diameter"] = self.diameter
        if self.curves is not None:
            found["loops"] = [
                {"closed": curve.closed, "vertices": curve.vertices.tolist()}
                for curve in self.curves
                if len(curve) > 1
            ]
        if self.name:
            found["name"] = self.name
        if self.start:
            found["start"] = dict(self.start)
        if services:
            found["services"] = dict(services)
        try:
            return json.dumps(found, allow_nan=False, separators=(",", ":"))
        except (TypeError, ValueError) as error:
            raise ParameterError(f"the start of a view must be plain JSON: {error}") from None

    def __repr__(self) -> str:
        names = ", ".join(model.name for model in self.models)
        return f"Scene({self.title!r}: {names}; {self.size:,} bytes)"


def _vertices(name: str, glb: bytes) -> int:
    """Vertices in a GLB file, copies at texture seams included."""
    try:
        magic, _, _, length, kind = struct.unpack_from("<4s4I", glb)
        if magic != b"glTF" or kind != 0x4E4F534A:
            raise ValueError("it does not begin like one")
        document = json.loads(glb[20 : 20 + length])
        # Primitives of one mesh may share their vertices.
        positions = {
            part["attributes"]["POSITION"]
            for mesh in document.get("meshes", [])
            for part in mesh["primitives"]
        }
        return sum(int(document["accessors"][number]["count"]) for number in positions)
    except (struct.error, ValueError, LookupError, TypeError, AttributeError, RecursionError):
        raise ParameterError(
            f"the model {name!r} is no GLB file, or a damaged one: expected glTF 2.0 in binary "
            "form with a mesh"
        ) from None
