"""Which code a stage is made by: what another version of it made is made anew."""

from __future__ import annotations

import ast
from functools import cache
from hashlib import blake2b
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

__all__ = ["code_of"]

_ROOM = "elastomorph.capturing"
_FOLDER = Path(__file__).parents[1]
_LIBRARIES = {
    "cv2": "opencv-python-headless",
    "embreex": "embreex",
    "numpy": "numpy",
    "pycolmap": "pycolmap",
    "scipy": "scipy",
}


@cache
def code_of(module: str) -> str:
    """A digest of a module of this room, of those of the room that it imports, and of libraries.

    A change of one stage makes that stage anew and no other; the rest of the package is named by
    its version.

    Args:
        module: Its name below the room, as "tracking.flow".
    """
    found: dict[str, bytes] = {}
    libraries = {"elastomorph"}
    _collect(module, found, libraries)
    if not found:
        raise ModuleNotFoundError(f"{_ROOM}.{module}")
    digest = blake2b(digest_size=16)
    for name in sorted(libraries):
        digest.update(f"{name} {_version(_LIBRARIES.get(name, name))} ".encode())
    for name, content in sorted(found.items()):
        digest.update(name.encode() + content)
    return digest.hexdigest()


def _collect(module: str, found: dict[str, bytes], libraries: set[str]) -> None:
    """Add a module and what it imports, also within functions."""
    file = _FOLDER.joinpath(*module.split(".")).with_suffix(".py")
    if module in found or not file.is_file():
        return
    found[module] = file.read_bytes()
    for node in ast.walk(ast.parse(found[module])):
        names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
        if isinstance(node, ast.ImportFrom) and node.module:
            names = [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)]
        for name in names:
            libraries.update({name.partition(".")[0]} & _LIBRARIES.keys())
            if name.startswith(f"{_ROOM}."):
                _collect(name.removeprefix(f"{_ROOM}."), found, libraries)


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return ""
