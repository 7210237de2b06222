"""The built-in head: ICT-FaceKit's, packed by ``tools/make_head.py``, with materials of our own.

Positions are whole multiples of a power of two of a centimetre, so they are the same bits on every
processor: of the neutral within 2e-6 of D of ICT-FaceKit's, of shapes within 2e-5.
"""

from __future__ import annotations

import zipfile
import zlib
from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from importlib.resources import files
from importlib.resources.abc import Traversable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import FormatError
from elastomorph.model.bend_curve import BendCurve
from elastomorph.model.mesh import FaceLabels, Finish, Material, Mesh, Opacity, Texture, UVMap
from elastomorph.model.morph import Choice, Morph
from elastomorph.model.polygons import Polygons
from elastomorph.model.sequence import MeshSequence
from elastomorph.rig import Rig
from elastomorph.rig.laws import Corrective
from elastomorph.samples.paper_expressions import compose_expressions

# What the parts of the built-in head look like, in plain glTF terms: no extension is needed.

IMAGES = (
    "skin.jpg", "shine.png", "eye.jpg", "mouth.jpg", "teeth.jpg", "lashes.png", "shadow.png",
)  # fmt: skip
"""The files of the images, which ``tools/paint_head.py`` paints."""

SKIN = (204, 158, 136)
"""Red, green and blue of a screen, to which painted skin fades at the back of the head."""


def materials(images: Mapping[str, bytes]) -> dict[str, Material]:
    """The looks of the head's materials by name, of the content of `IMAGES`.

    Irises are painted on the ``sclera``, the shell that bulges as a cornea does.
    """
    textures = {name.partition(".")[0]: Texture(content, name) for name, content in images.items()}

    def painted(
        name: str, roughness: float, opacity: Opacity = "opaque", double_sided: bool = False
    ) -> Material:
        texture, finish = textures[name], Finish(roughness)
        return Material(texture=texture, opacity=opacity, double_sided=double_sided, finish=finish)

    lit = Finish(layers={"finish": textures["shine"], "creases": textures["shine"]})
    return {
        "skin": Material(texture=textures["skin"], finish=lit),
        "head": replace(_plain(SKIN, 0.58), double_sided=True),  # open below
        "mouth": _plain((72, 25, 23), 0.7),
        "gums": painted("mouth", 0.5),
        "tongue": painted("mouth", 0.5),
        "teeth": painted("teeth", 0.22),
        "sclera": painted("eye", 0.06),
        "occlusion": painted("shadow", 1.0, "blend"),
        "lashes": painted("lashes", 0.8, "blend", double_sided=True),
    }


def _plain(shown: tuple[int, int, int], roughness: float) -> Material:
    """One colour, told as a screen shows it."""
    red, green, blue = (
        part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4
        for part in (value / 255 for value in shown)
    )
    return Material((red, green, blue, 1.0), finish=Finish(roughness))


COPYRIGHT = (
    "Head and shapes: ICT-FaceKit, (c) 2020 USC Institute for Creative Technologies, MIT License. "
    "Tongue, materials and motion: elastomorph, MIT License."
)
_VERSION = 1


@cache
def head() -> Mesh:
    """The built-in neutral head, the same on every call.

    23,979 vertices, mostly quads, centimetres, +Y up, +Z out of the face, in the order of
    ICT-FaceKit: without the inner eyeballs and the shells of the eyes that
    only an engine's own shaders use. The left side of the character is +x. Materials and
    polygon groups name skin, mouth, teeth, gums, tongue, eyes and lashes, groups the lips too.

    Raises:
        FormatError: The installed file is damaged or of another version.
    """
    stored = _stored("neutral")
    corners, sizes = np.cumsum(stored["corners"]), stored["sizes"]
    polygons = Polygons(corners, np.append(0, np.cumsum(sizes, dtype=np.int64)))
    uv = UVMap(
        stored["coordinates"] * stored["coordinate_unit"],
        np.cumsum(stored["coordinate_corners"]).astype(np.int32),
    )
    return Mesh(
        stored["neutral"] * stored["unit"],
        polygons,
        uv=uv,
        materials=_labels(stored, "material"),
        groups=_labels(stored, "group"),
        appearance=materials({name: _file(name).read_bytes() for name in IMAGES}),
        copyright=COPYRIGHT,
    )


def shapes() -> dict[str, Mesh]:
    """The 52 shapes of ARKit, each at full strength, by ARKit's names and in its order.

    ``tongueOut`` is of our own, and so are eyeballs that turn, by 24° up, 27° down and 32° to the
    sides; the others are ICT-FaceKit's. Of ``browInnerUp`` and ``cheekPuff`` it has halves, which
    are added up. "Left" is the character's left, +x.

    Raises:
        FormatError: The installed file is damaged or of another version.
    """
    return dict(_moved("shapes"))


def expressions() -> dict[str, Mesh]:
    """The five expressions of the paper on the built-in head, sums of weighted shapes.

    Returns:
        "sad", "angry", "confused", "grinning" and "puff", with the topology of ``head()``.
    """
    return dict(_expressions())


@cache
def recorded_motion() -> MeshSequence:
    """Eleven poses of the head, from the neutral into a wide laugh, at times 0, 0.1, … 1.

    Made of anatomy, not of equations of motion, by ``tools/record_motion.py``: the lower teeth turn
    rigidly about a hinge that glides, lids turn about the centre of the eyeball, corners of the
    mouth slide around the teeth, each part at its own time. The first frame is ``head()``, bit for
    bit.

    Raises:
        FormatError: The installed file is damaged or of another version.
    """
    neutral = head()
    frames = [neutral, *_moved("motion").values()]
    return MeshSequence(
        neutral, np.stack([each.vertices for each in frames]), np.arange(len(frames)) / 10.0
    )


def landmarks() -> tuple[int, ...]:
    """The vertices of the 68 points that face trackers number, in their order."""
    return tuple(_stored("neutral")["landmarks"].tolist())


@cache
def _expressions() -> dict[str, Mesh]:
    return compose_expressions(head(), shapes())


@cache
def built_in_rig() -> Rig:
    """The head, its shapes and expressions, each with the path that ``auto`` takes to it.

    Behind them are the pair bends of those that meet.

    Raises:
        FormatError: The installed file is damaged or of another version.
    """
    neutral, stored = head(), _stored("paths")
    targets = {**shapes(), **expressions()}
    bends = np.stack([*_moves(stored).values()])
    curves = [BendCurve.polynomial(row) for row in stored["curves"]]
    pairs = {"_".join(pair): Corrective(tuple(pair), "min") for pair in stored["pairs"].tolist()}
    morphs, start = {}, 0
    for name, count, method, error, choice in zip(
        (*targets, *pairs),
        stored["bends"].tolist(),
        stored["methods"].tolist(),
        stored["errors"].tolist(),
        stored["choices"].tolist(),
        strict=True,
    ):
        distance, allowed, exact, shrunk, hidden, eased, crossing, *depths = choice
        counts = int(shrunk), int(hidden), int(eased), int(crossing)
        morphs[name] = Morph(
            neutral,
            targets.get(name, neutral),
            bends[start : start + count],
            tuple(curves[start : start + count]),
            method,
            bake_error=error,
            choice=Choice(distance, allowed, bool(exact), *counts, *depths),
        )
        start += count
    return Rig(neutral, morphs, correctives=pairs)


@cache
def _moved(name: str) -> dict[str, Mesh]:
    """Meshes of a file, by name: the head with some of its vertices displaced."""
    neutral, moves = head(), _moves(_stored(name))
    return {key: neutral.with_vertices(neutral.vertices + move) for key, move in moves.items()}


def _moves(stored: Mapping[str, NDArray[Any]]) -> dict[str, NDArray[np.float64]]:
    """(V, 3) displacements by name."""
    found, start = {}, 0
    for name, count in zip(stored["names"].tolist(), stored["counts"].tolist(), strict=True):
        steps = stored["deltas"][3 * start : 3 * (start + count)].reshape(3, count)
        found[name] = np.zeros(head().vertices.shape)
        # Stored as the change from one vertex to the next, in 16 bits that wrap around.
        moves = np.cumsum(steps, axis=1, dtype=np.int16).T
        found[name][stored["rows"][start : start + count]] = moves * stored["unit"]
        start += count
    return found


def _labels(stored: Mapping[str, NDArray[Any]], kind: str) -> FaceLabels:
    names = tuple(stored[f"{kind}_names"].tolist())
    return FaceLabels(names, stored[f"{kind}_of_polygon"].astype(np.int32))


def _file(name: str) -> Traversable:
    return files("elastomorph.samples").joinpath(name)


@cache
def _stored(name: str) -> dict[str, NDArray[Any]]:
    """The arrays of a file."""
    source = _file(f"{name}.npz")
    try:
        with source.open("rb") as file, np.load(file, allow_pickle=False) as arrays:
            stored = {key: arrays[key] for key in arrays.files}
    except (OSError, ValueError, EOFError, KeyError, zipfile.BadZipFile, zlib.error) as error:
        raise FormatError(
            str(source), f"the built-in head is damaged ({error}); install elastomorph again"
        ) from error
    if int(stored.get("version", 0)) != _VERSION:
        raise FormatError(
            str(source),
            f"the built-in head is of version {int(stored.get('version', 0))}, expected "
            f"{_VERSION}; install elastomorph again",
        )
    return stored
