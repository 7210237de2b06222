"""Runs the checks of ``web``: the Khronos validator, and three.js without a browser."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
from glb_samples import chunks_of

from elastomorph.io.gltf.mesh_extras import unpacked
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
    """(V, 3) positions three.js computes for the vertices of the face, in their order."""
    out = path.with_suffix(".f32")
    done = run(node, "pose.mjs", path, out, *arguments)
    assert done.returncode == 0, done.stdout + done.stderr
    found = np.fromfile(out, dtype="<f4").reshape(-1, 3)
    assert len(found) == json.loads(done.stdout)["vertices"]
    stored = [mesh["extras"].get("elastomorph", {}) for mesh in chunks_of(path)[0]["meshes"]]
    if "part" not in stored[0]:
        return found.astype(float)
    counts = [mesh["count"] for mesh in meshes_of(path)]
    rows = [unpacked(s["part"]["vertices"], n) for s, n in zip(stored, counts, strict=True)]
    whole = np.empty((stored[0]["whole"]["vertices"], 3))
    whole[np.concatenate(rows)] = found
    return whole


def meshes_of(path: Path) -> list[dict[str, Any]]:
    """The accessor of the positions of each mesh."""
    document = chunks_of(path)[0]
    places = [m["primitives"][0]["attributes"]["POSITION"] for m in document["meshes"]]
    return [document["accessors"][place] for place in places]
