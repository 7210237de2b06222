"""What glTF-Transform makes of characters: quantized, compressed, optimized."""

from __future__ import annotations

import subprocess
from pathlib import Path

from needs import WEB, node

VARIANTS = {
    "quantized": ("quantize",),
    "meshopt": ("meshopt",),
    "draco": ("draco",),
    "optimized": ("optimize",),
    "sparse": ("dedup", "sparse"),
    "joined": ("palette", "join", "weld", "reorder"),
}
PACKAGES = ("@gltf-transform/functions", "meshoptimizer", "draco3dgltf")


def variant(source: Path, name: str, folder: Path) -> Path:
    """A character as glTF-Transform writes it; skips the test where that is not installed.

    Args:
        source: The character.
        name: One of `VARIANTS`.
        folder: Receives the file, named after both.
    """
    return transformed(source, folder / f"{source.stem}-{name}.glb", *VARIANTS[name])


def transformed(source: Path, out: Path, *steps: str) -> Path:
    """A file after some steps of ``web/checks/transform.mjs``."""
    script = str(WEB / "checks" / "transform.mjs")
    words = [node(*PACKAGES), script, str(source), str(out), *steps]
    done = subprocess.run(words, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    return out
