"""What the paper compares with, on the same faces: errors and costs in one table each.

Run:  python benchmarks/rivals.py [--data FOLDER] [--only built-in|hinge|takes ...]

Tables in Markdown, as `docs/rivals.md` has them. The built-in motion, with every figure of
``evaluate``; the jaw of the built-in head, whose teeth and gums have a known arc; the movements of
both marker takes, which have no surface. Each rival runs in a process of its own with one thread;
times are of the processor, memory is beyond what the recording takes.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

import elastomorph as em
from elastomorph.draw.camera import camera_for
from elastomorph.draw.sheet import Face, face_sheet, in_rows
from elastomorph.errors import ElastomorphError
from elastomorph.evaluation import Evaluation, ShapeProbe, evaluate
from elastomorph.evaluation.movements import evaluate_movements
from elastomorph.evaluation.rigid_bodies import find_hinge, find_rigid_parts, hinge_errors
from elastomorph.evaluation.summary import mean_summaries, summaries
from elastomorph.evaluation.table import number_text
from elastomorph.io.sequences import read_recording
from elastomorph.model.geometry import connected_parts
from elastomorph.paths import Method
from elastomorph.rivals import RIVALS, Cost, with_rivals
from elastomorph.rivals.comparison import (
    OWN,
    OwnMethod,
    cost_of,
    cost_texts,
    run,
    run_apart,
    through_poses,
)
from elastomorph.samples import head, recorded_motion, shapes
from measuring import data_folder
from real_capture import marker_curves

TAKES = ("jaw", "eyebrows")
TIMES = np.array([0.0, 0.25, 0.5, 0.75, 1.0])
ERRORS = {"LME": "lme", "LAE": "lae", "path LME": "path_lme", "path LAE": "path_lae"}
SURFACE = {"seam": "seam", "flips": "flips"}
COSTS = ("first face", "each further", "MiB", "ends")
# Those whose whole face stands for "the skin about a jaw".
SOLID = "elastic-solid"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, default=data_folder())
    parser.add_argument("--only", nargs="*", choices=("built-in", "hinge", "takes"))
    parser.add_argument("--picture", type=Path, help="draw the faces of the built-in motion here")
    options = parser.parse_args()
    parts = options.only or ("built-in", "hinge", "takes")
    if "built-in" in parts:
        built_in(options.picture)
    if "hinge" in parts:
        jaw(head(), shapes()["jawOpen"])
    takes = [options.data / "animface" / f"{name}.npz" for name in TAKES]
    if "takes" in parts and all(take.is_file() for take in takes):
        markers(takes)


def built_in(picture: Path | None) -> None:
    """Every figure of an evaluation, and what each face costs."""
    motion = recorded_motion()
    found = with_rivals(evaluate(motion, OWN), RIVALS, progress=say)
    costs = {cost.label: cost for cost in found.costs}
    rows = []
    for line in summaries(found.evaluation):
        figures = [number_text(line, name) for name in (ERRORS | SURFACE).values()]
        rows.append([f"`{line.label}`", *figures, *cost_texts(costs[line.label])])
    table("the built-in motion", ("", *ERRORS, *SURFACE, *COSTS), rows)
    print(*found.sentences(), sep="\n")
    if picture is not None:
        draw(found.evaluation, picture)
    objection(found.evaluation)
    closed_form(found.evaluation)
    if found.evaluation.results[-1].label == SOLID:
        about_the_jaw(found.evaluation)


def draw(found: Evaluation, path: Path) -> None:
    """The recorded face and that of each, where the straight line is farthest off."""
    truth, frame = found.truth, int(found["linear"].maximum.max(axis=0).argmax())
    time, size = float(truth.times[frame]), (300, 375)
    faces = [Face(truth.frames[frame], f"recorded, t = {time:g}")]
    for result in found.results:
        words = f"{result.label}\n{100 * result.maximum[:, frame].max():.2f} % of D"
        faces.append(Face(result.morph.at(time), words))
    poses = np.stack([face.vertices for face in faces])
    camera = camera_for(truth.mesh, "three-quarter", poses=poses, size=size)
    face_sheet(truth.mesh, in_rows(faces, 6), camera, size, path)


def objection(found: Evaluation) -> None:
    """The paper's Sec. 4.3: what is lost at the known ends, and whether anything is won."""
    linear, patches = (found[label].maximum.max(axis=0) for label in ("linear", "pde-surface"))
    ratios = patches[1:-1] / linear[1:-1]
    below = np.count_nonzero(patches < linear)
    print(
        f"\npde-surface misses the neutral by {patches[0]:.3%} and the target by {patches[-1]:.3%} "
        f"of D, linear neither; its LME in a frame is {ratios.min():.2f} to {ratios.max():.2f} "
        f"times that of linear, below it in {below} of {len(linear)} frames."
    )
    truth, own = found.truth, found["pde-surface"].morph
    nearer = [
        np.linalg.norm(own.at(time) - frame, axis=1)
        < np.linalg.norm(found["linear"].morph.at(time) - frame, axis=1) - 1e-9
        for time, frame in zip(truth.times, truth.frames, strict=True)
    ]
    print(f"Single vertices are nearer by chance: {np.mean(nearer):.1%} of all.")


def closed_form(found: Evaluation) -> None:
    """How far both numerical solutions are from the beam that they solve."""
    for label in ("finite-difference", "finite-element"):
        off = [
            np.abs(found[label].morph.at(t) - found["beam R=2"].morph.at(t)).max()
            for t in found.truth.times
        ]
        print(f"{label} is within {max(off) / found.diameter:.4%} of D of beam R=2.")


def about_the_jaw(found: Evaluation) -> None:
    """The skin about the jaw: how far our paths are from the one of the solid, halfway."""
    mesh = found.truth.mesh
    skin = max(connected_parts(len(mesh.vertices), mesh.edges), key=len)
    moved = skin[(np.abs(found["linear"].morph.delta[skin]) > 0.01 * found.diameter).any(axis=1)]
    solid = found[SOLID].morph.at(0.5)[moved]
    print(f"\nhalfway, {len(moved):,} vertices of skin that move by 1 % of D, from {SOLID}:")
    for label in ("linear", "arc", "auto"):
        away = np.linalg.norm(found[label].morph.at(0.5)[moved] - solid, axis=1) / found.diameter
        print(f"  {label:<8} mean {away.mean():.3%}, largest {away.max():.3%} of D")


def jaw(neutral: em.Mesh, target: em.Mesh) -> None:
    """How far each leaves the true arc of teeth and gums, what folds, and what it costs."""
    parts = find_rigid_parts(neutral, target)
    assert parts is not None
    hinge, curves = find_hinge(neutral, target, parts), em.extract_curves(neutral)
    recording = em.MeshSequence(neutral, [neutral.vertices, target.vertices])
    nobody = np.zeros(len(neutral.vertices), dtype=np.int64)
    probe = ShapeProbe.of(neutral, recording.target, nobody)
    rows = []
    for rival in [*(OwnMethod(Method.parse(text)) for text in OWN), *RIVALS]:
        if rival.informed:
            continue
        say(rival.label)
        try:
            made = run_apart(rival, recording, curves, TIMES)
        except ElastomorphError as error:
            print(f"{rival.label} is left out: {error}")
            continue
        path = through_poses(neutral, made.poses, TIMES, rival.label)
        (off,) = hinge_errors(hinge, {rival.label: path})
        flips = max(probe.flips(pose) for pose in made.poses)
        cost = cost_of(rival, made, recording, neutral.diameter)
        figures = [f"{100 * off.parts:.3f}", f"{100 * off.along:.3f}", str(flips)]
        rows.append([f"`{rival.label}`", *figures, *cost_texts(cost)])
    title = f"jawOpen, {len(neutral.vertices):,} vertices"
    table(title, ("", "teeth", "gums", "flips", *COSTS), rows)


def markers(takes: Iterable[Path]) -> None:
    """The means over all movements, where a rival can do without a surface."""
    evaluations: list[Evaluation] = []
    costs: dict[str, list[Cost]] = {}
    left_out: dict[str, str] = {}
    own = [text for text in OWN if not Method.parse(text).on_surfaces]
    for path in takes:
        take = read_recording(path)
        network = marker_curves(take.names)
        for one in evaluate_movements(take.motion, network, lambda _: own):
            found = with_rivals(one.evaluation, RIVALS, own=own, runner=run)
            evaluations.append(found.evaluation)
            left_out |= found.left_out
            for cost in found.costs:
                costs.setdefault(cost.label, []).append(cost)
    rows = []
    for line in mean_summaries(evaluations):
        each = costs[line.label]
        first, further = (
            1e3 * np.mean([getattr(c, k) for c in each]) for k in ("first", "further")
        )
        ends = f"{100 * max(cost.ends for cost in each):.3f}"
        figures = [number_text(line, name) for name in ERRORS.values()]
        rows.append([f"`{line.label}`", *figures, f"{first:.1f} ms", f"{further:.2f} ms", ends])
    headers = ("", *ERRORS, "first face", "each further", "ends")
    table(f"{len(evaluations)} movements of markers, means", headers, rows)
    for label, why in left_out.items():
        print(f"{label} is left out: {why}.")


def table(title: str, headers: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    print(f"\n{title}\n\n| {' | '.join(headers)} |\n|{'---|' * len(headers)}")
    for row in rows:
        print(f"| {' | '.join(row)} |")
    sys.stdout.flush()


def say(what: str) -> None:
    print(what, file=sys.stderr, flush=True)


if __name__ == "__main__":
    main()
