"""Files of the built-in head, for those who try what the documentation shows."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from elastomorph.curves.network import region_of
from elastomorph.errors import FileError
from elastomorph.io.atomic import made_folder
from elastomorph.io.performance import write_performance_csv
from elastomorph.io.registry import write
from elastomorph.io.sequences import write_sequence
from elastomorph.paths.interpolate import prepare
from elastomorph.rig.performance import Performance
from elastomorph.rig.rig import Rig
from elastomorph.samples import expressions, head, recorded_motion, shapes

# The shapes that examples speak of; more would only take longer.
_NAMES = ("jawOpen", "eyeBlinkLeft", "mouthSmileLeft", "cheekPuff")


def write_samples(path: str | Path) -> list[Path]:
    """Write meshes, rigs, a recording and a take of the built-in head into a folder.

    ``neutral.obj``, ``jawOpen.obj``, ``smile.obj``; the recorded motion as ``scan.####.obj``;
    ``head.glb``, a rig on bent paths, and ``avatar.glb``, straight as other programs write it;
    ``take.csv``, weights over time; ``mouth.json``, vertices of a region; and ``face`` and ``ada``,
    folders of meshes as artists keep them.

    Args:
        path: The folder, made where it is missing.

    Returns:
        The files and folders.

    Raises:
        FileError: It cannot be written in, or one of them is there already.
    """
    folder = made_folder(path)
    motion, targets, neutral = recorded_motion(), shapes(), head()
    to = prepare(neutral, "beam:2")
    chosen = {name: targets[name] for name in _NAMES}
    meshes = {"neutral": motion.neutral, "jawOpen": targets["jawOpen"]}
    meshes["smile"] = expressions()["grinning"]
    names = [*(f"{name}.obj" for name in meshes), "scan.0001.obj", "mouth.json", "head.glb"]
    names += ["avatar.glb", "take.csv", "face", "ada"]
    for name in names:
        if (folder / name).exists():
            raise FileError(folder / name, "this is there already; name an empty or a new folder")
    for name, mesh in meshes.items():
        write(folder / f"{name}.obj", mesh)
    write_sequence(folder / "scan.####.obj", motion)
    (folder / "mouth.json").write_text(str(np.flatnonzero(region_of(neutral, "lips")).tolist()))
    write(folder / "head.glb", Rig(neutral, {name: to(mesh) for name, mesh in chosen.items()}))
    write(folder / "avatar.glb", Rig(neutral, chosen, method="linear"))
    take = Performance(("jawOpen", "eyeBlinkLeft"), np.arange(4) / 30, np.eye(4)[:, :2], 30.0)
    write_performance_csv(folder / "take.csv", take)
    for character in ("face", "ada"):
        made_folder(folder / character)
        for name, mesh in {"neutral": neutral, **chosen}.items():
            write(folder / character / f"{name}.obj", mesh)
    (folder / "face" / "elastomorph.toml").write_text('[methods]\njawOpen = "rotation"\n')
    return [folder / name for name in names]
