"""How long a plate takes: preparation, the first target and each further one.

Run:  python benchmarks/plate_speed.py [--data FOLDER]

Prints, measured in one run on this machine, for a production face (or a small head where the
real rig is missing), for each kind of plate: seconds to prepare a neutral, to make the first and a
further target, and the largest memory the process has had. Below it, how far the lowest modes alone
are from all modes at once.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

import numpy as np

import elastomorph as em
from elastomorph.paths.method import Method
from measuring import data_folder

sys.path.append(str(Path(__file__).parents[1] / "tests"))
from small_head import expressions, head


def faces(folder: Path) -> tuple[str, em.Mesh, em.Mesh, em.Mesh]:
    """A name, a neutral and two targets."""
    rig = folder / "ict-facekit"
    if rig.is_dir():
        names = ("generic_neutral_mesh", "jawOpen", "mouthSmile_L")
        neutral, first, further = (em.read(rig / f"{name}.obj") for name in names)
        return "ICT FaceKit", neutral, first, further
    first, further = list(expressions().values())[:2]
    return "small head", head(), first, further


def peak_memory() -> str:
    """Largest resident memory of this process so far, where the system tells."""
    try:
        import resource
    except ImportError:  # not on Windows
        return "-"
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return f"{peak / (2**30 if sys.platform == 'darwin' else 2**20):.2f} GiB"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, default=data_folder())
    name, neutral, first, further = faces(parser.parse_args().data)
    count = len(neutral.vertices)
    print(f"{name}: {count:,} vertices, {len(neutral.faces):,} polygons\n")
    print(f"{'plate':28} {'prepare':>9} {'first':>9} {'further':>9} {'peak':>10}")

    painted = 1 + 9 * (neutral.vertices[:, 1] > np.median(neutral.vertices[:, 1]))
    thin = em.Material(0.01, 1, 1)
    kinds: list[tuple[str, Method, dict[str, object]]] = [
        ("R = 2", Method("plate", order=2), {}),
        ("R = 3", Method("plate", order=3), {}),
        ("R = 3, complex roots", Method("plate", order=3, material=thin), {}),
        ("R = 2, painted", Method("plate", order=2), {"rigidity": painted}),
        ("R = 3, painted", Method("plate", order=3), {"rigidity": painted}),
        ("R = 2, pinned", Method("plate", order=2), {"pinned": np.arange(0, count, 100)}),
        ("R = 2, 64 modes", Method("plate", order=2, harmonics=64), {}),
        ("R = 2, 200 modes", Method("plate", order=2, harmonics=200), {}),
        ("R = 8, 64 modes", Method("plate", order=8), {}),
    ]
    middles = {}
    for label, method, options in kinds:
        moments = [time.perf_counter()]
        to = method.prepare(neutral, **options)
        moments.append(time.perf_counter())
        path = to(first)
        moments.append(time.perf_counter())
        to(further)
        moments.append(time.perf_counter())
        middles[label] = path.at(0.5)
        spent = " ".join(f"{seconds:7.3f} s" for seconds in np.diff(moments))
        print(f"{label:28} {spent} {peak_memory():>10}", flush=True)

    print()
    for modes in (64, 200):
        gap = np.linalg.norm(middles[f"R = 2, {modes} modes"] - middles["R = 2"], axis=1).max()
        print(f"{modes} modes are within {gap / neutral.diameter:.1e} of D of all of them")


if __name__ == "__main__":
    main()
