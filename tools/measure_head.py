"""How far each shape moves the points of a face that an animator looks at.

    python tools/measure_head.py [--rig FOLDER] [--shapes mouthFunnel,mouthPucker]

The built-in head beside ICT FaceKit, or another folder of that topology: lip corner, the middles of
the lips' red borders and of the line where they meet, chin, cheek and jowl of the character's left,
in % of the width of the face in front of the ears: to the left, up and forwards. Shapes of one side
are measured together with those of the other.
"""

from __future__ import annotations

import argparse
import json
import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import elastomorph as em
from elastomorph.samples import head, shapes
from elastomorph.samples.paper_expressions import sided
from sculptor import layout, lips

SHAPES = (
    "jawOpen", "jawForward", "jawLeft", "mouthClose", "mouthFunnel", "mouthPucker", "mouthLeft",
    "mouthSmile", "mouthFrown", "mouthDimple", "mouthStretch", "mouthRollLower", "mouthRollUpper",
    "mouthShrugLower", "mouthShrugUpper", "mouthPress", "mouthLowerDown", "mouthUpperUp",
    "cheekPuff", "cheekSquint", "noseSneer",
)  # fmt: skip
POINTS = ("corner", "upper border", "upper inner", "lower inner", "lower border")
AROUND = ("chin", "cheek", "jowl")
# Numbers of the 68 points that face trackers use, in the list beside ICT FaceKit's meshes.
_OF_68 = dict(zip(POINTS, (54, 51, 62, 66, 57), strict=True)) | {"chin": 8}
_FACE_EDGE, _EYE, _JAW = 15, 45, 13

Points = NDArray[np.float64]


@dataclass(frozen=True)
class Subject:
    """A rig and its points.

    Attributes:
        neutral: (V, 3).
        points: Vertex of each point by its name.
        width: Of the face, in the rig's unit.
        moved: The displacement (V, 3) of a shape, or none where the rig lacks it.
    """

    neutral: Points
    points: dict[str, int]
    width: float
    moved: Callable[[str], Points | None]

    def figures(self, shape: str) -> Points | None:
        """(8, 3) displacements of the points, in % of the width."""
        moved = self.moved(shape)
        if moved is None:
            return None
        return 100.0 / self.width * moved[[self.points[name] for name in (*POINTS, *AROUND)]]


def _on_cheeks(neutral: Points, corner: int, eye: int, jaw: int) -> dict[str, int]:
    """The cheek below the eye, and the jowl half way from the lip corner to the jaw."""

    def nearest(place: Points) -> int:
        off = np.linalg.norm((neutral - place)[:, :2], axis=1) - 0.05 * neutral[:, 2]
        return int(off.argmin())

    corner_at, eye_at, jaw_at = neutral[[corner, eye, jaw]]
    return {
        "cheek": nearest(0.55 * eye_at + 0.45 * corner_at),
        "jowl": nearest(0.5 * (corner_at + jaw_at)),
    }


def built_in() -> Subject:
    """The built-in head."""
    lay, neutral, found = layout.half(), head().vertices, shapes()
    border, inner = lay.mouth[lips.BORDER], lay.mouth[lips.CONTACT]
    mouth = (border[lips.CORNER], border[0], inner[0], inner[-1], border[-1])
    points = {name: int(vertex) for name, vertex in zip(POINTS, mouth, strict=True)}
    points["chin"] = int(lay.grid[layout.MOUTH.bottom + 4, 0])
    ear, jaw = lay.grid[layout.EAR.top + 2, layout.EAR.front], lay.grid[25, 16]
    eye = lay.eye[7, 11]
    points |= _on_cheeks(neutral, points["corner"], int(eye), int(jaw))

    def moved(shape: str) -> Points | None:
        parts = [found[name].vertices - neutral for name in sided(shape, found)]
        return np.sum(parts, axis=0) if parts else None

    return Subject(neutral, points, float(2.0 * neutral[ear, 0]), moved)


def scanned(folder: Path) -> Subject:
    """The rig in a folder with the topology of ICT FaceKit."""
    listed = json.loads((folder / "vertex_indices.json").read_text())["idx_to_landmark_verts"]
    neutral = em.read(folder / "generic_neutral_mesh.obj").vertices
    points = {name: int(listed[number]) for name, number in _OF_68.items()}
    eye, jaw = int(listed[_EYE]), int(listed[_JAW])
    points |= _on_cheeks(neutral, points["corner"], eye, jaw)
    files = {file.stem: file for file in folder.glob("*.obj")}

    def moved(shape: str) -> Points | None:
        parts = [
            em.read(files[name]).vertices - neutral
            for name in (shape, f"{shape}_L", f"{shape}_R")
            if name in files
        ]
        return np.sum(parts, axis=0) if parts else None

    return Subject(neutral, points, float(2.0 * neutral[int(listed[_FACE_EDGE]), 0]), moved)


def _cell(figures: Points | None, point: int) -> str:
    if figures is None:
        return "–"
    return " ".join(f"{value:.1f}" for value in np.round(figures[point], 1) + 0.0)  # no -0.0


def table(rigs: dict[str, Subject], names: tuple[str, ...]) -> str:
    """The figures as a table in Markdown, a row a shape and rig."""
    columns = ("shape", "rig", *POINTS, *AROUND)
    lines = ["| " + " | ".join(columns) + " |", "|---" * len(columns) + "|"]
    for shape in names:
        for label, rig in rigs.items():
            figures = rig.figures(shape)
            cells = [_cell(figures, k) for k in range(len(columns) - 2)]
            lines.append("| " + " | ".join((shape, label, *cells)) + " |")
    return "\n".join(lines)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    data = Path(os.environ.get("ELASTOMORPH_DATA", "data"))
    parser.add_argument("--rig", type=Path, default=data / "ict-facekit")
    parser.add_argument("--shapes", type=lambda text: tuple(text.split(",")), default=SHAPES)
    chosen = parser.parse_args()
    rigs = {"ICT": scanned(chosen.rig)} if chosen.rig.is_dir() else {}
    print(table({**rigs, "built-in": built_in()}, chosen.shapes))


if __name__ == "__main__":
    main()
