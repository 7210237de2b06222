"""Which code a stage is made by: what another version of it made is made anew."""

from __future__ import annotations

from functools import cache
from hashlib import blake2b
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

_FOLDER = Path(__file__).parents[1]
_MAKERS = _FOLDER / "work" / "makers.py"
# Each imports nothing of those behind it, as pyproject.toml has it too.
_ROOMS = ("geometry", "landmarks", "photographs", "cameras", "tracking", "neutral")
_LIBRARIES = (
    "elastomorph",
    "embreex",
    "numpy",
    "opencv-python-headless",
    "pillow",
    "pycolmap",
    "scipy",
)


@cache
def code_of(room: str) -> str:
    """A digest of a room of code, of those that it may import, and of the libraries' versions.

    What hands the rooms their arguments counts to each; the rest of the package is named by its
    version.

    Args:
        room: Name of its folder, as "tracking".
    """
    digest = blake2b(digest_size=16)
    for library in _LIBRARIES:
        digest.update(f"{library} {_version(library)} ".encode())
    rooms = _ROOMS[: _ROOMS.index(room) + 1]
    files = [file for each in rooms for file in sorted((_FOLDER / each).glob("*.py"))]
    for file in (_MAKERS, *files):
        digest.update(f"{file.parent.name}/{file.name} ".encode() + file.read_bytes())
    return digest.hexdigest()


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return ""
