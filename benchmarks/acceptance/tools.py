"""What Node.js programs say of files: the Khronos validator, and decoders of meshopt and Draco."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from collections import Counter
from collections.abc import Iterable
from pathlib import Path

from acceptance.gltf_file import GltfFile

CHECKS = Path(__file__).parents[2] / "web" / "checks"
_ISSUE = re.compile(r": (error|warning|information|hint) (\S+) at (.*?): ")


def unpacked(path: Path, folder: Path) -> GltfFile:
    """A file whose arrays can be read: itself, or with what is compressed decoded by others."""
    file = GltfFile.read(path)
    if not file.packed:
        return file
    plain = folder / f"{path.stem}-{path.suffix[1:]}-plain.gltf"
    _run("unpack.mjs", str(path), str(plain))
    return GltfFile.read(plain)


def synthetic(names: Iterable[str], folder: Path) -> list[Path]:
    """Some of the characters that the tests make, by name."""
    sys.path.append(str(CHECKS.parents[1] / "tests" / "characters"))
    from character_makers import make

    return [make(name, folder) for name in names]


def issues(path: Path) -> Counter[str]:
    """How often the Khronos validator says what of a file, by severity and code."""
    said = _run("validate.mjs", str(path), may_fail=True)
    return Counter(
        f"{found[1]} {found[2]}" for line in said.splitlines() if (found := _ISSUE.search(line))
    )


def new_issues(original: Path, bent: Path) -> list[str]:
    """What the validator says more often of a bent file than of the original.

    That the validator knows an extension in part only is no fault of the file.
    """
    more = issues(bent) - issues(original)
    del more["information INCOMPLETE_EXTENSION_SUPPORT"]
    return [f"the validator finds {count} more: {what}" for what, count in more.items()]


def _run(script: str, *words: str, may_fail: bool = False) -> str:
    program = shutil.which("node")
    if program is None:
        raise FileNotFoundError("Node.js is not installed")
    done = subprocess.run(
        [program, str(CHECKS / script), *words], capture_output=True, text=True, timeout=300
    )
    if done.returncode and not (may_fail and done.stdout):
        raise RuntimeError(f"{script} {' '.join(words)}: {done.stderr[-500:]}")
    return done.stdout
