"""What is left of bent characters after glTF-Transform: a row a file and command.

Run:  python benchmarks/transformed.py FILE… [--synthetic NAME…] [--only COMMAND…]

Each file is bent into a temporary folder, put through the command and read. The table has the
targets and the bends that were read of those there were, how far a vertex is from where it was
with every slider that bends at 1/2, one at a time (fraction of D), and what the reader warned of.
Vertices may have been split, joined or sorted: each is compared with those that were at its place.
Needs Node.js with the packages of ``web``.
"""

from __future__ import annotations

import argparse
import shutil
import subprocess
import tempfile
import warnings
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

import elastomorph as em
from acceptance.tools import synthetic
from elastomorph.rig.build import extent_of

SCRIPT = Path(__file__).parents[1] / "web" / "checks" / "transform.mjs"
COMMANDS = (
    "copy", "dedup", "prune", "flatten", "join", "weld", "unweld", "reorder", "instance", "palette",
    "metalrough", "unlit", "center", "resample", "sparse", "simplify", "quantize", "dequantize",
    "meshopt", "draco", "optimize",
)  # fmt: skip
MOVES = frozenset({"center"})  # commands that put the character somewhere else
_NEAR = 8


@dataclass(frozen=True)
class Outcome:
    """What was read of a file that glTF-Transform had written.

    Attributes:
        targets: How many targets there are, of how many.
        bends: How many bends there are, of how many.
        off: The largest distance of a vertex from where it was, halfway and as a fraction of D.
        said: What the reader warned of.
    """

    targets: tuple[int, int]
    bends: tuple[int, int]
    off: float
    said: tuple[str, ...]


def outcome(bent: Path, command: str, folder: Path) -> Outcome:
    """Put a bent file through a command, read it and compare.

    Raises:
        RuntimeError: glTF-Transform failed.
    """
    # Buffers in files stay in files; a GLB has one.
    out = folder / command / f"{bent.stem}{'.gltf' if bent.suffix == '.gltf' else '.glb'}"
    out.parent.mkdir()
    node = shutil.which("node")
    assert node is not None, "Node.js is not installed"
    words = [node, str(SCRIPT), str(bent), str(out), command]
    done = subprocess.run(words, capture_output=True, text=True, timeout=300)
    if done.returncode:
        raise RuntimeError(f"glTF-Transform {command}: {done.stderr[-500:]}")
    before = em.read_rig(bent)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        after = em.read_rig(out)
    return Outcome(
        (len(set(after.morphs) & set(before.morphs)), len(before.morphs)),
        (_bends(after), _bends(before)),
        _off(before, after, moved=command in MOVES),
        tuple(str(own.message) for own in caught),
    )


def _bends(rig: em.Rig) -> int:
    return sum(len(morph.bends) for morph in rig.morphs.values())


def _off(before: em.Rig, after: em.Rig, *, moved: bool) -> float:
    """How far vertices are from where they were; nearest of those that were at the same place."""
    start, end = before.neutral.vertices, after.neutral.vertices
    if moved:
        end = end - end.min(axis=0) + start.min(axis=0)
    _, near = cKDTree(start).query(end, k=min(_NEAR, len(start)))
    found = 0.0
    for name, morph in before.morphs.items():
        if len(morph.bends) and name in after.morphs:
            aim = morph.at(0.5) - start
            shown = after.morphs[name].at(0.5) - after.neutral.vertices
            apart = np.linalg.norm(aim[near] - shown[:, None], axis=2).min(axis=1)
            found = max(found, float(apart.max()))
    return found / (extent_of(before) or 1.0)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("files", nargs="*", type=Path)
    parser.add_argument("--synthetic", nargs="+", default=[], help="of those that the tests make")
    parser.add_argument("--only", nargs="+", choices=COMMANDS, default=COMMANDS)
    options = parser.parse_args()
    print("| file | command | targets | bends | at 1/2 | warnings |\n|" + " --- |" * 6)
    with tempfile.TemporaryDirectory() as name:
        for number, file in enumerate([*options.files, *synthetic(options.synthetic, Path(name))]):
            folder = Path(name) / f"{number}"
            folder.mkdir()
            bent = folder / file.name
            em.bend(file, bent)
            for command in options.only:
                try:
                    found = outcome(bent, command, folder)
                except (RuntimeError, em.ElastomorphError) as error:
                    print(f"| {file.name} | {command} | | | | {' '.join(str(error).split())} |")
                    continue
                counts = [f"{own[0]} of {own[1]}" for own in (found.targets, found.bends)]
                cells = [file.name, command, *counts, f"{found.off:.1e}", " ".join(found.said)]
                print(f"| {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()
