"""What light, number, size, sharpness, skin and stillness are worth: figures for photographers.

    python benchmarks/photographing.py [VARIATION …] [--folder FOLDER] [--to cameras|neutral]

The small head with other proportions is photographed again and again, each time with one thing
otherwise than in the plain case, and its neutral made by `elastomorph capture --to neutral`. A line
says how many cameras were found, how far off they are, how many points of skin they share, and how
far the surface is from the true one over what two photographs show (``captured/judging.py``), in
percent of D. The plain case is 12 photographs of 750 x 1000 from two rings, 50° to either side of
the face. Needs the extra ``capture``; a case takes about a minute of processor.
"""

from __future__ import annotations

import argparse
import shutil
import subprocess
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

sys.path.append(str(Path(__file__).parents[1] / "tools"))

from captured.judging import Judge
from captured.kept import rendered
from captured.outcome import Outcome, camera_errors, into_truth, true_positions
from photographs.sessions import SMALL, Session
from photographs.truth import Truth

PLAIN = replace(SMALL, poses=1, seed=5)


def film(**changes: float) -> Session:
    return replace(PLAIN, film=replace(PLAIN.film, **changes))


# The value that is changed, in words, and the session that has it.
VARIATIONS: dict[str, dict[str, Session]] = {
    "number": {str(n): replace(PLAIN, count=n) for n in (5, 6, 8, 12, 18, 24)},
    "rings": {
        "one, level": replace(PLAIN, rings=(8.0,)),
        "two": PLAIN,
        "two and one from below": replace(PLAIN, rings=(-35.0, *PLAIN.rings), count=18),
        "two to 90 degrees": replace(PLAIN, azimuth=90.0),
        "two to 90 degrees, 20 photographs": replace(PLAIN, azimuth=90.0, count=20),
    },
    "size": {
        "375 x 500": replace(PLAIN, size=(375, 500)),
        "750 x 1000": PLAIN,
        "1500 x 2000": replace(PLAIN, size=(1500, 2000)),
    },
    "noise": {f"{100 * n:g} %": film(noise=n) for n in (0.008, 0.03, 0.06, 0.12)},
    "blur": {f"{b / 2:g} px": film(blur=b) for b in (0.7, 2.0, 4.0, 8.0)},
    "texture": {f"{t:g}": replace(PLAIN, texture=t) for t in (0.0, 0.25, 0.5, 1.0)},
    "stillness": {
        "still": PLAIN,
        "the face by 2 % of a smile": replace(PLAIN, drift=0.02),
        "the face by 10 % of a smile": replace(PLAIN, drift=0.1),
        "the head by 1 degree, plain wall": replace(PLAIN, sway=1.0),
        "the head by 1 degree, in a room": replace(PLAIN, sway=1.0, backdrop="room"),
        "still, in a room": replace(PLAIN, backdrop="room"),
    },
    "exif": {"with a focal length": PLAIN, "without": film(exif=False)},
}


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("variations", nargs="*", metavar="VARIATION", help=", ".join(VARIATIONS))
    parser.add_argument("--folder", type=Path, help="for photographs and results, to be kept")
    parser.add_argument("--to", choices=["cameras", "neutral"], default="neutral")
    options = parser.parse_args()
    chosen = options.variations or list(VARIATIONS)
    if unknown := set(chosen) - set(VARIATIONS):
        parser.error(f"there is no variation {', '.join(sorted(unknown))}")
    print(f"{'':44} {'cameras':>8} {'off, cm':>8} {'points':>7} {'surface, mean / p95':>20}")
    done: dict[Session, str] = {}
    with tempfile.TemporaryDirectory() as temporary:
        place = options.folder or Path(temporary)
        for name in chosen:
            for value, session in VARIATIONS[name].items():
                if session not in done:
                    done[session] = line(session, place / f"{name}-{value}", options.to)
                print(f"{name + ': ' + value:44} {done[session]}", flush=True)
    return 0


def line(session: Session, folder: Path, to: str) -> str:
    """Figures of one case; words where it came to nothing."""
    rendered(session, folder)
    result = folder / "result"
    shutil.rmtree(result, ignore_errors=True)
    command = [
        *(sys.executable, "-m", "elastomorph", "capture", folder, "--output", result, "--to", to),
        *("--template", folder / "template.obj", "--landmarks", folder / "landmarks.json"),
    ]
    run = subprocess.run(command, capture_output=True, text=True)
    if run.returncode:
        return (run.stderr.strip().splitlines() or ["nothing found"])[-1]
    truth, outcome = Truth.load(folder / "truth.npz"), Outcome.read(result)
    found = outcome.cameras["p00"]
    off = camera_errors(found, true_positions(truth, "p00")).mean()
    points = outcome.figures["poses"]["p00"]["points"]
    text = f"{len(found):>3} of {len(truth.files)} {off:8.4f} {points:7,}"
    if "p00" not in outcome.poses:
        return text
    into = into_truth(outcome, truth)
    judge = Judge(truth, into(outcome.poses["p00"]))
    surface = judge.surface()
    chin = 100 * np.mean(judge.material.distances[judge.chin]) / judge.extent
    scale = 100 * abs(1 / into.scale - 1)
    return (
        f"{text} {surface.mean:11.3f} / {surface.p95:.3f}; under the chin {chin:.3f}; "
        f"scale by landmarks {scale:.1f} % off"
    )


if __name__ == "__main__":
    sys.exit(main())
