"""What the Khronos glTF validator says of a file."""

from __future__ import annotations

import subprocess
from collections import Counter
from pathlib import Path

from needs import WEB, node


def complaints(path: Path) -> Counter[str]:
    """How often it has each complaint; an error is a failure."""
    command = [node("gltf-validator"), str(WEB / "checks" / "validate.mjs"), str(path)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=100, check=False)
    assert ": 0 errors" in done.stdout, done.stdout + done.stderr
    return Counter(
        line.removeprefix(f"{path}: ").split()[1] for line in done.stdout.splitlines()[:-1]
    )
