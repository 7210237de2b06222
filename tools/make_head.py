"""Pack ICT-FaceKit's head, with shapes, materials and a motion of our own, as the built-in head.

    python tools/make_head.py path/to/ict-facekit

The folder holds the OBJ files of ICT-FaceKit (MIT licence): the neutral, 53 shapes of ARKit, and
``vertex_indices.json``. Halves that ARKit does not have are added up, names become ARKit's, and
`tongueOut`, which ICT-FaceKit lacks, is made of its tongue. Positions become whole multiples of a
power of two of a centimetre. Files of ``src/elastomorph/samples`` are replaced.
"""

from __future__ import annotations

import argparse
import json
import shutil
from collections.abc import Mapping, Sequence
from dataclasses import astuple
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

import elastomorph as em
from elastomorph.model.mesh import FaceLabels, part_of
from elastomorph.rig.build import bare_rig, with_paths
from elastomorph.rig.naming import ARKIT, shape_of
from elastomorph.samples import expressions, head, shapes
from paint_head import labels, paint
from record_motion import motion

PLACE = Path(__file__).parents[1] / "src" / "elastomorph" / "samples"
# Of the neutral 2e-6 of its size; of displacements, in 16 bits, 1.2e-5 at most.
UNIT, DELTA_UNIT, BEND_UNIT = 2.0**-14, 2.0**-11, 2.0**-13
COORDINATE = 2.0**-14
LEFT_OUT = ("iris", "unseen")
VERSION = 1  # what elastomorph.samples reads

# Vertices of the mouth's lining that ICT-FaceKit's shapes leave almost 1 % of D behind.
ASTRAY = {"mouthRight": (12307, 12308), "mouthLeft": (13292, 13293)}

# How far eyes turn for shapes that look, in degrees, and the vertices of the eyeballs:
# ICT-FaceKit's shapes move the lids alone.
LOOKS = {"Up": 24.0, "Down": 27.0, "In": 32.0, "Out": 32.0}
EYES = {"Left": slice(21451, 22221), "Right": slice(23021, 23791)}

# The tongue lies along z from its root to its tip; lengths in cm.
TONGUE_ROOT, TONGUE_TIP = 5.0, 9.8
TONGUE_BACK = (0.0, -3.05, 7.4)
TONGUE_JAW = 0.45  # so far the jaw opens to let it out, as a part of jawOpen
Points = NDArray[np.float64]


def read_shapes(folder: Path, neutral: em.Mesh) -> dict[str, Points]:
    """Displacements of the shapes by ARKit's names, in its order."""
    moves: dict[str, Points] = {}
    for file in sorted(folder.glob("*.obj")):
        shape = shape_of(file.stem)
        if shape is None:
            continue
        whole = next((name for name in ("browInnerUp", "cheekPuff") if name in shape), shape)
        move = em.read(file).vertices - neutral.vertices
        moves[whole] = moves.get(whole, 0.0) + move
    for shape, vertices in ASTRAY.items():
        relax(neutral, moves[shape], vertices)
    for side, eye in EYES.items():
        for way in LOOKS:
            moves[f"eyeLook{way}{side}"][eye] = turned_eye(neutral.vertices[eye], way, side)
    moves["tongueOut"] = tongue_out(neutral, moves["jawOpen"])
    return {name: moves[name] for name in ARKIT}


def turned_eye(ball: Points, way: str, side: str) -> Points:
    """Displacement of an eyeball that turns about the centre of the sphere that fits it best."""
    behind = ball[ball[:, 2] < np.median(ball[:, 2])]  # no cornea
    system = np.column_stack([2.0 * behind, np.ones(len(behind))])
    centre = np.linalg.lstsq(system, np.square(behind).sum(axis=1), rcond=None)[0][:3]
    angle = np.radians(LOOKS[way])
    # About x for up and down, about y for the sides; outwards is +x for the left eye.
    axis = {"Up": (-1, 0, 0), "Down": (1, 0, 0), "Out": (0, 1, 0), "In": (0, -1, 0)}[way]
    turn = np.multiply(axis, angle) * (1 if side == "Left" or way in ("Up", "Down") else -1)
    return np.asarray(Rotation.from_rotvec(turn).apply(ball - centre) + centre - ball)


def relax(neutral: em.Mesh, move: Points, vertices: Sequence[int]) -> None:
    """Move some vertices by the mean of their neighbours."""
    for _ in range(20):  # two that are neighbours of each other
        for vertex in vertices:
            edges = neutral.edges[(neutral.edges == vertex).any(axis=1)]
            move[vertex] = move[edges[edges != vertex]].mean(axis=0)


def tongue_out(neutral: em.Mesh, jaw_open: Points) -> Points:
    """Displacement of the tongue over the lower lip, the jaw open a part of the way.

    The tongue is bent as a rod: each cross-section moves from the line through the tongue at rest
    to a longer line over teeth and lip, turns with it, and gets thinner and narrower to the tip.
    """
    target = neutral.with_vertices(neutral.vertices + jaw_open)
    jaw = em.interpolate(neutral, target, "rotation").at(TONGUE_JAW)
    still = np.linalg.norm(jaw_open, axis=1) < 2 * DELTA_UNIT
    jaw[still] = neutral.vertices[still]
    x, y, z = neutral.vertices.T
    along = (z - TONGUE_ROOT) / (TONGUE_TIP - TONGUE_ROOT)
    s = np.clip(along, 0.0, 1.0)
    rest = CubicSpline([0.0, 0.5, 1.0], [-4.0, -3.75, -4.05])(s)
    # Height and depth of the line: over the lower teeth, through the lips, down over the lower one.
    at = np.array([0.0, 0.3, 0.55, 0.75, 0.9, 1.0])
    line = CubicSpline(
        at, [[-4.2, 5.2], [-3.95, 7.9], [-4.5, 10.3], [-5.0, 11.6], [-5.75, 12.3], [-6.5, 12.6]]
    )
    centre, tangent = line(s), line(s, 1)
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    height = (y - rest) * (1.0 - 0.45 * s)
    out = np.stack(
        [
            x * (1.0 + 0.1 * s),
            centre[:, 0] + height * tangent[:, 1],
            centre[:, 1] - height * tangent[:, 0],
        ],
        axis=1,
    )
    share = np.clip((along - 0.1) / 0.35, 0.0, 1.0)
    share = np.where(is_tongue(neutral), share**2 * (3.0 - 2.0 * share), 0.0)[:, None]
    return np.asarray((1.0 - share) * jaw + share * out - neutral.vertices)


def is_tongue(neutral: em.Mesh) -> NDArray[np.bool_]:
    """(V,) the tongue without floor of the mouth and gums: an island of the texture coordinates."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    assert neutral.uv is not None
    faces, corners, count = neutral.faces, neutral.uv.corners, len(neutral.uv.coordinates)
    joined = coo_array(
        (np.ones(len(corners)), (corners, corners[faces.next_corners])), (count,) * 2
    )
    island = connected_components(joined, directed=False)[1][corners]
    back = np.linalg.norm(neutral.vertices - TONGUE_BACK, axis=1).argmin()
    found = np.zeros(len(neutral.vertices), dtype=bool)
    found[faces.indices[island == island[faces.indices == back][0]]] = True
    return found


def whole_units(values: Points, unit: float) -> NDArray[np.int64]:
    """Values as whole multiples of a unit."""
    return np.rint(values / unit).astype(np.int64)


def moved(moves: Mapping[str, Points], unit: float = DELTA_UNIT) -> dict[str, Any]:
    """Displacements in whole units, of the vertices that have any."""
    rows, deltas, counts = [], [], []
    for move in moves.values():
        steps = whole_units(move, unit)
        assert np.abs(steps).max() < 2**15
        rows.append(np.flatnonzero(steps.any(axis=1)).astype(np.uint16))
        # Coordinates one after another, each as the change along the vertices, pack best.
        deltas.append(np.diff(steps[rows[-1]].T, prepend=0).astype(np.int16).ravel())
        counts.append(len(rows[-1]))
    return {
        "names": np.array(list(moves)),
        "unit": np.float64(unit),
        "version": VERSION,
        "counts": np.array(counts, dtype=np.uint16),
        "rows": np.concatenate(rows),
        "deltas": np.concatenate(deltas),
    }


def lips(neutral: em.Mesh, landmarks: Sequence[int]) -> NDArray[np.bool_]:
    """(F,) the polygons of the face between the outer border of the lips and the mouth."""
    from matplotlib.path import Path as Outline

    assert neutral.uv is not None
    assert neutral.materials is not None
    uv = np.zeros((len(neutral.vertices), 2))
    face = neutral.materials.of_face == neutral.materials.names.index("M_Face")
    of_face = np.repeat(face, neutral.faces.sizes)
    uv[neutral.faces.indices[of_face]] = neutral.uv.coordinates[neutral.uv.corners[of_face]][:, :2]
    border = uv[[landmarks[n] for n in (*range(48, 60), 48)]]
    curve = CubicSpline(np.arange(len(border)), border, bc_type="periodic")
    outline = Outline(curve(np.linspace(0, len(border) - 1, 400)))
    middle = np.add.reduceat(uv[neutral.faces.indices], neutral.faces.offsets[:-1], axis=0)
    return np.asarray(face & outline.contains_points(middle / neutral.faces.sizes[:, None]))


def arrays(folder: Path) -> tuple[dict[str, dict[str, Any]], dict[str, bytes]]:
    """What the files hold: arrays by file and name, and images by name."""
    whole = em.read(folder / "generic_neutral_mesh.obj")
    landmarks = json.loads((folder / "vertex_indices.json").read_text())["idx_to_landmark_verts"]
    moves, start, part = read_shapes(folder, whole), whole.vertices, labels(whole)
    frames = motion(start, {name: start + move for name, move in moves.items()}) - start
    # Inner balls of the eyes, and shells that only an engine's own shaders use, stay behind.
    left_out = np.isin(part.of_face, [part.names.index(name) for name in LEFT_OUT])
    kept = np.unique(whole.faces.indices[~left_out[whole.faces.corner_faces]])
    named = em.Mesh(start, whole.faces, materials=part, groups=groups(whole, part, landmarks))
    neutral = part_of(named, kept)
    assert whole.uv is not None
    assert neutral.materials is not None
    assert neutral.groups is not None
    corners = whole.uv.corners[~left_out[whole.faces.corner_faces]]
    used, coordinate = np.unique(corners, return_inverse=True)
    surface = {
        "unit": np.float64(UNIT),
        "version": VERSION,
        "neutral": whole_units(neutral.vertices, UNIT).astype(np.int32),
        "corners": np.diff(neutral.faces.indices, prepend=0).astype(np.int32),
        "sizes": neutral.faces.sizes.astype(np.uint8),
        "coordinates": whole_units(whole.uv.coordinates[used], COORDINATE).astype(np.int32),
        "coordinate_unit": np.float64(COORDINATE),
        "coordinate_corners": np.diff(coordinate, prepend=0).astype(np.int32),
        **label_arrays("material", neutral.materials),
        **label_arrays("group", neutral.groups),
        "landmarks": np.searchsorted(kept, landmarks).astype(np.uint16),
    }
    shown = {name: move[kept] for name, move in moves.items()}
    poses = {str(number): move[kept] for number, move in enumerate(frames) if number}
    return {"neutral": surface, "shapes": moved(shown), "motion": moved(poses)}, paint(whole)


def label_arrays(kind: str, labels: FaceLabels) -> dict[str, Any]:
    """The names that polygons have, and the name of each."""
    used, of_face = np.unique(labels.of_face, return_inverse=True)
    names = np.array([labels.names[number] for number in used])
    return {f"{kind}_names": names, f"{kind}_of_polygon": of_face.astype(np.uint8)}


def groups(neutral: em.Mesh, part: FaceLabels, landmarks: Sequence[int]) -> FaceLabels:
    """The parts with lips apart from the skin, and the eyes apart from each other."""
    own = np.array(part.names, dtype="<U9")[part.of_face]
    first = neutral.vertices[neutral.faces.indices[neutral.faces.offsets[:-1]]]
    own[own == "sclera"] = np.where(first[own == "sclera", 0] > 0, "eye_L", "eye_R")
    own[lips(neutral, landmarks)] = "lips"
    names = tuple(dict.fromkeys(own.tolist()))
    return FaceLabels(names, np.array([names.index(name) for name in own.tolist()], np.int32))


def paths() -> dict[str, Any]:
    """The default paths of the rig, made on the head as it is read from its files.

    Its pair bends are last.
    """
    rig = with_paths(bare_rig(head(), {**shapes(), **expressions()}))
    morphs = rig.morphs.values()
    bends = {f"{name}.{k}": b for name, m in rig.morphs.items() for k, b in enumerate(m.bends)}
    curves = [curve.coefficients[0] for morph in morphs for curve in morph.bend_curves]
    widest = max(map(len, curves))
    # Rounding adds up over the bends of a path, whose curves are at most 1.
    rounding = np.sqrt(3) / 2 * BEND_UNIT / rig.neutral.diameter
    return moved(bends, BEND_UNIT) | {
        "bends": np.array([len(morph.bends) for morph in morphs], dtype=np.uint8),
        "curves": np.array([np.pad(row, (0, widest - len(row))) for row in curves]),
        "methods": np.array([morph.method for morph in morphs]),
        "errors": np.array([m.bake_error + rounding * len(m.bends) for m in morphs]),
        "choices": np.array([astuple(morph.choice) for morph in morphs if morph.choice], float),
        "pairs": np.array([own.drivers for own in rig.pair_bends().values()]),
    }


def write(name: str, content: Mapping[str, Any]) -> None:
    """Write a file of arrays."""
    with (PLACE / f"{name}.npz").open("wb") as file:
        np.savez_compressed(file, **content)


def main() -> None:
    """Write the files."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path, help="the OBJ files of ICT-FaceKit")
    folder = parser.parse_args().folder
    files, images = arrays(folder)
    for name, content in files.items():
        write(name, content)
    for name, image in images.items():
        (PLACE / name).write_bytes(image)
    write("paths", paths())
    for name in ("LICENSE", "CREDITS.md"):
        shutil.copyfile(folder / name, PLACE / "ict-facekit" / name)
    for path in sorted(PLACE.glob("*.*z")) + sorted(PLACE.glob("*.*g")):
        print(f"{path.name}: {path.stat().st_size:,} bytes")


if __name__ == "__main__":
    main()
