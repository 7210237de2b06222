"""How large rigs are as glTF: what the bytes are for, plain and compressed.

Run:  python benchmarks/file_sizes.py [RIG …] [--data FOLDER]

A RIG is a file or a folder; by default the rig of the real data. Each is written with straight
paths and with the paths of ``auto``, with and without normals. Prints MiB, the error of storing as
a fraction of D, bytes beside those of the straight plain file, and, where Node.js with the packages
of ``web`` is there, what three.js puts on a graphics card for the morph targets.
"""

from __future__ import annotations

import argparse
import json
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import elastomorph as em
from elastomorph.io.gltf import GlbReport, write_glb
from measuring import data_folder

WEB = Path(__file__).resolve().parents[1] / "web"
PARTS = ("json", "surface", "positions", "normals", "animations")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("rigs", nargs="*", metavar="RIG")
    parser.add_argument("--data", type=Path, default=data_folder())
    options = parser.parse_args()
    rigs = options.rigs or [options.data / "ict-facekit"]
    for rig in rigs:
        if str(rig) != "built-in" and not Path(rig).exists():
            print(f"{rig} is missing: name a rig, or the real data with --data", file=sys.stderr)
            return 1
        table(rig)
    return 0


def table(path: str | Path) -> None:
    """The sizes of one rig."""
    print(
        f"{Path(path).name}: MiB in all and of parts, targets, error of D, times the plain straight"
    )
    titles = ("all", *PARTS, "targets", "error", "times", "card")
    print(f"{'':<34}" + "".join(f"{title:>11}" for title in titles))
    for normals in ("delta", "none"):
        plain = 0
        for method in ("linear", "auto"):
            rig = em.read_rig(path, method=method)
            for compress in (False, True):
                report, card = written(rig, normals, compress)
                plain = plain or report.bytes
                words = [method, "normals" if normals == "delta" else "no normals"]
                words += ["compressed"] if compress else []
                print(f"  {', '.join(words):<32}" + row(report, plain) + card)


def written(rig: em.Rig, normals: str, compress: bool) -> tuple[GlbReport, str]:
    """What writing the rig reports, and MiB that three.js puts on a graphics card."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "rig.glb"
        report = write_glb(path, rig, normals=normals, compress=compress)  # type: ignore[arg-type]
        if shutil.which("node") is None or not (WEB / "node_modules").exists():
            return report, ""
        command = ["node", str(WEB / "checks" / "morph_textures.mjs"), str(path)]
        told = subprocess.run(command, capture_output=True, check=True)
        return report, f"{json.loads(told.stdout)[str(path)] / 2**20:>11.1f}"


def row(report: GlbReport, plain: int) -> str:
    """The figures of one file."""
    sizes = [report.bytes, *(report.parts.get(part, 0) for part in PARTS)]
    numbers = "".join(f"{size / 2**20:>11.2f}" for size in sizes)
    error = report.rounding_error + report.dropped_error
    return f"{numbers}{report.targets:>11}{error:>11.1e}{report.bytes / plain:>11.2f}"


if __name__ == "__main__":
    sys.exit(main())
