"""Lips that jawOpen and mouthClose should keep shut, without their pair bend and with it.

Run:  python benchmarks/pair_picture.py [--picture docs/pair-bend.jpg]

Both sliders are at a half, on the FaceCap head (MIT licence, Niels Jansson) of the folder of real
data. Light comes from the side, which shows what is open.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

import elastomorph as em
from elastomorph.draw import Stage, picture_grid, stage, write_picture
from elastomorph.draw.camera import Camera
from measuring import data_folder

SHOWN = {"jawOpen": 0.5, "mouthClose": 0.5}
SIZE = (340, 210)
LIGHTS = (
    ((-1.0, 0.25, 0.35), 0.85, (1.0, 0.99, 0.97)),
    ((0.85, 0.10, 0.70), 0.2, (0.96, 0.98, 1.0)),
)


def draw(path: Path) -> None:
    """Straight, bent, and bent with the pair bend."""
    rig = em.read_rig(data_folder() / "facecap" / "FaceCapHeadGeneric.fbx")
    targets = {name: rig[name] for name in SHOWN}
    straight = em.Rig(rig.neutral, {n: m.target for n, m in targets.items()}, method="linear")
    poses = [each.pose(SHOWN) for each in (straight, em.Rig(rig.neutral, targets), rig)]
    moved = np.linalg.norm(rig["mouthClose"].delta, axis=1)
    camera = Camera.framing(poses[0][moved > 0.4 * moved.max()], size=SIZE)
    stage.LIGHTS = LIGHTS
    with Stage(rig.neutral, camera, size=SIZE) as drawn:
        row = [drawn.picture(pose) for pose in poses]
    words = ["straight", "bent", "bent, with a pair bend"]
    write_picture(picture_grid([row], column_labels=words), path)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--picture", type=Path, default=Path("docs/pair-bend.jpg"))
    draw(parser.parse_args().picture)
