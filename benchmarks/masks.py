"""Face masks without colour, registered to the rig of somebody else, beside their truth.

    python benchmarks/masks.py [SUBJECT …] [--template NAME] [--only MODE …] [--seed 3] [--save NPZ]

Subjects: ``facecap`` (to the ICT rig: parameters were chosen on it) and ``ict`` (to FaceCap's rig:
none was). A mask is the front of the subject's skin, without skull, neck, eyes and teeth: the same
piece of skin in every pose, met by a grid of rays that is turned anew for each pose, with noise of
0.05 % of D and holes; each scan is moved and turned by its own few degrees.

Modes: ``rig`` and ``mesh`` (the template is a rig, or its neutral alone), with 13 landmarks of
0.3 % of D on the first scan alone; ``rig+`` and ``mesh+`` with landmarks on every scan.

For each pose: how far the head was turned from its true place, in degrees, and how far it is where
the truth says which skin is still; the error of what the skin of the mask did, as it is and with
the head put right, beside that of doing nothing, mean in % of D; of vertices that are off by more
than 1 %, how many are flagged, and how many of all are; how many are off by more than 1 % and by
more than the 0.5 % that a flag stands for. Over all poses also how many of those off by more than
1 % are among the 35 % of lowest confidence. The truth of a vertex is the skin that it lies on in
the neutral. Needs the extra ``capture``.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
import warnings
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

sys.path.append(str(Path(__file__).parents[1] / "tools"))

import elastomorph as em
from captured.geometry import closest
from captured.judging import extent, normals_of
from elastomorph.capturing.geometry import Surface
from elastomorph.capturing.landmarks import Landmarks, known_landmarks
from elastomorph.capturing.scans.placing import laid_over, looked_up
from elastomorph.capturing.scans.registration import placing_of
from elastomorph.capturing.scans.scans import read_scan
from elastomorph.capturing.work.registered import FLAGGED
from elastomorph.io.rig_folder import rig_as_stored
from elastomorph.model.geometry import component_of, sides_of
from elastomorph.model.mesh import part_of
from elastomorph.paths.welding import Welding
from measuring import data_folder
from photographs.subdivision import refined

Points = NDArray[np.float64]
Weights = dict[str, float]

POSES: dict[str, Weights] = {
    "neutral": {},
    "jaw": {"jawOpen": 1.0},
    "smile": {"mouthSmile_L": 0.9, "mouthSmile_R": 0.9, "cheekSquint_L": 0.5, "cheekSquint_R": 0.5},
    "laugh": {
        **{"jawOpen": 0.5, "mouthSmile_L": 0.7, "mouthSmile_R": 0.7, "browInnerUp": 0.7},
        **{"noseSneer_L": 0.4, "noseSneer_R": 0.4},
    },
    "pucker": {"mouthPucker": 0.9, "browDown_L": 0.8, "browDown_R": 0.8},
    "aside": {"jawOpen": 0.7, "jawLeft": 0.5, "mouthFunnel": 0.4, "browOuterUp_L": 0.8},
}
FACECAP = {
    **{"nose_tip": 1801, "nose_bridge": 1456, "upper_lip": 1671, "lower_lip": 1732, "chin": 1744},
}
GRID, NOISE, HOLES = (230, 210), 0.0005, 4
CLICKED = 0.003
# Skin that moves by this part of D says a quarter as much of where a head is.
STILL = 0.002
# Vertices that are judged lie this near to the mask, in parts of D, and this far from its border.
NEAR, WITHIN = 0.005, 0.015


@dataclass(frozen=True, eq=False)
class Head:
    """A head with its rig: the face as a template, and its skin as a subject."""

    template: em.Rig
    landmarks: dict[str, int]
    clicked: dict[str, int]
    skin: em.Mesh
    targets: dict[str, Points]


def main() -> int:
    options = arguments()
    for name in options.subjects or ["facecap", "ict"]:
        template = options.template or {"facecap": "ict", "ict": "facecap"}[name]
        subject, target = HEADS[name](), HEADS[template]()
        with tempfile.TemporaryDirectory() as folder:
            truth = Truth(subject, options.seed, Path(folder))
            print(f"\n{name} to the rig of {template}: D = {truth.extent:.2f}", flush=True)
            columns = "turned° known°  off   still nothing  caught  flagged  > 1 %  > .5 %"
            print(f"{'':7}{'pose':9}{columns}")
            for mode in options.only or MODES:
                row(mode, truth, target, options)
    return 0


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("subjects", nargs="*", choices=[[], *HEADS], metavar="SUBJECT")
    parser.add_argument("--template", choices=list(HEADS), help="another head's rig")
    parser.add_argument("--only", nargs="+", choices=MODES, metavar="MODE", help=", ".join(MODES))
    parser.add_argument("--seed", type=int, default=3, help="of noise, holes, clicks and movements")
    parser.add_argument("--save", type=Path, help="a folder for what was registered")
    return parser.parse_args()


class Truth:
    """Scans of a head whose skin is known."""

    def __init__(self, head: Head, seed: int, folder: Path) -> None:
        random, self.folder = np.random.default_rng(seed), folder
        once, quads = refined(head.skin.faces, len(head.skin.vertices))
        twice, quads = refined(quads, once.shape[0])
        refine = twice @ once
        self.triangles = quads.triangles()
        self.poses = {name: refine @ posed(head, own) for name, own in POSES.items()}
        rest = self.poses["neutral"]
        marks = {name: rest[vertex] for name, vertex in head.clicked.items()}
        self.kept = mask(rest, self.triangles, marks)
        used = np.unique(self.triangles[self.kept])
        self.extent = extent(rest[used])
        self.movements: dict[str, tuple[Points, Points]] = {}
        self.scans: dict[str, em.Mesh] = {}
        self.clicks: dict[str, dict[str, tuple[float, ...]]] = {}
        for name, vertices in self.poses.items():
            turn = Rotation.from_rotvec(np.radians(random.normal(size=3) * 2.5)).as_matrix()
            shift = random.normal(size=3) * 0.02 * self.extent
            self.movements[name] = turn, shift
            points, faces = self.scanned(vertices, random)
            self.scans[name] = em.Mesh(points @ turn.T + shift, faces)
            clicked = CLICKED * self.extent * random.normal(size=(len(marks), 3))
            self.clicks[name] = {
                mark: tuple((vertices[vertex] + off) @ turn.T + shift)
                for (mark, vertex), off in zip(head.clicked.items(), clicked, strict=True)
            }

    def files(self) -> list[Path]:
        """The scans as PLY."""
        for name, scan in self.scans.items():
            em.write(self.folder / f"{name}.ply", scan)
        return [self.folder / f"{name}.ply" for name in self.scans]

    def scanned(self, vertices: Points, random: np.random.Generator) -> tuple[Points, Points]:
        """A grid of rays from around the face, torn where the depth jumps."""
        columns, rows = GRID
        own = vertices[np.unique(self.triangles[self.kept])]
        low, high = own.min(axis=0), own.max(axis=0)
        middle = (low + high) / 2 - [0, 0, 0.35 * (high - low)[2]]
        around = np.linspace(-1.75, 1.75, columns)
        up = np.linspace(1.35, -1.35, rows)[:, None]
        ways = np.stack(
            [np.sin(around) * np.cos(up), np.sin(up) + 0 * around, np.cos(around) * np.cos(up)], -1
        )
        ways = ways @ Rotation.from_rotvec(0.3 * random.normal(size=3)).as_matrix().T
        away = 2 * self.extent
        surface = Surface(vertices, self.triangles)
        hits = surface.cast(middle + away * ways, -ways)
        normals = surface.face_normals[np.maximum(hits.triangles, 0)]
        met = hits.met & self.kept[hits.triangles] & (np.einsum("...i,...i", normals, ways) > 0)
        depths = np.where(met, hits.depths, np.nan)
        depths += NOISE * self.extent * random.normal(size=met.shape)
        points = (middle + (away - depths[..., None]) * ways).reshape(-1, 3)
        for _ in range(HOLES):
            centre = points[random.choice(np.flatnonzero(met))]
            far = np.linalg.norm(points - centre, axis=1) > self.extent * random.uniform(
                0.015, 0.04
            )
            met &= np.nan_to_num(far, nan=False).reshape(met.shape).astype(bool)
        number = np.arange(columns * rows).reshape(rows, columns)
        quads = np.stack([number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]], -1)
        quads = quads.reshape(-1, 4)
        faces = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
        faces = faces[met.ravel()[faces].all(axis=1)]
        sides = points[faces] - points[np.roll(faces, 1, axis=1)]
        lengths = np.linalg.norm(sides, axis=2).max(axis=1)
        faces = faces[lengths < 3 * np.median(lengths)]
        used, faces = np.unique(faces, return_inverse=True)
        return points[used], faces.reshape(-1, 3)


def mask(
    rest: Points, triangles: NDArray[np.integer], marks: dict[str, Points]
) -> NDArray[np.bool_]:
    """(T,) the front of a face, from the chin to the forehead, seen from before it."""
    eyes = (marks["left_eye_outer"] + marks["right_eye_outer"]) / 2
    wide = np.linalg.norm(marks["left_eye_outer"] - marks["right_eye_outer"])
    tall = eyes[1] - marks["chin"][1]
    away = (rest[triangles].mean(axis=1) - eyes) / [wide, tall, wide]
    normals = normals_of(rest, triangles)[triangles].mean(axis=1)
    kept = (abs(away[:, 0]) < 0.72) & (abs(away[:, 1] + 0.25) < 0.8) & (away[:, 2] > -0.55)
    return np.asarray(kept & (normals[:, 2] > -0.3))


def posed(head: Head, weights: Weights) -> Points:
    """(V, 3) the skin with straight paths; a target that a rig splits has both its halves."""
    face = head.skin.vertices.copy()
    for name, weight in weights.items():
        for own in (name, f"{name}_L", f"{name}_R"):
            if own in head.targets:
                face += weight * head.targets[own]
    return face


def row(mode: str, truth: Truth, target: Head, options: argparse.Namespace) -> None:
    """Register in one way, and print a line a pose."""
    marked = truth.clicks if mode.endswith("+") else {"neutral": truth.clicks["neutral"]}
    template = target.template if mode.startswith("rig") else target.template.neutral
    start = time.process_time()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", em.ElastomorphWarning)
        try:
            poses = em.register_all(
                truth.files(), template, landmarks=Landmarks(target.landmarks, points=marked)
            )
        except em.CaptureError as problem:
            print(f"{mode:7}refused: {problem}\n", flush=True)
            return
    spent = time.process_time() - start
    if options.save:
        options.save.mkdir(exist_ok=True)
        np.savez(options.save / mode, **{name: own.vertices for name, own in poses.items()})
    results = {name: judged(name, poses, truth) for name in POSES if name != "neutral"}
    for name, (found, off, confidence) in results.items():
        print(
            f"{mode:7}{name:9}{words(found)}  {shown(off, confidence)}"
            f"  {poses[name].figures['correspondence']}",
            flush=True,
        )
    found, off, confidence = zip(*results.values(), strict=True)
    off, confidence = np.concatenate(off), np.concatenate(confidence)
    least = confidence <= np.quantile(confidence, 0.35)
    print(
        f"{mode:7}{'all':9}{words(np.mean(found, axis=0))}  {shown(off, confidence)}"
        f"  worst turn {max(own[0] for own in found):.2f}°;"
        f" {100 * least[off > 1].mean():.0f} % among the 35 % of lowest confidence;"
        f" {spent:.0f} s of processor\n",
        flush=True,
    )


def words(found: Points) -> str:
    turned, known, off, still, nothing = found
    return f"{turned:6.2f} {known:6.2f} {off:6.2f} {still:7.2f} {nothing:7.2f}"


def shown(off: Points, confidence: Points) -> str:
    """Of those off by more than 1 % the flagged, of all the flagged, and how many are off."""
    flagged, far = confidence < FLAGGED, off > 1
    parts = flagged[far].mean() if far.any() else 1.0, flagged.mean(), far.mean()
    return "  ".join(f"{100 * part:5.0f} %" for part in (*parts, (off > 0.5).mean()))


def judged(
    name: str, poses: dict[str, em.Registered], truth: Truth
) -> tuple[Points, Points, Points]:
    """Turns, mean errors and doing nothing in % of D; (N,) errors and (N,) confidence."""
    placing = {own: poses[own].figures["placing"] for own in ("neutral", name)}
    into = {own: back(placing[own], *truth.movements[own]) for own in placing}
    # Both in the frame of the subject's head, each by what was thought of its scan's place, and
    # the pose also by where its scan is in truth.
    rest = into["neutral"](poses["neutral"].vertices)
    now, right = into["neutral"](poses[name].vertices), into[name](poses[name].vertices)
    skin, kept = truth.poses["neutral"], truth.triangles[truth.kept]
    near = closest(rest, skin, kept)
    there = near.on(truth.poses[name], kept)
    before = near.on(skin, kept)
    normals = normals_of(skin, truth.triangles)
    faces = poses["neutral"].faces.triangles()
    alike = np.einsum("ni,ni->n", normals_of(rest, faces), near.on(normals, kept)) > 0.5
    border = border_of(kept)
    far = closest_point(before, skin[border]) > WITHIN * truth.extent
    chosen = (near.distances < NEAR * truth.extent) & alike & far & of_skin(poses["neutral"])
    unit = 100 / truth.extent
    off, still, nothing = (
        unit * np.linalg.norm(own, axis=1)[chosen]
        for own in (now - rest - (there - before), right - rest - (there - before), there - before)
    )
    turn = rotation_between(placing["neutral"], truth.movements["neutral"]).T @ rotation_between(
        placing[name], truth.movements[name]
    )
    turned = np.degrees(Rotation.from_matrix(turn).magnitude())
    moved = np.linalg.norm(there - before, axis=1) / truth.extent
    known = turn @ turned_where_known(poses, name, truth, moved, chosen)
    found = [turned, np.degrees(Rotation.from_matrix(known).magnitude())]
    found += [off.mean(), still.mean(), nothing.mean()]
    return np.array(found), off, poses[name].confidence[chosen]


def turned_where_known(
    poses: dict[str, em.Registered],
    name: str,
    truth: Truth,
    moved: Points,
    chosen: NDArray[np.bool_],
) -> Points:
    """(3, 3) turn of the subject's head that its place changes by if skin that moved is known."""
    placing, turn = placing_of(poses[name]), truth.movements[name][0]
    rest, scan = poses["neutral"], looked_up(read_scan(truth.scans[name]))
    still = 1 / (1 + (moved / STILL) ** 2) ** 2
    laid = laid_over(
        *(rest.vertices[chosen], normals_of(rest.vertices, rest.faces.triangles())[chosen]),
        *(rest.figures["extent"], scan, placing),
        rigid=True,
        reaches=((0.006, 6), (0.003, 8)),
        still=still[chosen],
    )
    return (placing.rotation @ turn).T @ laid.similarity.rotation @ turn


def rotation_between(placing: dict[str, object], movement: tuple[Points, Points]) -> Points:
    return np.array(placing["rotation"]) @ movement[0]


def back(placing: dict[str, object], turn: Points, shift: Points):
    """From the template's place into that of the subject's own head."""
    scale, rotation = placing["scale"], np.array(placing["rotation"])
    moved = np.array(placing["shift"])
    return lambda points: (((points - moved) @ rotation / scale) - shift) @ turn


def border_of(triangles: NDArray[np.integer]) -> NDArray[np.integer]:
    """Vertices at sides of a single triangle."""
    sides = np.sort(
        np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), 1
    )
    edges, counts = np.unique(sides, axis=0, return_counts=True)
    return np.unique(edges[counts == 1])


def closest_point(points: Points, others: Points) -> Points:
    return np.asarray(cKDTree(others).query(points)[0])


def of_skin(pose: em.Mesh) -> NDArray[np.bool_]:
    """(V,) vertices of the largest part: no eyes, no teeth."""
    part = component_of(len(pose.vertices), sides_of(pose.faces.triangles()))
    return part == np.bincount(part).argmax()


def ict() -> Head:
    """The face of the ICT rig."""
    folder = data_folder() / "ict-facekit"
    neutral = em.read(folder / "generic_neutral_mesh.obj")
    face = part_of(neutral, np.arange(9409))
    targets = {
        path.stem: em.read(path).vertices[:9409] - face.vertices
        for path in sorted(folder.glob("*.obj"))
        if path.stem != "generic_neutral_mesh"
    }
    rig = em.Rig(
        face,
        {own: face.with_vertices(face.vertices + d) for own, d in targets.items()},
        method="linear",
    )
    marks = known_landmarks(folder, neutral)
    marks = thirteen(marks)
    return Head(rig, marks, marks, face, targets)


def facecap() -> Head:
    """FaceCap's head; its landmarks by numbers of vertices and by the borders of its eyes."""
    rig = rig_as_stored(data_folder() / "facecap" / "FaceCapHeadGeneric.fbx")
    return of_rig(rig)


def of_rig(rig: em.Rig) -> Head:
    whole = Welding.of(
        rig.neutral, [rig.neutral.vertices + own.delta for own in rig.morphs.values()]
    )
    mesh = whole.neutral
    part = component_of(len(mesh.vertices), sides_of(mesh.faces.triangles()))
    skin = np.flatnonzero(part == np.bincount(part).argmax())
    face = part_of(mesh, skin)
    targets = {name: own.delta[whole.first][skin] for name, own in rig.morphs.items()}
    marks = {name: int(np.flatnonzero(skin == own)[0]) for name, own in FACECAP.items()}
    border = border_of(face.faces.triangles())
    x, y, z = face.vertices.T
    for side, sign in (("left", 1), ("right", -1)):
        lid = border[(y[border] > 1.5) & (sign * x[border] > 0) & (z[border] > 3)]
        marks[f"{side}_eye_outer"] = int(lid[(sign * x[lid]).argmax()])
        marks[f"{side}_eye_inner"] = int(lid[(sign * x[lid]).argmin()])
        lip = border[(y[border] < -4) & (z[border] > 4)]
        marks[f"mouth_{side}"] = int(lip[(sign * x[lip]).argmax()])
        wing = np.linalg.norm(face.vertices - [sign * 1.25, -1.55, 6.6], axis=1)
        marks[f"{side}_nostril"] = int(wing.argmin())
    of_template = {name: int(whole.first[skin[own]]) for name, own in marks.items()}
    return Head(rig, of_template, marks, face, targets)


def thirteen(marks: dict[str, int]) -> dict[str, int]:
    return {name: own for name, own in marks.items() if not name.endswith("_jaw")}


HEADS = {"facecap": facecap, "ict": ict}
MODES = ("rig", "rig+", "mesh", "mesh+")

if __name__ == "__main__":
    sys.exit(main())
