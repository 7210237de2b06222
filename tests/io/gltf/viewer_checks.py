"""Runs the checks of ``web``: the Khronos validator, and three.js without a browser."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import numpy as np

from needs import WEB


def run(node: str, script: str, *arguments: str | Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [node, str(WEB / "checks" / script), *map(str, arguments)],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )


def validated(node: str, *paths: Path) -> str:
    """What the validator prints; an error or a warning is a failure."""
    done = run(node, "validate.mjs", *paths)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def drawn(node: str, path: Path, *arguments: str) -> np.ndarray:
    """(V, 3) positions three.js computes for the vertices of the mesh."""
    out = path.with_suffix(".f32")
    done = run(node, "pose.mjs", path, out, *arguments)
    assert done.returncode == 0, done.stdout + done.stderr
    found = np.fromfile(out, dtype="<f4").reshape(-1, 3)
    assert len(found) == json.loads(done.stdout)["vertices"]
    return found.astype(float)
