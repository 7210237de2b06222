"""One small face in every kind of file that a verb may be given."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np

import elastomorph as em
from elastomorph.io.performance import write_performance_csv
from elastomorph.model.sequence import MeshSequence
from elastomorph.rig.performance import Performance
from foreign_files import write_foreign_glb
from small_meshes import grid

__all__ = ["SIDE", "sheet", "turned", "write_all"]

SIDE = 5


def sheet() -> em.Mesh:
    """A bent sheet of quads."""
    return grid(SIDE, SIDE, lambda x, y: 0.1 * x * y)


def turned(angle: float) -> em.Mesh:
    """The sheet turned about its first edge."""
    x, y, z = sheet().vertices.T
    high, wide = y * np.sin(angle) + z * np.cos(angle), y * np.cos(angle) - z * np.sin(angle)
    return sheet().with_vertices(np.stack([x, wide, high], axis=1))


def write_all(folder: Path) -> None:
    """Every file that the tables of tests name, in one folder.

    The targets are ``jawOpen``, which turns, and ``smile``, which slides.
    """
    targets = {"jawOpen": turned(1.0), "smile": sheet().with_vertices(sheet().vertices + 0.25)}
    face = folder / "face"
    face.mkdir()
    em.write(face / "neutral.obj", sheet())
    for name, mesh in targets.items():
        em.write(face / f"{name}.obj", mesh)
    shutil.copytree(face, folder / "character")
    (folder / "character" / "elastomorph.toml").write_text('[methods]\njawOpen = "arc"\n')
    for name, mesh in {"neutral": sheet(), **targets}.items():
        em.write(folder / f"{name}.obj", mesh)
    to = em.prepare(sheet(), "ease:3")
    ours = em.Rig(sheet(), {name: to(mesh) for name, mesh in targets.items()})
    for suffix in ("glb", "npz", "usda"):
        em.write(folder / f"ours.{suffix}", ours)
    write_foreign_glb(folder / "foreign.glb", ours)
    write_foreign_glb(folder / "foreign.vrm", ours)
    write_foreign_glb(folder / "heads.glb", ours, nodes=("left", "right"))
    straight = {name: em.interpolate(sheet(), mesh, "linear") for name, mesh in targets.items()}
    em.write(folder / "foreign.usda", em.Rig(sheet(), straight))
    text = (folder / "foreign.usda").read_text()
    lines = [line for line in text.split("\n") if "elastomorph:" not in line]
    (folder / "foreign.usda").write_text("\n".join(lines))
    frames = np.stack([(1 - t) * sheet().vertices + t * turned(1.0).vertices for t in _TIMES])
    em.write_sequence(folder / "motion.npz", MeshSequence(sheet(), frames))
    em.write_sequence(folder / "scan.####.obj", MeshSequence(sheet(), frames))
    weights = np.linspace(0, 1, 6)[:, None] * [1.0, 0.5]
    take = Performance(("jawOpen", "smile"), np.arange(6) / 30, weights, 30.0)
    em.write_poses(folder / "poses.csv", {"Rest": {}, "Wide": {"JawOpen": 1.0, "smile": 0.5}})
    write_performance_csv(folder / "take.csv", take)
    _write_take(folder)
    (folder / "curves.json").write_text(json.dumps([[0, 5, 10, 15, 20]]))
    (folder / "part.json").write_text(json.dumps(list(range(12))))
    (folder / "own.toml").write_text('[method]\ndefault = "cosine"\n')


def _write_take(folder: Path) -> None:
    """A rig no turning head is taken for, ``waves``, meshes of its movement, and places."""
    start = sheet().vertices
    x, y, _ = start.T
    ends = {"jawOpen": np.sin(3 * x), "smile": np.cos(2 * y + x)}
    waves = {name: start + end[:, None] * [0.1, 0.0, 1.0] for name, end in ends.items()}
    (folder / "waves").mkdir()
    em.write(folder / "waves" / "neutral.obj", sheet())
    for name, vertices in waves.items():
        em.write(folder / "waves" / f"{name}.obj", sheet().with_vertices(vertices))
    rig = em.read_rig(folder / "waves")
    weights = np.stack([_TIMES, 0.5 * _TIMES**2], axis=1)
    moving = MeshSequence(sheet(), rig.batch(weights, dtype=np.float64))
    em.write_sequence(folder / "wave.####.obj", moving)
    for name, step in (("places", 1), ("moved", 2)):
        vertices = {str(v): v * step for v in (0, 1, 3, 4, 7, 9, 11)}
        content = {"version": 1, "vertices": vertices}
        (folder / f"{name}.json").write_text(json.dumps(content))


_TIMES = np.linspace(0, 1, 5)
