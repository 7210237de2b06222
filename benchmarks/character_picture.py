"""A textured character before and after its paths are bent: the picture of the documentation.

Run:  python benchmarks/character_picture.py [--picture docs/character.png]

The character is the built-in head. It is written as other programs write one, without bends, bent
in its own file by `elastomorph.bend`, and read back.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path

import numpy as np

import elastomorph as em
from elastomorph.bending import bend
from elastomorph.draw import Stage, camera_for, heat_colours, picture_grid, write_picture
from elastomorph.draw.pictures import ColourScale, round_up
from elastomorph.io.gltf import read_glb
from elastomorph.samples import head, shapes

sys.path.append(str(Path(__file__).parents[1] / "tests"))
from foreign_files import write_foreign_glb

SHOWN = {"jawOpen": 0.5, "eyeBlinkLeft": 0.5, "eyeBlinkRight": 0.5}
SIZE = (340, 425)


def draw(path: Path) -> None:
    """Straight, bent, and the distance between them, from the front and from below."""
    with tempfile.TemporaryDirectory() as folder:
        plain, bent = Path(folder) / "character.glb", Path(folder) / "character.bent.glb"
        targets = {name: shapes()[name] for name in SHOWN}
        write_foreign_glb(plain, em.Rig(head(), targets, method="linear"))
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


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--picture", type=Path, default=Path("docs/character.png"))
    draw(parser.parse_args().picture)
