"""Recorded markers of a real face on a rig of another: what is left, and what the face does.

The takes are ``animface``, jaw and eyebrows, with the places of its 41 markers on the ICT rig
chosen by hand.

    python benchmarks/tracking.py --picture docs/tracking.png
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path
from typing import Any

import numpy as np

import elastomorph as em
from elastomorph.capturing.landmarks import read_landmarks
from elastomorph.draw import drag_picture
from elastomorph.rig.tracking import Tracked
from measuring import data_folder

PLACES = Path(__file__).with_name("animface_places.json")
# A frame of each take with the face at rest, and those that are drawn.
TAKES = {"jaw": (1545, (441, 1120)), "eyebrows": (318, (511,))}
PRIORS = (1e-4, 1e-3)
USED = 0.1


def told(name: str, prior: float, found: Tracked, moved: float, seconds: float) -> str:
    most = np.argsort(-found.weights.max(axis=0))[:6]
    return (
        f"{name}, prior {prior:g}: {found}\n"
        f"  markers move by {moved:.3g} (RMS); {(found.weights > USED).sum(axis=1).mean():.1f} "
        f"sliders above {USED} in a frame, {found.weights[:, eyes(found)].mean():.3f} the mean of "
        f"those of the eyes; {seconds:.1f} s\n  most: "
        + ", ".join(f"{found.names[i]} {found.weights[:, i].max():.2f}" for i in most)
    )


def eyes(found: Tracked) -> list[int]:
    """Sliders that no marker tells: those that turn the eyes."""
    return [i for i, name in enumerate(found.names) if name.startswith("eyeLook")]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--data", type=Path, default=data_folder())
    parser.add_argument("--picture", type=Path)
    options = parser.parse_args()
    rig = em.read_rig(options.data / "ict-facekit")
    places: dict[str, Any] = dict(read_landmarks(PLACES).vertices)
    vertices = list(places.values())
    pictures = []
    for name, (rest, shown) in TAKES.items():
        taken = em.read_markers(options.data / "animface" / f"{name}.npz").of(places)
        for prior in PRIORS:
            start = time.process_time()
            found = rig.track(taken, vertices, rest=rest, prior=prior)
            seconds = time.process_time() - start
            still = np.einsum("fmi,fij->fmj", taken - found.offsets[:, None], found.rotations)
            moves = (still - still[rest]) / found.scale
            moved = float(np.sqrt(np.square(moves).sum(axis=2).mean()))
            print(told(name, prior, found, moved, seconds))
        for frame in shown if options.picture else ():
            goals = dict(zip(vertices, rig.neutral.vertices[vertices] + moves[frame], strict=True))
            weights = dict(zip(found.names, found.weights[frame], strict=True))
            faces = {"rest": rig.neutral.vertices, name: rig.pose(weights)}
            views = ("front", (50.0, 0.0))
            size = (240, 300)
            pictures.append(drag_picture(rig.neutral, goals, faces, views=views, face=size))
    if options.picture:
        from PIL import Image

        Image.fromarray(np.concatenate(pictures, axis=1)).quantize(128).save(options.picture)


if __name__ == "__main__":
    main()
