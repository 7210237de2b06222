"""A sheet of what each shape of a rig does to the mouth and the eyes.

    python tools/draw_shapes.py -o docs/head-shapes.png
    python tools/draw_shapes.py --beside before.npz --shapes mouthFunnel,mouthPress -o docs/x.png

Each shape alone and at full strength, those of one side together with those of the other, from the
front and from 40 degrees aside; another rig with the same names stands in the row above.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence

import numpy as np

import elastomorph as em
from elastomorph.draw.camera import Camera
from elastomorph.draw.pictures import Image, write_picture
from elastomorph.draw.sheet import picture_grid
from elastomorph.draw.stage import Stage

SIDES = ((0.0, 0.0), (40.0, 0.0))
MOUTH = ((-5.2, 5.2), (-9.2, 0.6), (6.0, 12.0))  # cm around the built-in head's mouth: x, y, z
EYES = ((-6.2, 6.2), (-0.4, 7.2), (6.0, 11.0))
SIZE = {"mouth": (150, 142), "eyes": (150, 92)}
_SHAPES = {"mouth": ("jaw", "mouth", "cheek", "nose", "tongue"), "eyes": ("eye", "brow")}


def pairs(names: Sequence[str]) -> dict[str, list[str]]:
    """The shapes that are drawn together, by the name without a side."""
    found: dict[str, list[str]] = {}
    for name in names:
        directed = name.startswith(("jaw", "mouthLeft", "mouthRight"))
        whole = name if directed else name.removesuffix("Left").removesuffix("Right")
        found.setdefault(whole, []).append(name)
    if "mouthClose" in found and "jawOpen" in names:
        found["jawOpen + mouthClose"] = ["jawOpen", *found.pop("mouthClose")]
    return found


def pictures(rig: em.Rig, poses: Sequence[Sequence[str]], place: str) -> list[list[Image]]:
    """For each pose, the pictures of the mouth or the eyes from each side."""
    box = MOUTH if place == "mouth" else EYES
    corners = np.array([[x, y, z] for x in box[0] for y in box[1] for z in box[2]])
    known = [[name for name in pose if name in rig.names] for pose in poses]
    faces = [rig.pose(dict.fromkeys(pose, 1.0)) for pose in known]
    drawn: list[list[Image]] = [[] for _ in poses]
    for side in SIDES:
        camera = Camera.framing(corners, side, size=SIZE[place], margin=0.0)
        with Stage(rig.neutral, camera, size=SIZE[place]) as stage:
            for row, face in zip(drawn, faces, strict=True):
                row.append(stage.picture(face))
    return drawn


def sheet(rigs: Sequence[em.Rig], names: Sequence[str], place: str, across: int) -> Image:
    """The pictures in rows of so many shapes, the rigs' rows one below the other."""
    poses = pairs(names)
    drawn = [pictures(rig, list(poses.values()), place) for rig in rigs]
    rows: list[list[Image]] = []
    captions: list[list[str]] = []
    for start in range(0, len(poses), across):
        words = list(poses)[start : start + across]
        for number, rows_of_rig in enumerate(drawn):
            rows.append([image for pair in rows_of_rig[start : start + across] for image in pair])
            last = number == len(drawn) - 1
            captions.append([text for word in words for text in (word if last else "", "")])
    return picture_grid(rows, captions=captions, text_size=12)


def main() -> None:
    """Draw the sheet."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--rig", default="built-in")
    parser.add_argument("--beside", help="another rig, drawn above")
    parser.add_argument("--shapes", type=lambda text: text.split(","))
    parser.add_argument("--place", choices=list(SIZE), default="mouth")
    parser.add_argument("--across", type=int, default=5)
    parser.add_argument("-o", "--output", required=True)
    chosen = parser.parse_args()
    rigs = [em.read_rig(file) for file in (chosen.beside, chosen.rig) if file]
    names = [name for name in rigs[-1].names if name.startswith(_SHAPES[chosen.place])]
    if chosen.shapes:
        names = [
            name
            for name in names
            if name.removesuffix("Left").removesuffix("Right") in chosen.shapes
        ]
    write_picture(sheet(rigs, names, chosen.place, chosen.across), chosen.output)


if __name__ == "__main__":
    main()
