"""Registered poses from rendered photographs and scans beside their truth: the table of goals.

    python benchmarks/capture.py [PART …] [--folder FOLDER] [--subject small] [--seed 7] …
    python benchmarks/capture.py --judge PHOTOGRAPHS RESULT

Parts: ``photographs`` (three poses, t = 0, 0.5 and 1: cameras, frames, neutral, displacement,
confidence), ``fixed`` (the same with a fixed rig), ``scans``, ``saharov32`` (real photographs in
the folder of real data), ``eleven`` (eleven poses: time, memory); all unless some are named.
Photographs are rendered by ``tools/photographs`` into ``--folder`` and used again if there.
The small head with the proportions of seed 7 has not been used to choose any parameter; neither
has any photograph of it. Results are read from the files that the commands of the package write and
judged by ``benchmarks/captured``, which defines every figure and shares no code with the package.

``--judge`` prints the same rows for a result that is already there. Needs the extra ``capture``.
"""

from __future__ import annotations

import argparse
import shutil
import sys
import tempfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

sys.path.append(str(Path(__file__).parents[1] / "tools"))

import elastomorph as em
from captured.judging import Judge, Spread
from captured.kept import rendered
from captured.outcome import Outcome, by_surface, camera_errors, read_bundle
from captured.rows import camera_rows, details, pose_rows, scan_errors, scan_flags, shown_in
from captured.running import Run, ran
from captured.table import Row, shown
from elastomorph.capturing.landmarks import Landmarks, write_landmarks
from measuring import data_folder
from photographs.backdrop import Backdrop
from photographs.rendering import Scene
from photographs.scans import scanned
from photographs.sessions import Session, on_template
from photographs.skin import Skin
from photographs.subjects import SUBJECTS, Subject, subject
from photographs.truth import Truth

UNTUNED = 7
FIRST = "p00"


def main() -> int:
    options = arguments()
    if options.judge:
        print(shown(of_result(*options.judge)))
        return 0
    with tempfile.TemporaryDirectory() as temporary:
        place = options.folder or Path(temporary)
        rows: list[Row] = []
        for name in options.parts or PARTS:
            rows += PARTS[name](options, place)
            print(shown(rows), end="\n\n", flush=True)
    return int(any(row.met is False for row in rows))


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("parts", nargs="*", metavar="PART", help=", ".join(PARTS))
    parser.add_argument("--folder", type=Path, help="for photographs and results, to be kept")
    parser.add_argument("--subject", choices=list(SUBJECTS), default="small")
    parser.add_argument("--movement", default="smile")
    parser.add_argument("--seed", type=int, default=UNTUNED)
    parser.add_argument("--count", type=int, default=30, help="photographs of each pose")
    parser.add_argument("--size", type=int, nargs=2, default=(1500, 2000))
    parser.add_argument("--rings", type=float, nargs="+", help="elevations of cameras in degrees")
    parser.add_argument("--judge", type=Path, nargs=2, metavar=("PHOTOGRAPHS", "RESULT"))
    options = parser.parse_args()
    if unknown := set(options.parts) - set(PARTS):
        parser.error(f"there is no part {', '.join(sorted(unknown))}")
    return options


def photographs(options: argparse.Namespace, place: Path, poses: int, rig: str) -> Path:
    """A folder of photographs, rendered where it is not there from the same session."""
    session = Session(
        subject=options.subject,
        movement=options.movement,
        poses=poses,
        count=options.count,
        size=tuple(options.size),
        rig=rig,
        seed=options.seed,
    )
    if options.rings:
        session = replace(session, rings=tuple(options.rings))
    folder = place / f"{options.subject}-{options.seed}-{poses}-{rig}"
    return rendered(session, folder, lambda line: print(f"rendered {line}", flush=True))


def capture(folder: Path, to: str, rig: str) -> Run:
    """Run one more stage of the command over photographs of a folder."""
    return ran(
        *("capture", folder, "--output", folder / "result", "--rig", rig, "--to", to),
        *("--template", folder / "template.obj", "--landmarks", folder / "landmarks.json"),
    )


def of_photographs(options: argparse.Namespace, place: Path, rig: str = "walking") -> list[Row]:
    """Three poses, stage by stage."""
    folder = photographs(options, place, 3, rig)
    shutil.rmtree(folder / "result", ignore_errors=True)
    runs = {to: capture(folder, to, rig) for to in ("cameras", "neutral", "poses")}
    for name, run in runs.items():
        print(f"{rig}, to {name}: {run.processor:.0f} s of processor, {run.gigabytes:.2f} GB")
    return of_result(folder, folder / "result", runs["cameras"])


def of_result(folder: Path, result: Path, run: Run | None = None) -> list[Row]:
    """Rows of a result; those of the last pose, and every pose before them in a line of its own."""
    truth, outcome = Truth.load(folder / "truth.npz"), Outcome.read(result)
    rows = camera_rows(outcome, truth, run)
    if FIRST not in outcome.poses:
        return rows
    for line in details(outcome, truth, FIRST):
        print(line)
    return [*rows, *pose_rows(outcome, truth, max(outcome.poses), FIRST)]


def fixed(options: argparse.Namespace, place: Path) -> list[Row]:
    """Three poses by cameras that stay."""
    return of_photographs(options, place, "fixed")


def eleven(options: argparse.Namespace, place: Path) -> list[Row]:
    """Eleven poses at once: what they take. Two free cores are needed for the time to be one."""
    folder = photographs(options, place, 11, "walking")
    shutil.rmtree(folder / "result", ignore_errors=True)
    run = capture(folder, "poses", "walking")
    rows = of_result(folder, folder / "result")
    text = f"{run.seconds / 60:.0f} min ({run.processor / 60:.0f} of processor), "
    met = run.seconds <= 25 * 60 and run.gigabytes <= 3
    return [*rows, Row("eleven", f"{text}{run.gigabytes:.1f} GB", met)]


def saharov32(options: argparse.Namespace, place: Path) -> list[Row]:
    """Real photographs of a statue with reference cameras: errors of centres, % of the radius."""
    folder = data_folder() / "photos" / "saharov32"
    result = place / "saharov32"
    shutil.rmtree(result, ignore_errors=True)
    ran("capture", folder, "--output", result, "--to", "cameras")
    outcome = Outcome.read(result)
    true, focal = read_bundle(folder)
    (found,) = outcome.cameras.values()
    (lenses,) = outcome.focal.values()
    centres = np.array(list(true.values()))
    radius = np.linalg.norm(centres - centres.mean(axis=0), axis=1).mean()
    off = 100 * camera_errors(found, true).mean() / radius
    (pose,) = outcome.figures["poses"].values()
    pixels = float(np.mean(list(pose["reprojection"].values())))
    text = f"{len(found)}; {pixels:.3f} px; {off:.2f} %; f {np.median(list(lenses.values())):.0f}"
    met = len(found) == 32 and pixels <= 0.25 and off <= 0.7
    return [Row("saharov32", f"{text} px, reference {focal:.0f}", met)]


def scans(options: argparse.Namespace, place: Path) -> list[Row]:
    """Three poses as scans of another topology, plain and with a texture."""
    person = subject(options.subject, options.seed)
    session = Session(
        subject=options.subject, movement=options.movement, poses=3, count=1, seed=options.seed
    )
    truth = Truth.of(session, person)
    plain = registered(options, place, person, truth, texture=0)
    by_rig = registered(options, place, person, truth, texture=0, rig=True)
    rich = registered(options, place, person, truth, texture=2048)
    text = f"{by_rig[1]:.2f} with the rig; {plain[1]:.2f} with landmarks alone"
    return [
        Row("untextured", text, by_rig[1] <= 0.5 and plain[1] <= 1.2),
        Row("textured", f"{rich[0]:.3f}; {rich[1]:.3f} with what hides", rich[0] <= 0.1),
    ]


def registered(
    options: argparse.Namespace,
    place: Path,
    person: Subject,
    truth: Truth,
    *,
    texture: int,
    rig: bool = False,
) -> tuple[float, float]:
    """Mean error of the last pose of scans with a texture so wide, 0 for none: shown, and all.

    A rig is that of the template's own face: its expressions, not those of the subject.
    """
    folder = place / f"scans-{options.subject}-{options.seed}-{texture}"
    folder.mkdir(parents=True, exist_ok=True)
    files, surfaces = [], []
    for number, (name, vertices) in enumerate(truth.vertices.items()):
        scene = Scene(person.surface, vertices, Skin(options.seed), Backdrop())
        files.append(folder / f"{name}.obj")
        scan = scanned(scene, person.aim, number, texture=texture)
        scan.save(files[-1])
        surfaces.append((scan.vertices, scan.triangles))
    write_landmarks(folder / "landmarks.json", clicked_on_scans(person, truth, options.seed))
    template = folder / ("template.glb" if rig else "template.obj")
    own = em.Rig(person.template, person.expressions(), method="linear") if rig else None
    em.write(template, own or person.template)
    shutil.rmtree(folder / "result", ignore_errors=True)
    run = ran(
        *("register", *files, "--template", template),
        *("--landmarks", folder / "landmarks.json", "--output", folder / "result"),
    )
    kind = f"scans, texture {texture}{', rig' if rig else ''}"
    print(f"{kind}: {run.processor:.0f} s of processor, {run.gigabytes:.2f} GB")
    outcome = Outcome.read(folder / "result")
    into = by_surface(outcome.poses[FIRST], truth)
    judge = Judge(truth, into(outcome.poses[FIRST]), FIRST)
    last = max(outcome.poses)
    own, place = into(outcome.poses[last]), dict(zip(truth.vertices, surfaces, strict=True))
    before, after = (shown_in(judge, name, *place[name]) for name in (FIRST, last))
    shown, every = scan_errors(judge, last, own, before & after)
    near = 100 * judge.material.distances[judge.front & before] / judge.extent
    print(f"  neutral surface {Spread.of(near)}")
    print(f"  {last} shown by both scans ({shown.count}) {shown}; all ({every.count}) {every}")
    print(f"  confidence: {scan_flags(judge, last, own, outcome.confidence[last], before)}")
    return shown.mean, every.mean


def clicked_on_scans(person: Subject, truth: Truth, seed: int) -> Landmarks:
    """The landmarks of the template, and clicks on every scan, 0.08 cm off."""
    random = np.random.default_rng([seed, 20])
    chosen = list(person.landmarks.values())
    points = {
        f"{name}.obj": {
            landmark: tuple(place + 0.08 * random.normal(size=3))
            for landmark, place in zip(person.landmarks, vertices[chosen], strict=True)
        }
        for name, vertices in truth.vertices.items()
    }
    return Landmarks(on_template(person), points=points)


PARTS: dict[str, Callable[[argparse.Namespace, Path], list[Row]]] = {
    "photographs": of_photographs,
    "fixed": fixed,
    "saharov32": saharov32,
    "scans": scans,
    "eleven": eleven,
}


if __name__ == "__main__":
    sys.exit(main())
