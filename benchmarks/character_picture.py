"""A textured character before and after its paths are bent: the picture of the documentation.

Run:  python benchmarks/character_picture.py [--picture docs/character.png]

The character is the built-in head with an image on it, painted here. It is written as other
programs write one, without bends, bent in its own file by `elastomorph.bend`, and read back.
"""

from __future__ import annotations

import argparse
import tempfile
from io import BytesIO
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import elastomorph as em
from elastomorph.bending import bend
from elastomorph.draw import Stage, camera_for, heat_colours, picture_grid, write_picture
from elastomorph.draw.pictures import ColourScale, as_pillow, round_up
from elastomorph.io.gltf import read_glb, write_glb
from elastomorph.model.appearance import Material, Texture
from elastomorph.model.mesh import FaceLabels, Mesh, UVMap
from elastomorph.samples import head, shapes

MOVED = ("jawOpen", "eyeBlink_L", "eyeBlink_R")
SHOWN = {"jawOpen": 0.5, "eyeBlink_L": 0.5, "eyeBlink_R": 0.5}
SIZE = (340, 425)
PIXELS = 1024
PLAIN = {  # sRGB of the parts that have no image
    "brows": (70, 45, 32),
    "lashes": (42, 28, 24),
    "mouth": (96, 40, 40),
    "nostrils": (92, 52, 44),
    "gums": (190, 105, 105),
    "teeth": (240, 234, 220),
    "tongue": (190, 100, 98),
    "pupil": (10, 10, 12),
    "iris": (66, 98, 74),
    "eye": (236, 232, 228),
}


def character() -> em.Rig:
    """The built-in head in its own looks, on straight paths."""
    bare = head()
    labels = bare.groups
    assert labels is not None
    x, y, z = bare.vertices.T
    # Round the head, both sides alike, so that the image has no seam.
    round_the_head = np.abs(np.arctan2(x, z)) / np.pi
    places = np.stack([round_the_head, (y - y.min()) / np.ptp(y)], axis=1)
    names = tuple(labels.names)
    mesh = Mesh(
        bare.vertices,
        bare.faces,
        uv=UVMap(places, bare.faces.indices.astype(np.int32)),
        materials=FaceLabels(names, labels.of_face),
        appearance={name: _material(name) for name in names},
    )
    every = shapes()
    targets = {name: mesh.with_vertices(every[name].vertices) for name in MOVED}
    return em.Rig(mesh, targets, method="linear")


def _material(name: str) -> Material:
    colour = PLAIN.get(name.partition("_")[0])
    if colour is None:
        return Material(texture=_skin(lips=name == "lips"), double_sided=True)
    red, green, blue = (_linear(part / 255) for part in colour)
    return Material((red, green, blue, 1.0), double_sided=True)


def _linear(shown: float) -> float:
    return shown / 12.92 if shown <= 0.04045 else ((shown + 0.055) / 1.055) ** 2.4


def _skin(*, lips: bool) -> Texture:
    """Skin with freckles and warm cheeks, the front of the face on the left; or that of lips."""
    random = np.random.default_rng(7)
    x, y = np.meshgrid(np.linspace(0, 1, PIXELS), np.linspace(1, 0, PIXELS))
    colour = np.ones((PIXELS, PIXELS, 3)) * ((178, 84, 82) if lips else (222, 176, 150))
    mottle = np.kron(random.normal(size=(64, 64)), np.ones((PIXELS // 64, PIXELS // 64)))
    colour += 2.5 * _blurred(mottle, 24)[..., None]
    if not lips:
        warm = np.exp(-(((x - 0.18) / 0.08) ** 2) - ((y - 0.56) / 0.07) ** 2)
        colour += warm[..., None] * np.array([4, -26, -22])
        spread = np.exp(-(((x - 0.14) / 0.1) ** 2) - ((y - 0.59) / 0.05) ** 2)
        spots = random.random(x.shape) < 0.0016 * spread
        colour -= 900 * _blurred(spots.astype(float), 5)[..., None] * np.array([0.5, 0.8, 0.8])
    image = np.clip(np.rint(colour), 0, 255).astype(np.uint8)
    file = BytesIO()
    as_pillow(image).save(file, "PNG")
    return Texture(file.getvalue(), "lips" if lips else "skin", wrap=("clamp", "clamp"))


def _blurred(values: NDArray[np.float64], reach: int) -> NDArray[np.float64]:
    from scipy.ndimage import gaussian_filter

    return np.asarray(gaussian_filter(values, reach / 2.5))


def draw(path: Path) -> None:
    """Straight, bent, and the distance between them, from the front and from below."""
    with tempfile.TemporaryDirectory() as folder:
        plain, bent = Path(folder) / "character.glb", Path(folder) / "character.bent.glb"
        _write_plain(plain)
        bend(plain, bent)
        before, after = (read_glb(file).pose(SHOWN) for file in (plain, bent))
        mesh = read_glb(plain).neutral
    away = np.linalg.norm(after - before, axis=1)
    scale = ColourScale(round_up(float(away.max())), "distance between them, cm")
    rows = []
    for view in ("front", (65.0, -8.0)):
        camera = camera_for(mesh, view, poses=np.stack([before, after]), size=SIZE)
        with Stage(mesh, camera, size=SIZE) as stage:
            heat = heat_colours(away, scale.highest)
            rows.append(
                [stage.picture(before), stage.picture(after), stage.picture(after, colours=heat)]
            )
    words = ["before: straight", "after: bent", "distance"]
    write_picture(picture_grid(rows, column_labels=words, scale=scale), path)


def _write_plain(path: Path) -> None:
    """A file without anything that elastomorph says of it."""
    import json
    import struct

    from elastomorph.io.gltf.container import glb_chunks

    written = BytesIO()
    write_glb(written, character(), normals="none")
    content = written.getvalue()
    (length,) = struct.unpack_from("<I", content, 12)
    document = json.loads(content[20 : 20 + length])
    document["meshes"][0]["extras"].pop("elastomorph")
    document.pop("animations", None)
    path.write_bytes(b"".join(glb_chunks(json.dumps(document).encode(), content[28 + length :])))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--picture", type=Path, default=Path("docs/character.png"))
    draw(parser.parse_args().picture)
